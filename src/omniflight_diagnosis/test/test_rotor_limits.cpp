// Rotors at their limits are no broken sensors, and broken sensors no limits.
#include "../src/conditioning/rotor_limits.hpp"
#include "../src/conditioning/sensor_faults.hpp"
#include "../src/sensor_checks/rotor_limit_check.hpp"
#include "omniflight_core/random.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kPeriod = 0.004, kDuration = 40;

/// Commands that swing slowly between 100 and 1100 rad/s, a rotor after the other, and speeds that `answer`
/// (command, rotor, time) makes of them within 15 ms, by telemetry in steps of 0.5 rad/s.
template <class Answer>
recording::Recording flown(const vehicle::Vehicle& v, const Answer& answer) {
  recording::Recording r;
  recording::Signal &u = r.signals["rotor_command"], &w = r.signals["rotor_speed"];
  u.name = "rotor_command";
  w.name = "rotor_speed";
  const int n = static_cast<int>(kDuration / kPeriod), rotors = v.rotor_count();
  u.values.resize(n, rotors);
  w.values.resize(n, rotors);
  Random random(5, "limits");
  std::vector<double> speed(static_cast<std::size_t>(rotors), 600);
  for (int i = 0; i < n; ++i) {
    const double t = i * kPeriod;
    u.t_s.push_back(t);
    w.t_s.push_back(t);
    for (int k = 0; k < rotors; ++k) {
      double& x = speed[static_cast<std::size_t>(k)];
      u.values(i, k) = 600 + 500 * std::sin(0.8 * t + k) + 3 * random.normal();
      x += (1 - std::exp(-kPeriod / 0.015)) * (answer(u.values(i, k), k, t) - x);
      w.values(i, k) = 0.5 * std::round(2 * x);
    }
  }
  return r;
}

std::string found(const recording::Recording& r, const vehicle::Vehicle& v) {
  Diagnosis d;
  add_rotor_limits(r, v, d);
  std::string names;
  for (const Finding& f : d.findings) names += f.effect + " ";
  EXPECT_EQ(d.findings.size(), d.model.size()) << "the simulator can fly it";
  return names;
}

std::string broken(const recording::Recording& r) {
  std::string channels;
  for (const SensorFault& f : find_sensor_faults(r)) channels += f.channel + " ";
  return channels;
}

/// An allocator that asks for no more than the vehicle file allows, of one rotor that a rope loads.
TEST(RotorLimits, ASpeedThatStandsWhereItsCommandStandsIsNoBrokenSensor) {
  const vehicle::Vehicle v = test::omnimorph();
  auto r = flown(v, [](double u, int, double) { return u; });
  auto &u = r.signals["rotor_command"].values, &w = r.signals["rotor_speed"].values;
  for (Eigen::Index i = 2000; i < 3000; ++i) {
    u(i, 7) = 1145.87;
    if (i > 2015) w(i, 7) = 1146.1;
  }
  EXPECT_EQ(broken(r), "");
  u.col(7).segment(2000, 1000) = u.col(6).segment(2000, 1000);
  EXPECT_EQ(broken(r), "rotor8_speed ") << "that its command moves is what tells";
}

TEST(RotorLimits, ACeilingIsNamedWithItsLoss) {
  const vehicle::Vehicle v = test::omnimorph();
  const double ceiling = 0.7 * v.rotors[0].max_speed();
  const auto r = flown(v, [&](double u, int, double) { return std::min(u, ceiling); });
  Diagnosis d;
  add_rotor_limits(r, v, d);
  ASSERT_EQ(d.findings.size(), 1u);
  const ParameterValue& loss = d.findings[0].parameters[0];
  EXPECT_EQ(d.findings[0].effect, "actuator_saturation");
  EXPECT_NEAR(loss.value, 0.51, 0.005);
  EXPECT_LT(loss.low, 0.51);
  EXPECT_GT(loss.high, 0.51);
  EXPECT_EQ(broken(r), "") << "what stands at the ceiling does as it can";
}

// Commands are ahead of every motor that speeds up, and for longer than they are at a ceiling that is high.
TEST(RotorLimits, ACeilingIsFoundAlsoWhereItIsMetForMoments) {
  const vehicle::Vehicle v = test::omnimorph();
  const double ceiling = 1050;
  const auto r = flown(v, [&](double u, int, double) { return std::min(u, ceiling); });
  EXPECT_EQ(found(r, v), "actuator_saturation ");
  EXPECT_EQ(broken(r), "");
}

