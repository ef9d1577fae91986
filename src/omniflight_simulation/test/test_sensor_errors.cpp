// Effects of the library on the sensors, as equations between what is and what is measured.
#include <gtest/gtest.h>

#include "flying.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_simulation/sensors.hpp"

namespace omniflight::simulation {
namespace {

/// Six vehicles in flight: three states, then the same turned by a large angle and moved. All accelerate.
std::vector<Plant> six_flights() {
  std::vector<Plant> out;
  for (const bool moved : {false, true})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      Random rng(seed);
      const auto vec = [&](double s) { return Vec3(s * rng.normal(), s * rng.normal(), s * rng.normal()); };
      PlantConfig c;
      c.initial = {Vec3(0, 0, 1.2) + vec(0.2), exp_rotation(vec(0.3)), vec(1.0), vec(1.5)};
      if (moved) {
        c.initial.q_WB = exp_rotation(Vec3(0.9, -1.3, 0.7)) * c.initial.q_WB;
        c.initial.p_WB += Vec3(0.3, -0.4, 0.25);
      }
      out.push_back(make(omnimorph(), {}, c));
      for (std::size_t i = 0; i < 8; ++i) out.back().seize_rotor(i, 600 + 100 * rng.normal());
      if (!out.back().step()) throw std::runtime_error("the plant does not step");
    }
  return out;
}

/// What the sensors, ideal but for one effect, tell of a flight at this instant.
SensorFrame measured(const Plant& plant, const char* id, const std::vector<double>& theta) {
  physics::Model model;
  model.effects.push_back({physics::find_effect(id), theta});
  SensorSuite suite({}, model, 0.001, 1);
  SensorFrame frame;
  suite.sample(plant, frame);
  EXPECT_TRUE(frame.imu && frame.mocap);
  return frame;
}

/// f = R^T (a + g e3) from the motion alone.
Vec3 specific_force(const Mat3& R, const Vec3& a_W) { return R.transpose() * (a_W + Vec3(0, 0, kGravity)); }
Vec3 acceleration_W(const Plant& plant) {
  const physics::Situation& s = plant.situation();
  return plant.body().q_WB * s.a_WB_B;
}

TEST(AccelerometerError, AddsItsBiasInBodyAxesInEveryFrame) {
  for (const Plant& plant : six_flights()) {
    const SensorFrame frame = measured(plant, "accelerometer_error", {0.05, -0.1, 0.2});
    const Mat3 R = plant.body().q_WB.toRotationMatrix();
    const Vec3 f = specific_force(R, acceleration_W(plant));
    EXPECT_GT((f - R.transpose() * Vec3(0, 0, kGravity)).norm(), 0.1) << "the vehicle accelerates";
    EXPECT_LT((frame.imu_sample.specific_force_B - (f + Vec3(0.05, -0.1, 0.2))).norm(), 1e-12);
    EXPECT_LT((frame.imu_sample.gyro_B - plant.body().w_WB_B).norm(), 1e-12);
    EXPECT_LT((frame.mocap_sample.p_WB - plant.body().p_WB).norm(), 1e-12);
  }
}

TEST(GyroError, AddsItsBiasInBodyAxesInEveryFrame) {
  for (const Plant& plant : six_flights()) {
    const SensorFrame frame = measured(plant, "gyro_error", {0.01, -0.02, 0.03});
    EXPECT_GT(plant.body().w_WB_B.norm(), 0.5);
    EXPECT_LT((frame.imu_sample.gyro_B - (plant.body().w_WB_B + Vec3(0.01, -0.02, 0.03))).norm(), 1e-12);
    EXPECT_LT((frame.imu_sample.specific_force_B - plant.specific_force()).norm(), 1e-12);
    EXPECT_LT(frame.mocap_sample.q_WB.angularDistance(plant.body().q_WB), 1e-12);
  }
}

TEST(MocapTilt, TurnsThePoseAboutTheHorizontalAxesInEveryFrame) {
  const Vec3 d(0.03, -0.05, 0);
  const Mat3 R_d = Eigen::AngleAxisd(d.norm(), d.normalized()).toRotationMatrix();
  for (const Plant& plant : six_flights()) {
    const SensorFrame frame = measured(plant, "mocap_tilt", {d.x(), d.y()});
    const Mat3 R = plant.body().q_WB.toRotationMatrix(), R_m = frame.mocap_sample.q_WB.toRotationMatrix();
    EXPECT_LT((frame.mocap_sample.p_WB - R_d * plant.body().p_WB).norm(), 1e-12);
    EXPECT_LT((R_m - R_d * R).norm(), 1e-12);
    EXPECT_LT((frame.imu_sample.specific_force_B - plant.specific_force()).norm(), 1e-12)
        << "the inertial sensor knows nothing of it";
  }
}

TEST(MocapTilt, LooksLikeAHorizontalForceOfTheWorld) {
  // Gravity is taken along the capture's own vertical: m (a_m + g e3) is m g (e3 x d) more than the forces,
  // whatever the vehicle does; what is left is of second order in the angle.
  const Vec3 d(0.004, -0.003, 0);
  for (const Plant& plant : six_flights()) {
    const SensorFrame frame = measured(plant, "mocap_tilt", {d.x(), d.y()});
    const Mat3 R = plant.body().q_WB.toRotationMatrix(), R_m = frame.mocap_sample.q_WB.toRotationMatrix();
    const Vec3 a_W = acceleration_W(plant), a_m = R_m * R.transpose() * a_W;  // poses turned, so their curve
    const Vec3 apparent = R_m * (specific_force(R_m, a_m) - specific_force(R, a_W));
    EXPECT_LT((apparent - kGravity * Vec3::UnitZ().cross(d)).norm(), 0.5 * kGravity * d.squaredNorm());
    EXPECT_GT(apparent.norm(), 0.04);
  }
}

}  // namespace
}  // namespace omniflight::simulation
