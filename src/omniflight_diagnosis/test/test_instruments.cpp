// Feedback makes rotors answer to turbulence. Seen on the flight as its reference alone makes it, that is no
// effect.
#include <gtest/gtest.h>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using test::omnimorph;

std::string names(const Diagnosis& d) {
  std::string out;
  for (const Finding& f : d.findings) out += f.effect + " ";
  for (const Unexplained& u : d.unexplained) out += "? " + u.channel + " ";
  return out;
}

/// Slow turbulence that the rotors cancel after a quarter of a second.
test::Flown buffeted(std::uint64_t seed) {
  test::Flown f;
  f.force_noise_N = 0.3;
  f.torque_noise_Nm = 0.02;
  f.correlation_s = 1.0;
  f.answer_s = 0.25;
  f.sway = 0.15;
  f.seed = seed;
  return f;
}

Options with_flights_again(const vehicle::Vehicle& v, int& flown_again) {
  Options o;
  o.rollouts = false;
  o.only = {"payload_mass",  "thrust_scale",    "com_offset",   "inertia_error",
            "rotor_drag",    "parasitic_drag",  "wind",         "hung_cable",
            "constant_pull", "tilt_efficiency", "thrust_curve", "attachment_torque"};
  o.tolerance.thrust_scale = 0.001;
  o.tolerance.torque_trim = 0.001;
  o.refly = {[&v, &flown_again](const Eigen::MatrixXd& wrench, double from_s,
                                double rate_hz) -> Result<recording::Recording> {
    EXPECT_EQ(wrench.cols(), 6);
    EXPECT_TRUE(wrench.allFinite());
    EXPECT_NEAR(static_cast<double>(wrench.rows()), 30 * rate_hz, rate_hz);
    EXPECT_GE(from_s, 0);
    ++flown_again;
    test::Flown still = buffeted(1);
    still.force_noise_N = still.torque_noise_Nm = still.accelerometer_noise = still.gyro_noise =
        still.speed_noise = 0;
    return test::fly(v, {}, still);
  }};
  return o;
}

TEST(Instruments, TurbulenceThroughFeedbackIsNoEffect) {
  const vehicle::Vehicle v = omnimorph();
  int flown_again = 0, alarms_without = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto real = test::fly(v, {}, buffeted(seed));
    Options o = with_flights_again(v, flown_again);
    const auto d = diagnose({&real, 1}, {}, v, o);
    ASSERT_TRUE(d) << d.error().text();
    EXPECT_EQ(names(*d), "") << "seed " << seed;
    o.refly.clear();
    const auto control = diagnose({&real, 1}, {}, v, o);
    ASSERT_TRUE(control) << control.error().text();
    alarms_without += !names(*control).empty();
  }
  EXPECT_EQ(flown_again, 3);
  EXPECT_GT(alarms_without, 0) << "then this test could not tell";
}

TEST(Instruments, APayloadUnderTurbulenceIsNamedWithItsMass) {
  const vehicle::Vehicle v = omnimorph();
  int flown_again = 0;
  const auto real = test::fly(v, {{physics::find_effect("payload_mass"), {0.05}}}, buffeted(3));
  const auto d = diagnose({&real, 1}, {}, v, with_flights_again(v, flown_again));
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(flown_again, 2) << "the second time with what was found";
  ASSERT_FALSE(d->findings.empty()) << d->summary;
  const Finding& f = d->findings.front();
  bool meant = f.effect == "payload_mass";
  for (const std::string& other : f.cannot_be_told_apart_from) meant = meant || other == "payload_mass";
  EXPECT_TRUE(meant) << d->summary;
  if (f.effect == "payload_mass") {
    EXPECT_NEAR(f.parameters[0].value, 0.05, 0.01);
  }
}

TEST(Instruments, TwoFlightsAreBothFlownAgain) {
  const vehicle::Vehicle v = omnimorph();
  int flown_again = 0;
  const std::vector<physics::ActiveEffect> load{{physics::find_effect("payload_mass"), {0.05}}};
  const std::vector<recording::Recording> real{test::fly(v, load, buffeted(3)),
                                               test::fly(v, load, buffeted(4))};
  Options o = with_flights_again(v, flown_again);
  o.refly.push_back(o.refly.front());
  const auto d = diagnose(real, {}, v, o);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(flown_again, 4);
  EXPECT_NE(names(*d), "");
}

TEST(Instruments, AFlightAgainThatTurnsTooMuchDoesNotShrinkTheAnswer) {
  const vehicle::Vehicle v = omnimorph();
  const physics::Effect* inertia = physics::find_effect("inertia_error");
  const std::vector<double> truth{0.006, 0.006, 0.006};
  test::Flown f;
  f.sway = 0.25;
  f.torque_noise_Nm = 0.001;
  f.seed = 5;
  const auto real = test::fly(v, {{inertia, truth}}, f);
  Options o;
  o.rollouts = false;
  o.only = {"inertia_error", "payload_mass", "constant_pull"};
  o.refly = {[&](const Eigen::MatrixXd&, double, double) -> Result<recording::Recording> {
    test::Flown again = f;
    again.sway *= 1.2;
    again.force_noise_N = again.torque_noise_Nm = again.accelerometer_noise = again.gyro_noise =
        again.speed_noise = 0;
    return test::fly(v, {}, again);
  }};
  const auto d = diagnose({&real, 1}, {}, v, o);
  ASSERT_TRUE(d) << d.error().text();
  ASSERT_EQ(names(*d), "inertia_error ") << d->summary;
  for (const std::size_t k : {0u, 1u}) {  // it sways about x and y
    const ParameterValue& p = d->findings[0].parameters[k];
    EXPECT_NEAR(p.value, truth[k], 0.08 * truth[k]) << "a regression on the instruments says a sixth less";
    EXPECT_LT(p.low, truth[k]);
    EXPECT_GT(p.high, truth[k]);
    EXPECT_LT(p.high - p.low, truth[k]);
  }
}

TEST(Instruments, AFlightThatCannotBeFlownAgainIsJudgedAsItIs) {
  const vehicle::Vehicle v = omnimorph();
  const auto real =
      test::fly(v, {{physics::find_effect("payload_mass"), {0.25}}}, test::Flown{.duration_s = 15});
  Options o;
  o.rollouts = false;
  o.only = {"payload_mass", "rotor_drag"};
  o.refly = {[](const Eigen::MatrixXd&, double, double) -> Result<recording::Recording> {
    return fail(ErrorCode::incomplete, "lost", "");
  }};
  const auto d = diagnose({&real, 1}, {}, v, o);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(names(*d), "payload_mass ");
}

}  // namespace
}  // namespace omniflight::diagnosis
