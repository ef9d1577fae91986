// Feedback makes rotors answer to turbulence. Seen on the flight as its reference alone makes it, that is no
// effect.
#include <gtest/gtest.h>

#include <algorithm>

#include "../src/fit.hpp"
#include "../src/instruments.hpp"
#include "../src/problem.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_diagnosis/residual.hpp"
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
  o.refly = {[&v, &flown_again](const Eigen::MatrixXd& wrench, double from_s, double rate_hz,
                                const auto&) -> Result<recording::Recording> {
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
  constexpr int kFlights = 6;
  Vec3 mean = Vec3::Zero();
  int covered = 0;
  for (std::uint64_t seed = 1; seed <= kFlights; ++seed) {
    test::Flown f;
    f.sway = 0.25;
    f.torque_noise_Nm = 0.001;
    f.seed = seed;
    const auto real = test::fly(v, {{inertia, truth}}, f);
    Options o;
    o.rollouts = false;
    o.only = {"inertia_error", "payload_mass", "constant_pull"};
    o.refly = {[&](const Eigen::MatrixXd&, double, double, const auto&) -> Result<recording::Recording> {
      test::Flown again = f;
      again.sway *= 1.2;
      again.force_noise_N = again.torque_noise_Nm = again.accelerometer_noise = again.gyro_noise =
          again.speed_noise = 0;
      return test::fly(v, {}, again);
    }};
    const auto d = diagnose({&real, 1}, {}, v, o);
    ASSERT_TRUE(d) << d.error().text();
    ASSERT_EQ(names(*d), "inertia_error ") << "seed " << seed << ": " << d->summary;
    for (const int k : {0, 1}) {  // it sways about x and y
      const ParameterValue& p = d->findings[0].parameters[static_cast<std::size_t>(k)];
      mean[k] += p.value / kFlights;
      covered += p.low < truth[0] && truth[0] < p.high;
      EXPECT_LT(p.high - p.low, truth[0]);
    }
  }
  for (const int k : {0, 1})
    EXPECT_NEAR(mean[k], truth[0], 0.05 * truth[0]) << "a regression on the instruments says a sixth less";
  EXPECT_GE(covered, 2 * kFlights - 2);
}

TEST(Instruments, ARotorThatReversesIsNotJudgedAroundTheReversal) {
  const vehicle::Vehicle v = omnimorph();
  const auto backwards = [&](double from_s, double to_s) {
    recording::Recording r = test::fly(v, {}, {.duration_s = 20});
    recording::Signal& speed = r.signals.at("rotor_speed");
    for (Eigen::Index i = 0; i < speed.values.rows(); ++i)
      if (const double t = speed.t_s[static_cast<std::size_t>(i)]; t > from_s && t < to_s)
        speed.values(i, 2) = -speed.values(i, 2);
    return r;
  };
  const auto f = prepare_flight(backwards(8, 10), v, {});
  ASSERT_TRUE(f) << f.error().text();
  EXPECT_TRUE(f->excluded.empty()) << "without instruments its telemetry is all there is";
  const Eigen::MatrixXd nothing = Eigen::MatrixXd::Zero(f->size(), 6);
  const auto freed =
      with_instruments(*f, nothing, {}, v, {}, [&](const Eigen::MatrixXd&, double, double, const auto&) {
        return Result<recording::Recording>(backwards(8.5, 10));
      });
  ASSERT_TRUE(freed);
  ASSERT_EQ(freed->excluded.size(), 3u);
  int found = 0;
  for (const double at : {8.0, 8.5, 10.0}) {
    const Window& w = freed->excluded[static_cast<std::size_t>(found++)];
    EXPECT_EQ(w.why, "a rotor reverses");
    EXPECT_NEAR(0.5 * (w.from_s + w.to_s), at, 0.05);
  }
  for (const Segment& s : freed->segments)
    for (int i = s.begin; i < s.end; ++i)
      for (const double at : {8.0, 8.5, 10.0})
        EXPECT_GT(std::abs(f->t[static_cast<std::size_t>(i)] - at), 0.15);
  auto always =
      with_instruments(*f, nothing, {}, v, {}, [&](const Eigen::MatrixXd&, double, double, const auto&) {
        recording::Recording r = backwards(0, 0);
        recording::Signal& speed = r.signals.at("rotor_speed");
        for (Eigen::Index i = 0; i < speed.values.rows(); ++i)
          if (i / 50 % 2 == 1) speed.values(i, 2) = -speed.values(i, 2);
        return Result<recording::Recording>(r);
      });
  ASSERT_TRUE(always);
  EXPECT_TRUE(always->excluded.empty()) << "one that reverses all the time is judged as it is";
  EXPECT_EQ(always->usable(), f->usable());
  EXPECT_FALSE(leave_out_reversals(*always)) << "nothing would be left of it";
}

TEST(Instruments, OfAFlightThatReversesOftenThereIsAPartBetweenReversals) {
  const vehicle::Vehicle v = omnimorph();
  constexpr double kEvery = 1.6;  // s
  recording::Recording r = test::fly(v, {}, {.duration_s = 20});
  recording::Signal& speed = r.signals.at("rotor_speed");
  for (Eigen::Index i = 0; i < speed.values.rows(); ++i)
    if (static_cast<int>(speed.t_s[static_cast<std::size_t>(i)] / kEvery) % 2 == 1)
      speed.values(i, 4) = -speed.values(i, 4);
  const auto f = prepare_flight(r, v, {});
  ASSERT_TRUE(f) << f.error().text();
  auto freed = with_instruments(
      *f, Eigen::MatrixXd::Zero(f->size(), 6), {}, v, {},
      [&](const Eigen::MatrixXd&, double, double, const auto&) { return Result<recording::Recording>(r); });
  ASSERT_TRUE(freed);
  EXPECT_EQ(freed->usable(), f->usable()) << "all of it at first";
  EXPECT_TRUE(freed->excluded.empty());
  ASSERT_TRUE(leave_out_reversals(*freed));
  EXPECT_GT(freed->excluded.size(), 10u);
  EXPECT_NEAR(freed->usable(), 0.75 * f->usable(), 0.06 * f->usable());
  for (const Segment& s : freed->segments)
    for (int i = s.begin; i < s.end; ++i) {
      const double t = f->t[static_cast<std::size_t>(i)];
      EXPECT_GT(std::abs(t - kEvery * std::round(t / kEvery)), 0.15) << t;
    }
  EXPECT_FALSE(leave_out_reversals(*freed)) << "once";
}

TEST(Instruments, TheClockOfTheRotorsIsATolerance) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown f;
  f.sway = 0.15;
  f.torque_noise_Nm = 0.0005;
  f.force_noise_N = 0.01;
  f.gyro_noise = 0.0005;
  f.speed_noise = 0;  // an instrument has none
  f.rate_hz = 200;
  auto real = test::fly(v, {}, f);
  constexpr double kLate = 0.0012;  // s
  for (double& t : real.signals.at("rotor_speed").t_s) t += kLate;
  Options o;
  o.tolerance.rotor_clock = 0.02;  // the flight decides
  const auto clock_of = [&](bool instrumented) {
    auto flight = prepare_flight(real, v, o);
    EXPECT_TRUE(flight);
    if (instrumented) flight->instrument = flight->smooth;
    const Flight* one[] = {&*flight};
    const Problem problem(one, v, o);
    const auto& names = problem.offset_names();
    const auto at = std::find(names.begin(), names.end(), "rotor_clock") - names.begin();
    return fit_effects(problem, {}, o).offsets[at];
  };
  EXPECT_NEAR(clock_of(true), kLate, 0.3 * kLate);
  EXPECT_EQ(clock_of(false), 0) << "feedback looks the same";
}

