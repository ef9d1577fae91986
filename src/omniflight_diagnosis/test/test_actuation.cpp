// Lag and delay from held commands to rotor speeds, and a clock that is no delay.
#include <gtest/gtest.h>

#include <cstdlib>

#include "../src/sensor_checks/actuation.hpp"
#include "omniflight_core/random.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kPeriod = 0.008, kDuration = 40;

using test::omnimorph;

/// Commands held for 8 ms, answered with the vehicle's lag after `delay` seconds by one board (-1: by all);
/// speeds are stamped `clock` seconds late.
recording::Recording answers(const vehicle::Vehicle& v, int board, double delay, double clock) {
  recording::Recording r;
  recording::Signal &u = r.signals["rotor_command"], &w = r.signals["rotor_speed"];
  u.name = "rotor_command";
  w.name = "rotor_speed";
  const int n = static_cast<int>(kDuration / kPeriod);
  const Eigen::Index rotors = v.rotor_count();
  u.values.resize(n, rotors);
  w.values.resize(n, rotors);
  for (int i = 0; i < n; ++i) {
    u.t_s.push_back(i * kPeriod);
    w.t_s.push_back(i * kPeriod + clock);
  }
  Random random(3, "actuation");
  for (Eigen::Index k = 0; k < rotors; ++k) {
    double walk = 0;
    for (int i = 0; i < n; ++i) {
      walk = 0.9 * walk + 10 * random.normal();
      u.values(i, k) = 600 + 60 * std::sin(0.8 * i * kPeriod + static_cast<double>(k)) + walk;
    }
    const vehicle::Rotor& rotor = v.rotors[static_cast<std::size_t>(k)];
    const double late = board < 0 || rotor.board == board ? delay : 0;
    constexpr int fine = 80;  // steps of 0.1 ms
    double speed = u.values(0, k);
    for (int i = 0; i < n; ++i) {
      w.values(i, k) = speed + 0.1 * random.normal();
      for (int j = 0; j < fine; ++j) {
        const double t = i * kPeriod + j * kPeriod / fine - late + 1e-9;
        const int held = std::max(0, static_cast<int>(t / kPeriod));
        speed =
            u.values(held, k) + (speed - u.values(held, k)) * std::exp(-kPeriod / fine / rotor.time_constant);
      }
    }
  }
  return r;
}

Flight whole() {
  Flight f;
  f.rate_hz = 100;
  for (int i = 0; i < static_cast<int>(kDuration * 100); ++i) f.t.push_back(0.01 * i);
  f.segments.push_back({50, static_cast<int>(f.t.size()) - 50});
  return f;
}

TEST(Actuation, HeldCommandsOfANominalRotorShowNoDelay) {
  const vehicle::Vehicle v = omnimorph();
  const auto fits = fit_actuation(answers(v, -1, 0, 0), v, whole());
  ASSERT_EQ(fits.size(), 2u);
  for (const ActuationFit& f : fits) {
    EXPECT_LT(f.delay_s, 0.0003) << f.board;
    EXPECT_NEAR(f.lag_s, f.nominal_lag_s, 0.0003) << f.board;
    EXPECT_LT(f.rms_nominal, 0.3) << f.board;
  }
  Diagnosis d;
  add_actuation({fits}, d);
  EXPECT_TRUE(d.findings.empty());
  EXPECT_EQ(on_shared_delay(fits), "");
}

TEST(Actuation, ADelayOfAllBoardsIsSaidAndNotClaimed) {
  const vehicle::Vehicle v = omnimorph();
  const auto fits = fit_actuation(answers(v, -1, 0.006, 0), v, whole());
  ASSERT_EQ(fits.size(), 2u);
  EXPECT_NEAR(fits[0].shared_s, 0.006, 0.0003);
  Diagnosis d;
  add_actuation({fits}, d);
  EXPECT_TRUE(d.findings.empty());
  EXPECT_NE(on_shared_delay(fits).find("another 6 ms later"), std::string::npos) << on_shared_delay(fits);
}

TEST(Actuation, OneLateBoardIsFound) {
  const vehicle::Vehicle v = omnimorph();
  const auto fits = fit_actuation(answers(v, 1, 0.011, 0), v, whole());
  ASSERT_EQ(fits.size(), 2u);
  EXPECT_LT(fits[0].delay_s, 0.0003);
  EXPECT_NEAR(fits[1].delay_s, 0.011, 0.0003);
  Diagnosis d;
  add_actuation({fits}, d);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_EQ(d.findings[0].effect, "transport_delay");
}

TEST(Actuation, AQuickerMotorThanTheFileSaysIsFound) {
  const vehicle::Vehicle v = omnimorph();
  vehicle::Vehicle told = v;
  const double tau = v.rotors[0].time_constant;
  for (vehicle::Rotor& r : told.rotors) r.time_constant = tau + 0.02;
  const auto fits = fit_actuation(answers(v, -1, 0, 0), told, whole());
  ASSERT_EQ(fits.size(), 2u);
  Diagnosis d;
  add_actuation({fits}, d);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_EQ(d.findings[0].effect, "motor_lag");
  EXPECT_NEAR(d.findings[0].parameters[0].value, -0.02, 0.001);
  EXPECT_NE(d.findings[0].sentence.find("20 ms more quickly"), std::string::npos) << d.findings[0].sentence;
  ASSERT_EQ(d.model.size(), 1u);
  physics::Actuation a;
  a.time_constant.assign(told.rotors.size(), told.rotors[0].time_constant);
  d.model[0].effect->alter_actuation(told, d.model[0].theta.data(), a);
  EXPECT_NEAR(a.time_constant[0], tau, 0.001) << "s, as the simulator would fly the model";
}

TEST(Actuation, AnotherClockIsNoDelay) {
  const vehicle::Vehicle v = omnimorph();
  Flight f = whole();
  f.alignment.push_back({"gyro", "attitude", 0.0003, 1e-4, 0, 1e-6, 0.99});
  const auto same = fit_actuation(answers(v, -1, 0, 0.012), v, f);
  ASSERT_EQ(same.size(), 2u);
  EXPECT_NEAR(same[0].delay_s, 0.012, 0.0003);  // with clocks that are said to agree it is one
  f.alignment[0].lag_s = -0.012;
  const auto other = fit_actuation(answers(v, -1, 0, 0.012), v, f);
  ASSERT_EQ(other.size(), 2u);
  Diagnosis d;
  add_actuation({other}, d);
  EXPECT_TRUE(d.findings.empty());
  f.alignment.clear();  // nothing tells whether the clocks agree
  const auto unknown = fit_actuation(answers(v, -1, 0, 0.012), v, f);
  ASSERT_EQ(unknown.size(), 2u);
  add_actuation({unknown}, d);
  EXPECT_TRUE(d.findings.empty());
  // a board that is later than the other shows through the clock
  const auto late = fit_actuation(answers(v, 0, 0.009, 0.012), v, f);
  ASSERT_EQ(late.size(), 2u);
  EXPECT_NEAR(late[0].delay_s, 0.009, 0.0006);
  EXPECT_LT(late[1].delay_s, 0.0003);
}

}  // namespace
}  // namespace omniflight::diagnosis
