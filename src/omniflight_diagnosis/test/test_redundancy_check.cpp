// What was ordered, what was measured, and what another sensor says.
#include <gtest/gtest.h>

#include "../src/conditioning/sensor_faults.hpp"
#include "../src/sensor_checks/findings.hpp"
#include "../src/sensor_checks/redundancy_check.hpp"
#include "omniflight_core/random.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using test::omnimorph;

/// A nominal flight with commands that the rotors and the tilt follow exactly.
recording::Recording with_commands(const vehicle::Vehicle& v) {
  test::Flown f;
  f.sway = 0.2;
  f.torque_noise_Nm = 0;  // turns the gyro, not the attitude
  recording::Recording r = test::fly(v, {}, f);
  for (const auto& [of, from] : {std::pair{"rotor_command", "rotor_speed"}, {"alpha_command", "alpha"}}) {
    recording::Signal s = r.signals.at(from);
    s.name = of;
    r.signals[of] = s;
  }
  for (Eigen::Index i = 0; i < r.signals["alpha"].values.rows(); ++i)
    for (const char* name : {"alpha", "alpha_command"})
      r.signals[name].values(i, 0) += 0.1 * std::sin(0.02 * static_cast<double>(i));
  return r;
}

std::string found(const recording::Recording& r, const vehicle::Vehicle& v, const Options& o = {}) {
  Diagnosis d;
  check_redundancy(r, v, o, d);
  EXPECT_EQ(d.findings.size(), d.mismatch.size());
  std::string names;
  for (const Finding& f : d.findings) names += f.effect + " ";
  return names;
}

TEST(Agreement, AFlightThatDoesAsOrderedShowsNothing) {
  const vehicle::Vehicle v = omnimorph();
  EXPECT_EQ(found(with_commands(v), v), "");
}

TEST(Agreement, RotorsThatAllTurnTooSlowlySag) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = with_commands(v);
  r.signals["rotor_speed"].values *= 0.99;
  EXPECT_EQ(found(r, v), "battery_sag ");
}

/// A gain that stays is a scale of the telemetry as well; one that sinks is a battery's.
TEST(Agreement, OnlyRotorsThatTurnEverMoreSlowlyAreSurelyABatterys) {
  const vehicle::Vehicle v = omnimorph();
  for (const bool sinks : {false, true}) {
    recording::Recording r = with_commands(v);
    Eigen::MatrixXd& speed = r.signals["rotor_speed"].values;
    for (Eigen::Index i = 0; i < speed.rows(); ++i)
      speed.row(i) *= sinks ? 1 - 0.02 * static_cast<double>(i) / static_cast<double>(speed.rows()) : 0.99;
    Diagnosis d;
    check_redundancy(r, v, {}, d);
    ASSERT_EQ(d.findings.size(), 1u);
    EXPECT_EQ(d.findings[0].effect, "battery_sag");
    EXPECT_EQ(d.findings[0].cannot_be_told_apart_from.empty(), sinks) << d.findings[0].sentence;
  }
}

/// Speeds with duty cycles that gave them and a voltage that never moves.
recording::Recording on_a_steady_voltage(const vehicle::Vehicle& v) {
  recording::Recording r = with_commands(v);
  recording::Signal duty = r.signals.at("rotor_speed"), vbat = duty;
  duty.name = "pwm";
  duty.values = (duty.values.cwiseAbs() / 1200).array().pow(1 / 0.85);
  vbat.name = "vbat";
  vbat.unit = "V";
  vbat.values = Eigen::MatrixXd::Constant(duty.size(), 1, 16.0);
  r.signals["vbat"] = vbat;
  r.signals["pwm"] = duty;
  r.signals.erase("rotor_command");
  return r;
}

TEST(Agreement, AVoltageThatNeverMovesIsAFaultAsSurelyAsABatteryWasLoaded) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = on_a_steady_voltage(v);
  ASSERT_EQ(find_sensor_faults(r).size(), 1u);
  EXPECT_EQ(find_sensor_faults(r)[0].effect, "battery_sensor_fault");
  EXPECT_GT(find_sensor_faults(r)[0].log_factor, 20);
  EXPECT_TRUE(find_sensor_faults(r)[0].rivals.empty());
  r.signals.erase("pwm");  // speeds in a loop of their own: a supply may hold the voltage
  ASSERT_EQ(find_sensor_faults(r).size(), 1u);
  EXPECT_EQ(find_sensor_faults(r)[0].rivals, std::vector<std::string>{"a supply on the ground"});
  r.signals["rotor_speed"].values.rowwise() =
      Eigen::RowVectorXd::Constant(8, 500.0).eval();  // nothing to answer
  for (const SensorFault& f : find_sensor_faults(r)) EXPECT_NE(f.effect, "battery_sensor_fault");
}

TEST(Agreement, ASpeedThatReadsHalfIsToldByItsDutyCycle) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = on_a_steady_voltage(v);
  r.signals.erase("vbat");
  EXPECT_TRUE(find_sensor_faults(r).empty());
  r.signals["rotor_speed"].values.col(2) *= 0.5;
  const auto faults = find_sensor_faults(r);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].channel, "rotor3_speed");
  EXPECT_NE(faults[0].sentence.find("50 %"), std::string::npos) << faults[0].sentence;
}

