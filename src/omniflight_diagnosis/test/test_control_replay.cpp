// Gains of a logged command against those told, for position and attitude.
#include <gtest/gtest.h>

#include <cmath>

#include "../src/sensor_checks/control_replay.hpp"
#include "omniflight_core/frames.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kStep = 0.008, kDuration = 60;  // s

ToldController usual() {
  return {Vec3::Constant(12),  Vec3::Constant(6),  Vec3::Constant(12),
          Vec3::Constant(100), Vec3::Constant(20), Vec3::Constant(20)};
}

struct World {
  double power = 1;        ///< bends the feedback into another law
  double turbulence = 1;   ///< times the usual
  double rock = 0;         ///< rad, amplitude of a reference that rolls once a second; 0: it stands still
  double late = 0;         ///< s, the measured attitude carries the stamp of this much later
  double late_gyro = 0;    ///< s, the same of the gyro
  double limit = 1e9;      ///< rad/s2, of what is asked about an axis; integrals wait there
  double knock = 0;        ///< rad/s2 about all axes for half a second
  bool estimates = false;  ///< the state that is controlled is recorded beside the measured one
};

/// A free body in turbulence that follows its reference with these gains.
recording::Recording flown(const ToldController& gains, const World& world = {}) {
  recording::Recording r;
  const auto put = [&](const char* name, double t, const Eigen::VectorXd& x) {
    recording::Signal& s = r.signals[name];
    s.name = name;
    s.t_s.push_back(t);
    s.values.conservativeResize(static_cast<Eigen::Index>(s.t_s.size()), x.size());
    s.values.bottomRows(1) = x.transpose();
  };
  Random random(7, "control");
  const auto noise = [&](double rms) {
    return Vec3(rms * random.normal(), rms * random.normal(), rms * random.normal());
  };
  Vec3 p = Vec3::Zero(), v = Vec3::Zero(), w = Vec3::Zero(), sum = Vec3::Zero(), turned = Vec3::Zero();
  Vec3 wind = Vec3::Zero(), twist = Vec3::Zero();
  Quat q = Quat::Identity();
  const auto bend = [&](const Vec3& x) -> Vec3 {
    return world.power == 1 ? x : Vec3(x.array().sign() * x.array().abs().pow(world.power));
  };
  for (double t = 0; t < kDuration; t += kStep) {
    const double f = 2 * kPi;  // rad/s
    const Vec3 w_ref(world.rock * f * std::cos(f * t), 0, 0),
        dw_ref(-world.rock * f * f * std::sin(f * t), 0, 0);
    const Quat goal = exp_rotation(Vec3(world.rock * std::sin(f * t), 0, 0));
    const Mat3 R_BD = (q.conjugate() * goal).toRotationMatrix();
    const Vec3 e_R = vee(R_BD), e_w = R_BD * w_ref - w;
    sum -= p * kStep;
    const Vec3 before = turned;
    turned += e_R * kStep;
    Vec6 command;
    command << bend(-gains.kp.cwiseProduct(p) - gains.kv.cwiseProduct(v) + gains.ki.cwiseProduct(sum)),
        R_BD * dw_ref +
            bend(gains.kR.cwiseProduct(e_R) + gains.kw.cwiseProduct(e_w) + gains.kI.cwiseProduct(turned));
    for (int k = 0; k < 3; ++k) {
      double& asked = command[3 + k];
      if (std::abs(asked) > world.limit) asked = std::copysign(world.limit, asked), turned[k] = before[k];
    }
    const auto coefficients = [](const Quat& x) { return Eigen::Vector4d(x.w(), x.x(), x.y(), x.z()); };
    put("position", t, p + noise(0.0002));
    put("attitude", t + world.late, coefficients(q * exp_rotation(noise(0.0008))));
    put("gyro", t + world.late_gyro, w + noise(0.004));
    if (world.estimates) {
      put("est_position", t, p);
      put("est_attitude", t, coefficients(q));
      put("est_angular_velocity", t, w);
    }
    put("qddr", t, command);
    put("ref_position", t, Vec3::Zero());
    put("ref_attitude", t, coefficients(goal));
    put("ref_angular_velocity", t, w_ref);
    put("ref_angular_acceleration", t, dw_ref);
    wind = 0.97 * wind + noise(0.05 * world.turbulence);
    twist = 0.97 * twist + noise(0.4 * world.turbulence);
    if (t > 30 && t < 30.5) w += Vec3::Constant(world.knock * kStep);
    v += (command.head<3>() + wind) * kStep;
    p += v * kStep;
    w += (command.tail<3>() + twist) * kStep;
    q = (q * exp_rotation(w * kStep)).normalized();
  }
  return r;
}