// Slow motors turn the thrusts of every quick motion: an instrument of quick ones would be another flight.
TEST(Instruments, TheFlightIsFlownAgainWithTheMotorsThatWereFound) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = test::fly(v, {}, {.sway = 0.3, .speed_noise = 0});
  recording::Signal& speed = r.signals["rotor_speed"];
  Random random(3, "motors");
  for (Eigen::Index i = 0; i < speed.size(); ++i)
    for (Eigen::Index k = 0; k < speed.width(); ++k)
      speed.values(i, k) +=
          20 * std::sin(0.5 * static_cast<double>(k + 4) * speed.t_s[static_cast<std::size_t>(i)]);
  recording::Signal command = speed;
  command.name = "rotor_command";
  const double slower = 0.03, tau = v.rotors[0].time_constant + slower;
  for (Eigen::Index i = 1; i < speed.size(); ++i)
    for (Eigen::Index k = 0; k < speed.width(); ++k)
      speed.values(i, k) =
          lagged_speed(speed.values(i - 1, k), command.values(i - 1, k), tau, 1 / test::Flown{}.rate_hz);
  for (double& x : speed.values.reshaped()) x += 0.5 * random.normal();
  r.signals["rotor_command"] = command;
  std::vector<physics::ActiveEffect> motors;
  Options o;
  o.rollouts = false;
  o.only = {"payload_mass"};
  o.refly = {[&](const Eigen::MatrixXd&, double, double, const auto& found) -> Result<recording::Recording> {
    motors = found;
    return fail(ErrorCode::incomplete, "lost", "");
  }};
  ASSERT_TRUE(diagnose({&r, 1}, {}, v, o));
  ASSERT_EQ(motors.size(), 1u);
  EXPECT_EQ(motors[0].effect->info().id, "motor_lag");
  EXPECT_NEAR(motors[0].theta[0], slower, 0.1 * slower);
}

TEST(Instruments, AFlightThatCannotBeFlownAgainIsJudgedAsItIs) {
  const vehicle::Vehicle v = omnimorph();
  const auto real =
      test::fly(v, {{physics::find_effect("payload_mass"), {0.25}}}, test::Flown{.duration_s = 15});
  Options o;
  o.rollouts = false;
  o.only = {"payload_mass", "rotor_drag"};
  o.refly = {[](const Eigen::MatrixXd&, double, double, const auto&) -> Result<recording::Recording> {
    return fail(ErrorCode::incomplete, "lost", "");
  }};
  const auto d = diagnose({&real, 1}, {}, v, o);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(names(*d), "payload_mass ");
}

}  // namespace
}  // namespace omniflight::diagnosis
