// Each kind of fault does what it says, when it says; and a schedule that makes no sense is refused.
#include <gtest/gtest.h>

#include "counted_malloc.hpp"
#include "flying.hpp"
#include "omniflight_simulation/faults.hpp"

namespace omniflight::simulation {
namespace {

std::vector<Fault> schedule(const std::string& faults) {
  auto yaml =
      files::YamlReader::parse("schema: omniflight.faults/1\nfaults:\n" + faults, "faults.yaml").value();
  auto read = read_faults(yaml, 8);
  if (!read) throw std::runtime_error(read.error().text());
  return *read;
}

std::string refusal(const std::string& faults) {
  auto yaml =
      files::YamlReader::parse("schema: omniflight.faults/1\nfaults:\n" + faults, "faults.yaml").value();
  auto read = read_faults(yaml, 8);
  return read ? "" : read.error().text();
}

Plant hovering() {
  const auto v = omnimorph();
  PlantConfig c;
  c.initial_alpha = 0.5;
  Plant plant = make(v, {}, c);
  plant.set_command(hover_speed(v, 0.5), 0.5);
  for (int k = 0; k < 1000; ++k)
    if (!plant.step(true)) throw std::runtime_error("the plant does not hover");
  return plant;  // at 1 s
}

void fly(Plant& plant, FaultInjector& faults, int steps, bool held) {
  for (int k = 0; k < steps; ++k) {
    faults.before_step(plant);
    ASSERT_TRUE(plant.step(held));
  }
}

TEST(Faults, ARotorThatIsLostSpinsDownWithItsLagAndComesBack) {
  Plant plant = hovering();
  FaultInjector faults(schedule("  - {at_s: 1.1, kind: rotor_loss, rotor: 3, for_s: 0.5}\n"));
  const double before = plant.rotor_speed()[2];
  fly(plant, faults, 100, true);
  EXPECT_EQ(plant.rotor_speed()[2], before);
  EXPECT_EQ(faults.active(), 0u);
  fly(plant, faults, 45, true);
  EXPECT_EQ(faults.active(), 1u);
  EXPECT_NEAR(plant.rotor_speed()[2] / before, std::exp(-0.045 / 0.015), 1e-4);
  EXPECT_EQ(plant.rotor_speed()[1], before);
  fly(plant, faults, 1000, true);
  EXPECT_NEAR(plant.rotor_speed()[2] / before, 1, 1e-6);
  EXPECT_EQ(faults.active(), 0u);
}

TEST(Faults, AStuckRotorKeepsItsSpeedOrTheOneGiven) {
  Plant plant = hovering();
  FaultInjector faults(
      schedule("  - {at_s: 1, kind: stuck_rotor, rotor: 1}\n  - {at_s: 1, kind: stuck_rotor, rotor: 8, "
               "speed_radps: -300}\n"));
  const double before = plant.rotor_speed()[0];
  plant.set_command(std::vector<double>(8, 900.0), 0.5);
  fly(plant, faults, 200, true);
  EXPECT_EQ(plant.rotor_speed()[0], before);
  EXPECT_EQ(plant.rotor_speed()[7], -300);
  EXPECT_NEAR(plant.rotor_speed()[1], 900, 1e-2);
}

TEST(Faults, AFrozenSensorRepeatsItselfUnderNewStamps) {
  PlantConfig c;
  c.initial.p_WB.z() = 5;
  Plant plant = make(omnimorph(), {}, c);
  FaultInjector faults(schedule("  - {at_s: 0.2, kind: sensor_freeze, sensor: mocap, for_s: 0.1}\n"));
  SensorSuite suite({}, {}, 0.001, 1);
  SensorFrame frame;
  int frozen = 0;
  double height = 0, last_good = 0;
  for (int k = 0; k < 500; ++k) {
    suite.sample(plant, frame);
    faults.alter(plant.time(), frame);
    if (frame.mocap) {
      EXPECT_NEAR(frame.mocap_sample.t, plant.time(), 1e-12);
      const bool within = k >= 200 && k < 300;
      EXPECT_EQ(frame.mocap_sample.p_WB.z(), within ? last_good : plant.body().p_WB.z());
      frozen += within && frame.mocap_sample.p_WB.z() == height;
      height = frame.mocap_sample.p_WB.z();
      if (!within) last_good = height;
    }
    EXPECT_TRUE(frame.imu);
    faults.before_step(plant);
    ASSERT_TRUE(plant.step());
  }
  EXPECT_EQ(frozen, 25);  // 100 ms at 250 Hz
}

TEST(Faults, ALostSensorIsSilentAndTheOthersAreNot) {
  Plant plant = hovering();
  FaultInjector faults(
      schedule("  - {at_s: 1.1, kind: sensor_loss, sensor: imu, for_s: 0.05}\n"
               "  - {at_s: 1.1, kind: sensor_loss, sensor: rotor_speed, for_s: 0.1}\n"));
  SensorSuite suite({}, {}, 0.001, 1);
  SensorFrame frame;
  int imu = 0, rotor = 0, mocap = 0;
  for (int k = 0; k < 400; ++k) {
    suite.sample(plant, frame);
    faults.alter(plant.time(), frame);
    imu += frame.imu, rotor += frame.rotor, mocap += frame.mocap;
    ASSERT_TRUE(plant.step(true));
  }
  EXPECT_EQ(imu, 350);
  EXPECT_EQ(rotor, 75);
  EXPECT_EQ(mocap, 100);
}

TEST(Faults, AGustGivesItsImpulse) {
  // the integral of F (1 - cos)/2 over its time is F T / 2
  PlantConfig c;
  c.initial.q_WB =
      exp_rotation(Vec3(0.4, -0.3, 1.0));  // a gust blows in the world, however the body is turned
  c.environment.gravity = 0;
  const auto v = omnimorph();
  Plant plant = make(v, {}, c);
  FaultInjector faults(
      schedule("  - {at_s: 0.1, for_s: 0.4, kind: gust, force_N: [2, 0, -1], torque_Nm: [0, 0, 0.01]}\n"));
  fly(plant, faults, 100, false);
  EXPECT_EQ(plant.body().v_WB_W, Vec3::Zero());
  fly(plant, faults, 200, false);
  EXPECT_NEAR(plant.effect_wrench().head<3>().norm(), std::sqrt(5.0), 1e-9);  // the peak
  fly(plant, faults, 300, false);
  EXPECT_LT((plant.body().v_WB_W - Vec3(2, 0, -1) * 0.2 / v.mass).norm(), 1e-9);
  EXPECT_NEAR(plant.body().w_WB_B.z(), 0.01 * 0.2 / v.inertia(2, 2), 1e-3);
}

TEST(Faults, ASnaggedRopeHoldsWhereItWasCaughtAndOnlyPulls) {
  PlantConfig c;
  c.initial.v_WB_W = Vec3(1, 0, 0);
  c.environment.gravity = 0;
  Plant plant = make(omnimorph(), {}, c);
  FaultInjector faults(
      schedule("  - {at_s: 0.5, for_s: 5, kind: rope_snag, slack_m: 0.2, stiffness_N_per_m: 300, "
               "damping_Ns_per_m: 3}\n"));
  double farthest = 0, energy = 0.5 * omnimorph().mass;
  for (int k = 0; k < 4000; ++k) {
    faults.before_step(plant);
    ASSERT_TRUE(plant.step());
    farthest = std::max(farthest, plant.body().p_WB.x());
    const double x = plant.body().p_WB.x();
    if (x < 0.7 - 1e-6) {  // slack
      EXPECT_EQ(plant.effect_wrench().norm(), 0.0) << x;
    }
    EXPECT_LE(plant.effect_wrench()[0], 1e-12);  // never pushes
    const double stretch = std::max(0.0, x - 0.7);
    const double now = 0.5 * omnimorph().mass * plant.body().v_WB_W.squaredNorm() + 150 * stretch * stretch;
    EXPECT_LE(now, energy + 1e-6);
    energy = now;
    if (k > 600 && x < 0.4) break;
  }
  EXPECT_GT(farthest, 0.7);
  EXPECT_LT(farthest, 0.7 + std::sqrt(omnimorph().mass / 300));  // all its energy in the spring
  EXPECT_LT(plant.body().v_WB_W.x(), 0);                         // and back
}

TEST(Faults, WhatMakesNoSenseIsRefusedWithFieldAndUnit) {
  const auto expect = [](const std::string& faults, const std::string& words) {
    const std::string text = refusal(faults);
    EXPECT_NE(text.find(words), std::string::npos) << faults << " -> " << text;
    EXPECT_NE(text.find("faults.yaml:"), std::string::npos) << text;
  };
  expect("  - {at_s: 1, kind: rotor_lost, rotor: 3}\n", "kind");
  expect("  - {at_s: -1, kind: rotor_loss, rotor: 3}\n", "at_s");
  expect("  - {kind: rotor_loss, rotor: 3}\n", "at_s");
  expect("  - {at_s: .nan, kind: rotor_loss, rotor: 3}\n", "at_s");
  expect("  - {at_s: 1, kind: rotor_loss, rotor: 9}\n", "rotor");
  expect("  - {at_s: 1, kind: rotor_loss, rotor: 0}\n", "rotor");
  expect("  - {at_s: 1, kind: rotor_loss}\n", "rotor");
  expect("  - {at_s: 1, kind: rotor_loss, rotor: 1, for_s: 0}\n", "for_s");
  expect("  - {at_s: 1, kind: rotor_loss, rotor: 1, speed_radps: 3}\n", "speed_radps");
  expect("  - {at_s: 1, kind: sensor_freeze, sensor: mocap}\n", "for_s");
  expect("  - {at_s: 1, kind: sensor_freeze, sensor: nose, for_s: 1}\n", "sensor");
  expect("  - {at_s: 1, kind: gust, for_s: 1}\n", "force_N");
  expect("  - {at_s: 1, kind: gust, for_s: 1, force_N: [1, 2]}\n", "force_N");
  expect("  - {at_s: 1, kind: rope_snag, for_s: 1, stiffness_N_per_m: 0}\n", "N/m");
  expect("  - {at_s: 1, kind: rotor_loss, rotor: 2}\n  - {at_s: 9, kind: stuck_rotor, rotor: 2}\n",
         "overlaps");
  EXPECT_EQ(refusal("  - {at_s: 1, kind: rotor_loss, rotor: 2, for_s: 1}\n  - {at_s: 2, kind: stuck_rotor, "
                    "rotor: 2}\n"),
            "");
  auto other = files::YamlReader::parse("schema: omniflight.faults/2\nfaults: []\n", "faults.yaml").value();
  EXPECT_FALSE(read_faults(other, 8));
  EXPECT_TRUE(load_faults(OMNIFLIGHT_SOURCE_ROOT "/configs/faults/rotor_loss.yaml", 8));
  EXPECT_FALSE(load_faults("/nonexistent/faults.yaml", 8));
}

TEST(Faults, CostNoAllocationAndChangeNothingBeforeTheyBegin) {
  Plant plant = hovering(), healthy = hovering();
  FaultInjector faults(
      schedule("  - {at_s: 1.5, kind: rotor_loss, rotor: 1}\n"
               "  - {at_s: 1.6, kind: gust, for_s: 1, force_N: [1, 0, 0]}\n"
               "  - {at_s: 1.7, kind: sensor_freeze, sensor: imu, for_s: 1}\n"));
  SensorSuite suite({}, {}, 0.001, 1);
  SensorFrame frame;
  bool fine = true;
  const long before = counted::allocations;
  for (int k = 0; k < 900; ++k) {
    suite.sample(plant, frame);
    faults.alter(plant.time(), frame);
    faults.before_step(plant);
    fine = fine && plant.step().has_value();
    if (k < 499) fine = fine && healthy.step().has_value() && plant.body().p_WB == healthy.body().p_WB;
  }
  EXPECT_TRUE(fine);
  if (counted::works) {
    EXPECT_EQ(counted::allocations, before);
  }
}

}  // namespace
}  // namespace omniflight::simulation