Diagnosis judged(const recording::Recording& r) {
  Diagnosis d;
  add_control(r, usual(), d);
  return d;
}

TEST(ControlReplay, ToldGainsThatAreFlownAreNoFinding) {
  const Diagnosis d = judged(flown(usual()));
  EXPECT_TRUE(d.findings.empty()) << d.findings[0].sentence;
  EXPECT_FALSE(d.controller.has_value());
}

TEST(ControlReplay, NamesTheLoopAndTheGainsThatWereCut) {
  for (const bool attitude : {false, true}) {
    ToldController cut = usual();
    (attitude ? cut.kR : cut.kp) *= 0.5;
    (attitude ? cut.kw : cut.kv) *= 0.5;
    const Diagnosis d = judged(flown(cut));
    ASSERT_EQ(d.findings.size(), 1U);
    const Finding& f = d.findings[0];
    EXPECT_EQ(f.effect, "controller_mismatch");
    EXPECT_EQ(f.stage, physics::Stage::control);
    ASSERT_EQ(f.parameters.size(), 6U) << f.sentence;  // two gains of three axes, none of the other loop
    for (const ParameterValue& p : f.parameters) {
      const double truth = p.name[1] == 'p' ? 6 : p.name[1] == 'v' ? 3 : p.name[1] == 'R' ? 50 : 10;
      EXPECT_NEAR(p.value, truth, 0.05 * truth) << p.name;
    }
    ASSERT_TRUE(d.controller);
    EXPECT_EQ(d.controller->ki, usual().ki);
    EXPECT_LT(((attitude ? d.controller->kR : d.controller->kp) - (attitude ? cut.kR : cut.kp)).norm(),
              0.05 * (attitude ? cut.kR : cut.kp).norm());
  }
}

TEST(ControlReplay, ASecondRecordingFlownWithOtherGainsIsNamed) {
  ToldController cut = usual();
  cut.kp *= 0.5;
  recording::Recording first = flown(usual()), second = flown(cut);
  first.file = "first", second.file = "second";
  Diagnosis d;
  add_controls({&first, &second}, usual(), d);
  ASSERT_EQ(d.findings.size(), 1U);
  EXPECT_EQ(d.findings[0].effect, "controller_mismatch");
  EXPECT_EQ(d.findings[0].recordings, std::vector<std::string>{"second"});
  for (const Mismatch& m : d.mismatch) EXPECT_EQ(m.recordings, std::vector<std::string>{"second"});
  EXPECT_FALSE(d.controller.has_value()) << "the first, which is flown again, kept to the told gains";
}

TEST(ControlReplay, AGyroOnALateClockIsNoMismatch) {
  for (const double late : {0.016, 0.03}) {
    const Diagnosis d = judged(flown(usual(), {.late_gyro = late}));
    EXPECT_TRUE(d.findings.empty()) << d.findings[0].sentence;
  }
  ToldController cut = usual();
  cut.kw *= 0.6;
  const Diagnosis d = judged(flown(cut, {.late_gyro = 0.03}));
  ASSERT_EQ(d.findings.size(), 1U);
  for (const ParameterValue& p : d.findings[0].parameters) {
    EXPECT_EQ(p.name[1], 'w') << d.findings[0].sentence;
    EXPECT_NEAR(p.value, 12, 0.6) << p.name;
  }
}