TEST(Agreement, DutyCyclesOfAFallingBatteryNeedItsVoltage) {
  const vehicle::Vehicle v = omnimorph();
  for (const double exponent : {0.0, 0.9}) {
    recording::Recording r = with_commands(v);
    const auto& speed = r.signals.at("rotor_speed");
    recording::Signal duty = speed, vbat = speed;
    duty.name = "pwm";
    vbat.name = "vbat";
    vbat.unit = "V";
    vbat.values.resize(speed.values.rows(), 1);
    for (Eigen::Index i = 0; i < vbat.values.rows(); ++i) {
      const double t = static_cast<double>(i) / static_cast<double>(vbat.values.rows());
      vbat.values(i, 0) = 3.8 - 0.1 * t + 0.01 * std::sin(40 * t);
      duty.values.row(i) =
          speed.values.row(i).cwiseAbs() / (2000 * std::pow(vbat.values(i, 0) / 3.8, exponent));
    }
    r.signals["rotor_speed"].values = speed.values.cwiseAbs();
    r.signals["pwm"] = duty;
    r.signals["vbat"] = vbat;
    r.signals.erase("rotor_command");
    Diagnosis d;
    check_redundancy(r, v, {}, d);
    if (exponent == 0) {
      EXPECT_TRUE(d.findings.empty());
      continue;
    }
    ASSERT_EQ(d.findings.size(), 1u);
    EXPECT_EQ(d.findings[0].effect, "battery_sag");
    EXPECT_NEAR(d.findings[0].parameters[0].value, exponent, 0.05);
  }
}

TEST(Agreement, RotorsThatRunInStepsAreNoBrokenSensors) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = with_commands(v);
  auto& command = r.signals["rotor_command"].values;
  for (Eigen::Index i = 0; i < command.rows(); ++i)  // through several steps and back
    command.row(i).array() += 60 * std::sin(0.004 * static_cast<double>(i));
  r.signals["rotor_speed"].values = (command.array() / 12).round() * 12;
  Diagnosis d;
  check_redundancy(r, v, {}, d);
  ASSERT_FALSE(d.findings.empty());
  EXPECT_EQ(d.findings[0].effect, "command_quantisation");
  EXPECT_NEAR(d.findings[0].parameters.at(0).value, 12, 0.05);
}

TEST(Agreement, SpeedsThatHardlyEverLeaveTheirStepAreNoBrokenSensorsEither) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = with_commands(v);
  Eigen::MatrixXd &command = r.signals["rotor_command"].values, &speed = r.signals["rotor_speed"].values;
  Random random(3, "between two steps");
  for (Eigen::Index i = 0; i < command.rows(); ++i)  // too little for the step to be seen
    for (Eigen::Index k = 0; k < command.cols(); ++k)
      command(i, k) = 601.5 + 2.2 * std::sin(0.02 * static_cast<double>(i) + static_cast<double>(k)) +
                      0.8 * random.normal();
  speed = (command.array() / 3).round() * 3;
  EXPECT_TRUE(find_sensor_faults(r).empty());
  speed = command;
  for (const Eigen::Index k : {1, 4}) speed.col(k).tail(speed.rows() / 3).setConstant(500);
  EXPECT_EQ(find_sensor_faults(r).size(), 2u) << "two of eight that stand still are";
}

TEST(Agreement, OneRotorThatTurnsOtherwiseIsNamedWithItsScale) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = with_commands(v);
  r.signals["rotor_speed"].values.col(4) *= 0.98;
  Diagnosis d;
  check_redundancy(r, v, {}, d);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_EQ(d.findings[0].effect, "rotor_speed_sensor_fault");
  EXPECT_EQ(d.findings[0].parameters.at(0).value, 5);
  EXPECT_NEAR(d.findings[0].parameters.at(1).value, -0.02, 0.001);
}

TEST(Agreement, ATiltThatLagsIsNamedWithItsTime) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = with_commands(v);
  auto& tilt = r.signals["alpha"];
  const auto command = r.signals["alpha_command"].values;
  const double part = std::exp(-0.01 / 0.08);
  for (Eigen::Index i = 1; i < tilt.values.rows(); ++i)
    tilt.values(i, 0) = command(i, 0) + part * (tilt.values(i - 1, 0) - command(i, 0));
  Diagnosis d;
  check_redundancy(r, v, {}, d);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_EQ(d.findings[0].effect, "tilt_servo_lag");
  EXPECT_NEAR(d.findings[0].parameters.at(0).value, 0.08, 0.01);
}

/// The tilt angle follows its command with this lag [s], exactly.
void let_the_tilt_lag(recording::Recording& r, double lag) {
  auto& tilt = r.signals["alpha"];
  const auto command = r.signals["alpha_command"].values;
  const double part = std::exp(-0.01 / lag);
  for (Eigen::Index i = 1; i < tilt.values.rows(); ++i)
    tilt.values(i, 0) = command(i, 0) + part * (tilt.values(i - 1, 0) - command(i, 0));
}

