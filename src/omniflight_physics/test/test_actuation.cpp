// Every effect between command and speed, carried out by Actuators.
#include "effect_testing.hpp"
#include "omniflight_physics/actuators.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr double kStep = 0.001;

struct Drive {
  vehicle::Vehicle vehicle = cube();
  std::vector<Actuators> made;  // one, or none when refused
  std::vector<double> command = std::vector<double>(8, 0.0);
  Error error;

  Drive(const char* id, const std::vector<double>& theta, double tau = 0.0, double tilt_rate = 0.0) {
    vehicle.tilt = {vehicle::TiltKind::common, 0, 1, tilt_rate};
    Actuation a;
    a.time_constant.assign(8, tau);
    a.delay.assign(8, 0.0);
    find_effect(id)->alter_actuation(vehicle, theta.data(), a);
    auto result = Actuators::create(vehicle, a, kStep, 0.0);
    if (result) made.push_back(*result);
    if (!result) error = result.error();
  }
  Actuators& drive() { return made.at(0); }
  double step(double speed, double alpha = 0.0, double power = 0.0) {
    command.assign(8, speed);
    drive().begin_step(command, alpha, power);
    return drive().target(0);
  }
};

TEST(ThrustDeadZone, StopsSlowRotorsAndRestsAtAReversal) {
  Drive d("thrust_dead_zone", {178, 0.005});
  EXPECT_EQ(d.step(177.9), 0.0);
  EXPECT_EQ(d.step(178.1), 178.1);
  EXPECT_EQ(d.step(-177.0), 0.0);
  for (int k = 0; k < 5; ++k) EXPECT_EQ(d.step(-500), 0.0) << k;
  EXPECT_EQ(d.step(-500), -500);
  EXPECT_EQ(d.step(0.0), 0.0);
  EXPECT_EQ(d.step(-400), -400) << "the same direction again needs no rest";
}

TEST(CommandQuantisation, HoldsForAPeriodAndRounds) {
  Drive d("command_quantisation", {0.004, 10});
  for (int k = 0; k < 12; ++k) EXPECT_EQ(d.step(503.0 + k), 10 * std::round((503.0 + 4 * (k / 4)) / 10)) << k;
}

TEST(BatterySag, IsTheEquivalentCircuit) {
  Drive d("battery_sag", {0.05, 1e-3, 16.0, 1.0});
  EXPECT_EQ(d.step(600, 0, 0.0), 600.0);
  const double electrical = 70.0 / 0.7;  // W
  const double first = d.step(600, 0, 70.0);
  EXPECT_NEAR(d.drive().voltage(), 16.0 - 0.05 * electrical / 16.0, 1e-12);
  EXPECT_NEAR(first, 600 * d.drive().voltage() / 16.0, 1e-12);
  for (int k = 0; k < 1000; ++k) d.step(600, 0, 70.0);
  const double open = 16.0 - 1e-3 * electrical * 1.0;
  EXPECT_NEAR(d.drive().energy(), electrical * 1.001, 1e-9);
  EXPECT_NEAR(d.drive().voltage(), open - 0.05 * electrical / open, 1e-3);
  Drive closed("battery_sag", {0.05, 1e-3, 16.0, 0.0});  // closed loop: only the largest speed falls
  const double most = closed.vehicle.rotors[0].max_speed();
  EXPECT_EQ(closed.step(600, 0, 70.0), 600.0);
  const double limited = closed.step(2000, 0, 70.0);
  EXPECT_NEAR(limited, most * closed.drive().voltage() / 16.0, 1e-9);
}

TEST(ActuatorSaturation, LosesThrustAndSlews) {
  Drive d("actuator_saturation", {0.3, 1e6}, 0.02);
  const vehicle::Rotor& r = d.vehicle.rotors[0];
  EXPECT_NEAR(r.thrust(d.step(5000)), 0.7 * r.max_thrust, 1e-12);
  EXPECT_NEAR(r.thrust(d.step(-5000)), -0.7 * r.max_thrust, 1e-12);
  Drive slow("actuator_saturation", {0.0, 4000}, 0.02);
  slow.step(1000);
  EXPECT_EQ(slow.drive().rate(0, 0), 4000);
  EXPECT_EQ(slow.drive().rate(0, 1100), -4000);
  EXPECT_NEAR(slow.drive().rate(0, 990), 500, 1e-9);
  Drive direct("actuator_saturation", {0.0, 4000}, 0.0);
  direct.step(1000);
  EXPECT_EQ(direct.drive().follows(0, 0), 4.0);
  EXPECT_EQ(direct.drive().follows(0, 998), 1000.0);
}