// A cable that bends where the vehicle is upside down: once in a flight more is asked than the limit allows.
TEST(ControlReplay, ALimitThatIsMetOnceIsNoOtherGain) {
  for (const auto& [limit, knock] : {std::pair{3.0, 9.0}, {4.0, 5.0}, {6.0, 20.0}}) {
    const Diagnosis d = judged(flown(usual(), {.limit = limit, .knock = knock, .estimates = true}));
    EXPECT_TRUE(d.findings.empty()) << limit << ", " << knock << ": " << d.findings[0].sentence;
  }
}

TEST(ControlReplay, OneAxisIsEnough) {
  ToldController cut = usual();
  cut.kR.z() *= 0.4;
  const Diagnosis d = judged(flown(cut));
  ASSERT_EQ(d.findings.size(), 1U);
  ASSERT_EQ(d.findings[0].parameters.size(), 1U) << d.findings[0].sentence;
  EXPECT_EQ(d.findings[0].parameters[0].name, "kR_yaw");
  EXPECT_NEAR(d.findings[0].parameters[0].value, 40, 3);
}

TEST(ControlReplay, InStillAirNoiseIsNoMismatchWhereTheEstimateIsRecorded) {
  const World still{.turbulence = 0.01, .estimates = true};
  recording::Recording r = flown(usual(), still);
  const Diagnosis d = judged(r);
  EXPECT_TRUE(d.findings.empty()) << d.findings[0].sentence;
  for (const char* name : {"est_position", "est_attitude", "est_angular_velocity"}) r.signals.erase(name);
  const Diagnosis without = judged(r);
  printf("without the estimate: %s\n",
         without.findings.empty() ? "nothing" : without.findings[0].sentence.c_str());
  ToldController cut = usual();
  cut.kR *= 0.5;
  EXPECT_EQ(judged(flown(cut, still)).findings.size(), 1U);
}

TEST(ControlReplay, ALateAttitudeOfAQuickMotionIsNoMismatch) {
  for (const double late : {-0.015, 0.015}) {
    const Diagnosis d = judged(flown(usual(), {.rock = 0.4, .late = late}));
    EXPECT_TRUE(d.findings.empty()) << d.findings[0].sentence;
  }
  ToldController cut = usual();
  cut.kR *= 0.5;
  const Diagnosis d = judged(flown(cut, {.rock = 0.4, .late = 0.015}));
  ASSERT_EQ(d.findings.size(), 1U);
  for (const ParameterValue& p : d.findings[0].parameters) EXPECT_NEAR(p.value, 50, 8) << p.name;
}

TEST(ControlReplay, SaysNothingOfAnotherLawNorWithoutTheState) {
  EXPECT_TRUE(judged(flown(usual(), {.power = 0.1})).findings.empty());
  recording::Recording blind =
      flown({0.4 * usual().kp, usual().kv, usual().ki, usual().kR, usual().kw, usual().kI});
  EXPECT_FALSE(judged(blind).findings.empty());
  blind.signals.erase("position");
  EXPECT_TRUE(judged(blind).findings.empty());
}

TEST(ControlReplay, ALostStretchOfMotionCaptureChangesNothing) {
  recording::Recording r = flown(usual());
  recording::Signal& p = r.signals["position"];
  const Eigen::Index from = p.values.rows() / 2, lost = static_cast<Eigen::Index>(1.5 / kStep),
                     n = p.values.rows();
  const Eigen::MatrixXd tail = p.values.bottomRows(n - from - lost);
  p.values.conservativeResize(n - lost, 3);
  p.values.bottomRows(tail.rows()) = tail;
  p.t_s.erase(p.t_s.begin() + from, p.t_s.begin() + from + lost);
  const Diagnosis d = judged(r);
  EXPECT_TRUE(d.findings.empty()) << d.findings[0].sentence;
}

}  // namespace
}  // namespace omniflight::diagnosis
