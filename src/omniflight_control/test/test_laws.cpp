// Properties that every control law has, on a rigid body that does at once what its rotors can: thrust along
// one axis (underactuated) or a force in every direction (full).
#include <gtest/gtest.h>

#include "omniflight_control/law.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::control {
namespace {

constexpr double kStep = 0.002;  // s

struct Case {
  const char* law;
  bool leans;
};

struct Laws : testing::TestWithParam<Case> {
  LawConfig config() const {
    LawConfig c;
    c.actuator_time_constant = 0;
    if (GetParam().leans) c.thrust_axis_B = axis_;
    return c;
  }
  std::unique_ptr<Law> law() const { return make_law(GetParam().law, config()).value(); }
  Vec3 axis_ = Vec3::UnitZ();
};

/// The body and what its rotors give of a demand.
struct Body {
  RigidState s;
  Vec3 axis_B = Vec3::Zero();  ///< zero: forces in every direction
  double most = 100.0;         ///< N/kg along the axis
  Vec6 disturbance = Vec6::Zero();
  Vec6 unachieved = Vec6::Zero();

  void step(const Vec6& demand) {
    Vec3 given = demand.head<3>() + kGravity * Vec3::UnitZ();
    if (!axis_B.isZero()) {
      const Vec3 n = s.q_WB * axis_B;
      given = n * std::clamp(n.dot(given), 0.0, most);
    }
    unachieved << demand.head<3>() + kGravity * Vec3::UnitZ() - given, Vec3::Zero();
    const Vec3 a = given - kGravity * Vec3::UnitZ() + disturbance.head<3>();
    s.p_WB += s.v_WB_W * kStep + 0.5 * a * kStep * kStep;
    s.v_WB_W += a * kStep;
    const Vec3 dw = demand.tail<3>() + disturbance.tail<3>();
    s.q_WB = (s.q_WB * exp_rotation(s.w_WB_B * kStep + 0.5 * dw * kStep * kStep)).normalized();
    s.w_WB_B += dw * kStep;
  }
};

double distance(const RigidState& s, const Reference& r) {
  return (s.p_WB - r.p_WB).norm() + (s.v_WB_W - r.v_WB_W).norm() + s.q_WB.angularDistance(r.q_WB) +
         (s.w_WB_B - r.w_WB_B).norm();
}

TEST_P(Laws, AskForTheReferenceAccelerationInEquilibrium) {
  const auto law = this->law();
  Reference r;
  r.p_WB = Vec3(1, 2, 3);
  r.q_WB = exp_rotation(Vec3(0, 0, 0.7));
  const RigidState s{r.p_WB, r.q_WB, r.v_WB_W, r.w_WB_B};
  for (int k = 0; k < 500; ++k) EXPECT_LT(law->update(r, s, kStep).norm(), 1e-9);
  EXPECT_LT(law->integral_action().norm(), 1e-9);
}

TEST_P(Laws, AddTheReferenceAccelerationOnlyWithFeedForward) {
  Reference r;
  r.q_WB = exp_rotation(Vec3(0, 0, 0.7));
  r.a_WB_W = Vec3(0.4, -0.3, 0.5);
  r.dw_WB_B = Vec3(0, 0, 0.2);
  const RigidState s{r.p_WB, r.q_WB, r.v_WB_W, r.w_WB_B};
  for (const bool forward : {true, false}) {
    LawConfig c = config();
    c.gains.feed_forward = forward;
    const Vec6 asked = make_law(GetParam().law, c).value()->update(r, s, kStep);
    const Vec3 expected = forward ? r.a_WB_W : Vec3::Zero();
    EXPECT_LT((asked.head<3>() - expected).norm(), 1e-9) << forward << ": " << asked.transpose();
    if (!forward && !GetParam().leans) {  // a vehicle that leans turns with its error of acceleration
      EXPECT_LT(asked.tail<3>().norm(), 1e-9) << asked.transpose();
    }
  }
}

TEST_P(Laws, DoNotDependOnTheWorldsHeading) {
  Random rng(3);
  const Quat turn = exp_rotation(Vec3(0, 0, 1.3));
  for (int k = 0; k < 20; ++k) {
    const auto vec = [&] { return Vec3(rng.normal(), rng.normal(), rng.normal()); };
    Reference r, r2;
    r.p_WB = 0.1 * vec(), r.v_WB_W = 0.1 * vec(), r.a_WB_W = vec();
    r.q_WB = exp_rotation(0.2 * vec()), r.w_WB_B = 0.2 * vec(), r.dw_WB_B = vec();
    RigidState s{0.1 * vec(), exp_rotation(0.3 * vec()), 0.1 * vec(), 0.2 * vec()};
    r2 = r;
    r2.p_WB = turn * r.p_WB, r2.v_WB_W = turn * r.v_WB_W, r2.a_WB_W = turn * r.a_WB_W,
    r2.q_WB = turn * r.q_WB;
    const RigidState s2{turn * s.p_WB, turn * s.q_WB, turn * s.v_WB_W, s.w_WB_B};
    // bounds are per axis of the world, so that they must not be reached here
    const auto a = law(), b = law();
    for (int i = 0; i < 3; ++i) {
      const Vec6 u = a->update(r, s, kStep), u2 = b->update(r2, s2, kStep);
      EXPECT_LT((turn * Vec3(u.head<3>()) - u2.head<3>()).norm(), 1e-9);
      EXPECT_LT((u.tail<3>() - u2.tail<3>()).norm(), 1e-9);
    }
  }
}

/// Without integrators, whose slow modes would hide it: the poles of the position loop lie at -3 +- 1.7i 1/s.
/// Loops that do not lead the attitude get softer ones (kp = 3, kv = 3: -1.6, -2 +- 3i 1/s).
TEST_P(Laws, DecayExponentiallyFromEveryAttitude) {
  Random rng(5);
  LawConfig c = config();
  c.gains.ki = c.gains.kI = Vec3::Zero();
  if (GetParam().leans && std::string(GetParam().law) == "cascaded")
    c.gains.kp = c.gains.kv = Vec3::Constant(3);
  for (int k = 0; k < 20; ++k) {
    const auto law = make_law(GetParam().law, c).value();
    Reference r;
    r.q_WB = exp_rotation(Vec3(0, 0, rng.uniform(-3, 3)));
    Body body;
    if (GetParam().leans) body.axis_B = axis_;
    const Vec3 away(rng.normal(), rng.normal(), rng.normal());
    body.s.p_WB = 0.3 * away;
    // full_pose has the error of the thesis, which vanishes at half a turn
    const double most = std::string(GetParam().law) == "full_pose" ? 2.0 : kPi;
    body.s.q_WB = r.q_WB * exp_rotation(rng.uniform(0, most) *
                                        Vec3(rng.normal(), rng.normal(), rng.normal()).normalized());
    for (int i = 0; i < 8000; ++i) {
      body.step(law->update(r, body.s, kStep, body.unachieved));
      const double t = i * kStep;
      if (t > 3) {
        EXPECT_LT(distance(body.s, r), 40 * std::exp(-1.3 * t)) << GetParam().law << " at " << t << " s";
      }
    }
  }
}

TEST_P(Laws, TakeOutASteadyDisturbance) {
  const auto law = this->law();
  const Reference r;
  Body body;
  if (GetParam().leans) body.axis_B = axis_;
  body.disturbance << 0.6, -0.4, -1.5, 0.3, -0.2, 0.1;
  for (int i = 0; i < 30000; ++i) body.step(law->update(r, body.s, kStep, body.unachieved));
  EXPECT_LT((body.s.p_WB - r.p_WB).norm(), 1e-3);
  const Vec6 learnt = law->integral_action();
  if (GetParam().leans) {
    EXPECT_NEAR(learnt.z(), 1.5, 0.1);
  } else {
    EXPECT_LT((learnt + body.disturbance).norm(), 0.05);
  }
}

TEST_P(Laws, WindUpLessWhenTheyAreToldWhatWasNotAchieved) {
  // a climb of 1 m with a tenth of g to spare
  const auto peak = [&](bool told) {
    LawConfig c = config();
    c.gains.ki = Vec3::Constant(6);
    c.gains.max_acceleration = 100;
    const auto law = make_law(GetParam().law, c).value();
    Reference r;
    r.p_WB.z() = 1;
    Body body;
    body.axis_B = axis_;  // thrust-limited in either case
    body.most = 1.1 * kGravity;
    double above = 0;
    for (int i = 0; i < 10000; ++i) {
      body.step(law->update(r, body.s, kStep, told ? body.unachieved : Vec6::Zero()));
      above = std::max(above, body.s.p_WB.z() - 1);
    }
    return above;
  };
  EXPECT_LT(peak(true), 0.5 * peak(false));
}

INSTANTIATE_TEST_SUITE_P(All, Laws,
                         testing::Values(Case{"full_pose", false}, Case{"thrust_vector", true},
                                         Case{"cascaded", true}, Case{"cascaded", false},
                                         Case{"incremental", true}, Case{"incremental", false}),
                         [](const auto& one) {
                           return std::string(one.param.law) + (one.param.leans ? "_leaning" : "");
                         });

TEST(ThrustVector, TurnsOverFromUpsideDown) {
  LawConfig c;
  c.thrust_axis_B = Vec3::UnitZ();
  for (const double angle : {kPi, 0.999 * kPi, -0.5 * kPi}) {
    const auto law = make_law("thrust_vector", c).value();
    Body body;
    body.axis_B = c.thrust_axis_B;
    body.s.q_WB = exp_rotation(Vec3(angle, 0, 0));
    int upright_at = -1;
    for (int i = 0; i < 5000; ++i) {
      body.step(law->update(Reference{}, body.s, kStep, body.unachieved));
      if (upright_at < 0 && (body.s.q_WB * Vec3::UnitZ()).z() > std::cos(to_radians(10))) upright_at = i;
    }
    EXPECT_GE(upright_at, 0);
    EXPECT_LT(upright_at * kStep, 1.0) << "s, from " << to_degrees(angle) << " deg";
    EXPECT_LT(body.s.p_WB.norm(), 0.05);
  }
}

TEST(ThrustVector, HoldsItsHeadingAndLeansNoMoreThanAllowed) {
  LawConfig c;
  c.thrust_axis_B = Vec3(0.1, 0, 1).normalized();
  c.max_lean = to_radians(20);
  const auto law = make_law("thrust_vector", c).value();
  Reference r;
  r.q_WB = exp_rotation(Vec3(0, 0, 0.8)) * Quat::FromTwoVectors(c.thrust_axis_B, Vec3::UnitZ());
  r.p_WB = Vec3(5, 0, 0);
  Body body;
  body.axis_B = c.thrust_axis_B;
  body.s.q_WB = r.q_WB;
  double most = 0;
  for (int i = 0; i < 8000; ++i) {
    body.step(law->update(r, body.s, kStep, body.unachieved));
    most = std::max(most, std::acos(std::min(1.0, (body.s.q_WB * c.thrust_axis_B).z())));
  }
  EXPECT_LT(most, to_radians(24));  // a turn of the body overshoots by a sixth
  EXPECT_GT(most, to_radians(15));
  EXPECT_LT((body.s.p_WB - r.p_WB).norm(), 0.02);
  EXPECT_LT(body.s.q_WB.angularDistance(r.q_WB), 0.01);
}

/// The thrust answers late, but turns with the body at once: a law that mixes the two up sees a disturbance
/// in every turn and leaves its reference by centimetres.
TEST(Incremental, FollowsASwingingReferenceThroughSlowMotors) {
  constexpr double kLag = 0.05, kAmplitude = 0.5, kRate = 2.0;  // s, m, rad/s
  LawConfig c;
  c.thrust_axis_B = Vec3::UnitZ();
  c.actuator_time_constant = kLag;
  c.disturbance_bandwidth = 10;
  c.gains.kp = Vec3::Constant(8), c.gains.kv = Vec3::Constant(5);
  const auto law = make_law("incremental", c).value();
  const auto reference = [&](double t) {
    Reference r;
    r.p_WB.x() = kAmplitude * std::sin(kRate * t);
    r.v_WB_W.x() = kAmplitude * kRate * std::cos(kRate * t);
    r.a_WB_W.x() = -kRate * kRate * r.p_WB.x();
    const auto lean = [&](double at) {
      return std::atan2(-kRate * kRate * kAmplitude * std::sin(kRate * at), kGravity);
    };
    constexpr double h = 1e-4;
    r.q_WB = exp_rotation(Vec3(0, lean(t), 0));
    r.w_WB_B.y() = (lean(t + h) - lean(t - h)) / (2 * h);
    r.dw_WB_B.y() = (lean(t + h) - 2 * lean(t) + lean(t - h)) / (h * h);
    return r;
  };
  Body body;
  body.axis_B = c.thrust_axis_B;
  const Reference start = reference(0);
  body.s = {start.p_WB, start.q_WB, start.v_WB_W, start.w_WB_B};
  double thrust = kGravity, worst = 0;
  Vec3 turn = Vec3::Zero();
  Vec6 unachieved = Vec6::Zero();
  for (int i = 0; i < 5000; ++i) {
    const double t = i * kStep;
    const Vec6 demand = law->update(reference(t), body.s, kStep, unachieved);
    const Vec3 n = body.s.q_WB * c.thrust_axis_B, wanted = demand.head<3>() + kGravity * Vec3::UnitZ();
    unachieved << wanted - n * n.dot(wanted), Vec3::Zero();
    thrust += (1 - std::exp(-kStep / kLag)) * (n.dot(wanted) - thrust);
    turn += (1 - std::exp(-kStep / kLag)) * (demand.tail<3>() - turn);
    Vec6 given;
    given << n * thrust - kGravity * Vec3::UnitZ(), turn;
    body.step(given);
    if (t > 3) worst = std::max(worst, (body.s.p_WB - reference(t + kStep).p_WB).norm());
  }
  EXPECT_LT(worst, 0.004);  // m
}

TEST(LawTable, RefusesWhatDoesNotFit) {
  LawConfig c;
  const auto refused = [&](const char* name, const char* word) {
    const auto law = make_law(name, c);
    ASSERT_FALSE(law) << name;
    EXPECT_NE(law.error().text().find(word), std::string::npos) << law.error().text();
  };
  refused("pid", "full_pose, thrust_vector, cascaded, incremental");
  refused("thrust_vector", "thrust_axis");
  c.thrust_axis_B = Vec3(0, 0, 2);
  refused("cascaded", "unit length");
  c.thrust_axis_B = Vec3(0, 0, NAN);
  refused("incremental", "unit length");
  c.thrust_axis_B = Vec3::UnitZ();
  refused("full_pose", "one direction only");
  for (const std::string& name : law_names())
    EXPECT_EQ(make_law(name, c).has_value(), name != "full_pose") << name;
}

}  // namespace
}  // namespace omniflight::control