TEST(Actuators, ReachTheExactAnswerOfLagAndLimitedAcceleration) {
  const auto reach = [](const Drive& d, double from) {
    std::array<double, vehicle::kMaxRotors> speed{}, middle{}, end{};
    speed.fill(from);
    d.made[0].reach(speed.data(), middle.data(), end.data());
    return std::array{middle[0], end[0]};
  };
  Drive lag("actuator_saturation", {0.0, 1e6}, 0.02), slow("actuator_saturation", {0.0, 4000}, 0.02);
  lag.step(1000);
  EXPECT_NEAR(reach(lag, 400)[0], 1000 - 600 * std::exp(-0.5 * kStep / 0.02), 1e-10);
  EXPECT_NEAR(reach(lag, 400)[1], 1000 - 600 * std::exp(-kStep / 0.02), 1e-10);
  slow.step(1000);
  // far away at the limit, near by as the lag says, and from one to the other as fine steps do
  EXPECT_NEAR(reach(slow, 0)[1], 4000 * kStep, 1e-10);
  EXPECT_NEAR(reach(slow, 1990)[1], 1990 - 4000 * kStep, 1e-10);
  EXPECT_NEAR(reach(slow, 990)[1], 1000 - 10 * std::exp(-kStep / 0.02), 1e-10);
  const double from = 1000 - 80 - 1.5, h = kStep / 20000;
  double fine = from;
  for (int k = 0; k < 20000; ++k)
    fine += h * slow.drive().rate(0, fine + 0.5 * h * slow.drive().rate(0, fine));
  EXPECT_NEAR(reach(slow, from)[1], fine, 1e-7);
}

TEST(TiltServoLag, IsAnExponentialWithPlay) {
  Drive lag("tilt_servo_lag", {0.1, 0.0});
  for (int k = 1; k <= 300; ++k) {
    lag.step(0, 0.5);
    ASSERT_NEAR(lag.drive().alpha(), 0.5 * (1 - std::exp(-kStep * k / 0.1)), 1e-12);
  }
  Drive play("tilt_servo_lag", {0.0, 0.02});
  play.step(0, 0.5);
  EXPECT_NEAR(play.drive().alpha(), 0.49, 1e-12);
  play.step(0, 0.485);
  EXPECT_NEAR(play.drive().alpha(), 0.49, 1e-12) << "within the play nothing moves";
  play.step(0, 0.4);
  EXPECT_NEAR(play.drive().alpha(), 0.41, 1e-12);
}

TEST(ControllerMismatch, ScalesTheCommandedWrenchOnly) {
  Drive d("controller_mismatch", {0.1, -0.2, -0.5});
  Random rng(4);
  std::vector<double> command(8);
  for (double& w : command) w = 600 + 80 * rng.normal();
  d.drive().begin_step(command, 0.4, 0);
  const vehicle::AllocationMatrix A = d.vehicle.allocation_matrix(0.4);
  vehicle::RotorVector asked(8), given(8);
  for (int i = 0; i < 8; ++i) {
    asked[i] = d.vehicle.rotors[0].thrust(command[static_cast<std::size_t>(i)]);
    given[i] = d.vehicle.rotors[0].thrust(d.drive().target(static_cast<std::size_t>(i)));
  }
  Vec6 gain;
  gain << 1.1, 1.1, 1.1, 0.8, 0.8, 0.5;
  EXPECT_LT((A * given - gain.cwiseProduct(A * asked)).norm(), 1e-6);
  const Eigen::MatrixXd null = Eigen::MatrixXd(A).fullPivLu().kernel();
  EXPECT_LT((null.transpose() * (given - asked)).norm(), 1e-6) << "the null space keeps its command";
}

TEST(MotorLagAndDelay, AddToWhatTheVehicleHas) {
  Drive d("motor_lag", {0.03}, 0.02);
  d.step(100);
  EXPECT_NEAR(d.drive().rate(0, 0), 100 / 0.05, 1e-9);
  Drive late("transport_delay", {0.003, 0.0});
  std::vector<double> seen;
  for (int k = 0; k < 6; ++k) seen.push_back(late.step(100.0 + k));
  EXPECT_EQ(seen, (std::vector<double>{0, 0, 0, 100, 101, 102}));
  EXPECT_EQ(late.drive().target(7), 105.0) << "the other board is on time";
}

TEST(Actuators, RefuseWhatIsNoDrive) {
  EXPECT_NE(Drive("transport_delay", {2.0, 0.0}).error.text().find("2.0"), std::string::npos);
  EXPECT_NE(Drive("battery_sag", {0.1, 0, -5, 1}).error.text().find("V is not positive"), std::string::npos);
  EXPECT_TRUE(Drive("actuator_saturation", {1.0, 1000}).made.empty());
  EXPECT_NE(Drive("motor_lag", {0.0}, 0.0001).error.text().find("does not resolve"), std::string::npos);
}

}  // namespace
}  // namespace omniflight::physics::testing