TEST(Agreement, AToldLagOfTheTiltIsNoFindingAndMoreIsTheDifference) {
  vehicle::Vehicle v = omnimorph();
  v.tilt.time_constant = 0.08;
  recording::Recording r = with_commands(v);
  let_the_tilt_lag(r, 0.08);
  EXPECT_EQ(found(r, v), "");
  r = with_commands(v);
  let_the_tilt_lag(r, 0.14);
  Diagnosis d;
  check_redundancy(r, v, {}, d);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_EQ(d.findings[0].effect, "tilt_servo_lag");
  EXPECT_NEAR(d.findings[0].parameters.at(0).value, 0.06, 0.01) << "s, beyond the told 0.08 s";
  EXPECT_NE(d.findings[0].sentence.find("140 ms late, 60 ms later than the vehicle file says"),
            std::string::npos)
      << d.findings[0].sentence;
  r = with_commands(v);
  let_the_tilt_lag(r, 0.055);
  d = {};
  check_redundancy(r, v, {}, d);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_NEAR(d.findings[0].parameters.at(0).value, -0.025, 0.004) << "s, quicker than told";
}

TEST(Agreement, AToldPlayOfTheTiltIsNoLag) {
  vehicle::Vehicle v = omnimorph();
  recording::Recording r = with_commands(v);
  auto& tilt = r.signals["alpha"].values;
  const auto command = r.signals["alpha_command"].values;
  constexpr double kHalfPlay = 0.02;  // rad
  for (Eigen::Index i = 1; i < tilt.rows(); ++i)
    tilt(i, 0) = std::clamp(tilt(i - 1, 0), command(i, 0) - kHalfPlay, command(i, 0) + kHalfPlay);
  EXPECT_EQ(found(r, v), "tilt_servo_lag ");
  v.tilt.backlash = 2 * kHalfPlay;
  EXPECT_EQ(found(r, v), "");
}

TEST(Agreement, ATiltThatRepeatsItsCommandLacksNoToldLag) {
  vehicle::Vehicle v = omnimorph();
  v.tilt.time_constant = 0.08;
  EXPECT_EQ(found(with_commands(v), v), "") << "what the servo was set to tells nothing of its lag";
}

TEST(Agreement, AGyroBiasCountsBeyondWhatIsTold) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = with_commands(v);
  r.signals["gyro"].values.col(2).array() += 0.05;
  EXPECT_EQ(found(r, v), "gyro_error ");
  Options told;
  told.tolerance.gyro_bias = 0.06;
  EXPECT_EQ(found(r, v, told), "");
  // of three axes in hundreds of flights one is now and then beyond three standard deviations
  told.tolerance.gyro_bias = 0.016;
  EXPECT_EQ(found(r, v, told), "");
  told.tolerance.gyro_bias = 0.01;
  EXPECT_EQ(found(r, v, told), "gyro_error ");
}

TEST(Agreement, MissingAndBrokenSignalsArePassedOver) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = with_commands(v);
  for (const char* name : {"rotor_command", "alpha_command", "attitude"}) r.signals.erase(name);
  EXPECT_EQ(found(r, v), "");
  r = with_commands(v);
  for (auto& [name, signal] : r.signals) signal.values.setConstant(std::nan(""));
  EXPECT_EQ(found(r, v), "");
}

TEST(Agreement, WhatALyingSensorMakesOfItsRotorIsNoEffect) {
  const auto after = [](const std::string& effect, std::vector<ParameterValue> values,
                        std::vector<std::string> rivals) {
    Diagnosis d;
    Finding fault, other;
    fault.effect = "rotor_speed_sensor_fault";
    fault.parameters = {{"rotor", "k", "1", 2}, {"scale", "eps", "1", -0.0063}};
    other.effect = effect;
    other.parameters = std::move(values);
    other.cannot_be_told_apart_from = std::move(rivals);
    d.findings = {other, fault};
    drop_what_a_sensor_explains(d);
    return d.findings.size();
  };
  EXPECT_EQ(after("rotor_thrust_scale", {{"scale_2", "", "1", 0.0127}}, {}), 1U);
  EXPECT_EQ(after("rotor_thrust_scale", {{"scale_2", "", "1", 0.05}}, {}), 2U);  // far more than it explains
  EXPECT_EQ(after("rotor_thrust_scale", {{"scale_3", "", "1", 0.0127}}, {}), 2U);
  EXPECT_EQ(after("rotor_position_error", {{"rotor2_x", "", "m", 0.002}}, {"rotor_thrust_scale"}), 1U);
  EXPECT_EQ(after("rotor_position_error", {{"rotor2_x", "", "m", 0.002}}, {}), 2U);
  EXPECT_EQ(after("rotor_position_error", {{"rotor3_x", "", "m", 0.002}}, {"rotor_thrust_scale"}), 2U);
  EXPECT_EQ(after("com_offset", {{"x", "", "m", 0.002}}, {"rotor_thrust_scale"}), 2U);
}

}  // namespace
}  // namespace omniflight::diagnosis