TEST(RotorLimits, TheCeilingOfTheFileIsNoFinding) {
  vehicle::Vehicle v = test::omnimorph();
  const double ceiling = 900;
  for (vehicle::Rotor& rotor : v.rotors) rotor.max_thrust = rotor.thrust(ceiling);
  const auto r = flown(v, [&](double u, int, double) { return std::min(u, ceiling); });
  EXPECT_EQ(found(r, v), "");
  EXPECT_EQ(broken(r), "");
}

TEST(RotorLimits, ADeadZoneIsNamedWithItsSpeed) {
  const vehicle::Vehicle v = test::omnimorph();
  const auto r = flown(v, [](double u, int, double) { return u < 200 ? 0.0 : u; });
  Diagnosis d;
  add_rotor_limits(r, v, d);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_EQ(d.findings[0].effect, "thrust_dead_zone");
  const ParameterValue& dead = d.findings[0].parameters[0];
  EXPECT_NEAR(dead.value, 200, 15);
  EXPECT_LT(dead.low, 200);
  EXPECT_GT(dead.high, 200);
  EXPECT_EQ(broken(r), "");
}

TEST(RotorLimits, TelemetryThatReadsNoSlowRotorIsNoDeadZone) {
  const vehicle::Vehicle v = test::omnimorph();
  auto r = flown(v, [](double u, int, double) { return u; });
  auto& speed = r.signals["rotor_speed"].values;
  speed = (speed.array().abs() < 143).select(0.0, speed);
  EXPECT_EQ(found(r, v), "");
  EXPECT_EQ(broken(r), "") << "and no broken sensor";
}

TEST(RotorLimits, WhatTelemetryDoesNotReadFollowsTheCommand) {
  const vehicle::Vehicle v = test::omnimorph();
  auto r = flown(v, [](double u, int, double) { return u; });
  const Eigen::MatrixXd turned = r.signals["rotor_speed"].values;
  recording::Signal& speed = r.signals["rotor_speed"];
  speed.values = (turned.array().abs() < 143).select(0.0, turned);
  speed.values(7, 2) = std::nan("");
  recording::Signal filled = speed;
  const auto slowest = fill_slow_readings(r, v, filled);
  ASSERT_TRUE(slowest);
  EXPECT_NEAR(*slowest, 143, 1) << "rad/s";
  EXPECT_TRUE(std::isnan(filled.values(7, 2)));
  filled.values(7, 2) = turned(7, 2);
  EXPECT_LT((filled.values - turned).cwiseAbs().maxCoeff(), 25) << "rad/s";
  EXPECT_GT((speed.values - turned).cwiseAbs().bottomRows(100).maxCoeff(), 100);
  recording::Signal whole = r.signals["rotor_speed"];
  r.signals["rotor_speed"].values = turned;
  EXPECT_FALSE(fill_slow_readings(r, v, whole)) << "a telemetry that reads every speed is left alone";
}

TEST(RotorLimits, WhatIsNoLimitIsNone) {
  const vehicle::Vehicle v = test::omnimorph();
  EXPECT_EQ(found(flown(v, [](double u, int, double) { return u; }), v), "");
  EXPECT_EQ(found(flown(v, [](double u, int, double) { return 0.95 * u; }), v), "") << "a weak battery";
  EXPECT_EQ(found(flown(v, [](double u, int k, double t) { return k == 2 && t > 20 ? 0.0 : u; }), v), "")
      << "a motor that fails";
}

TEST(RotorLimits, AStuckSensorStaysOne) {
  const vehicle::Vehicle v = test::omnimorph();
  for (const double at : {0.0, 450.0, 1050.0}) {
    auto r = flown(v, [](double u, int, double) { return u; });
    auto& speed = r.signals["rotor_speed"].values;
    speed.col(3).tail(speed.rows() / 3).setConstant(at);
    EXPECT_EQ(found(r, v), "") << at;
    EXPECT_EQ(broken(r), "rotor4_speed ") << at;
  }
}

}  // namespace
}  // namespace omniflight::diagnosis
