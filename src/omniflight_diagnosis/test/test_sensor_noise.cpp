// Recordings of simulators without any noise.
#include "../src/conditioning/sensor_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::diagnosis {
namespace {

/// A figure of 0.5 m at 0.3 Hz and a roll of 0.2 rad, sampled at 100 Hz, with these RMS of noise [m/s^2,
/// rad/s].
recording::Recording flown(double accelerometer_noise, double gyro_noise) {
  constexpr int kSamples = 1000;
  const double w = 2 * kPi * 0.3;
  recording::Recording r;
  for (const auto& [name, width] : {std::pair{"acc", 3}, {"gyro", 3}, {"position", 3}, {"attitude", 4}}) {
    recording::Signal& s = r.signals[name];
    s.name = name;
    s.values.setZero(kSamples, width);
    for (int i = 0; i < kSamples; ++i) s.t_s.push_back(0.01 * i);
  }
  Random random(1);
  for (int i = 0; i < kSamples; ++i) {
    const double t = 0.01 * i, roll = 0.2 * std::sin(w * t);
    const Vec3 up(0, 0, kGravity), p(0.5 * std::sin(w * t), 0.5 * std::cos(w * t), 1);
    const Quat q = exp_rotation(Vec3(roll, 0, 0));
    const Vec3 a(-w * w * p.x(), -w * w * p.y(), 0);
    r.signals["acc"].values.row(i) = (q.inverse() * (a + up)).transpose();
    r.signals["gyro"].values(i, 0) = 0.2 * w * std::cos(w * t);
    r.signals["position"].values.row(i) = p.transpose();
    r.signals["attitude"].values.row(i) << q.w(), q.x(), q.y(), q.z();
    for (int k = 0; k < 3; ++k) {
      r.signals["acc"].values(i, k) += accelerometer_noise * random.normal();
      r.signals["gyro"].values(i, k) += gyro_noise * random.normal();
    }
  }
  return r;
}

double rms_of_change(const recording::Recording& a, const recording::Recording& b, const char* name) {
  const Eigen::MatrixXd change = a.find(name)->values - b.find(name)->values;
  return std::sqrt(change.squaredNorm() / static_cast<double>(change.size()));
}

TEST(SensorNoise, IsAddedWhereThereIsNone) {
  const recording::Recording clean = flown(0, 0);
  recording::Recording noisy = clean;
  ASSERT_TRUE(add_missing_noise(noisy));
  // densities of 2.5e-3 m/s^2, 1.3e-4 rad/s and 1.3e-5 m a root of Hz, at 100 Hz
  EXPECT_NEAR(rms_of_change(noisy, clean, "acc"), 2.5e-2, 2e-3);
  EXPECT_NEAR(rms_of_change(noisy, clean, "gyro"), 1.3e-3, 1e-4);
  EXPECT_NEAR(rms_of_change(noisy, clean, "position"), 1.3e-4, 1e-5);
  for (Eigen::Index i = 0; i < noisy.find("attitude")->size(); ++i)
    ASSERT_NEAR(noisy.find("attitude")->values.row(i).norm(), 1, 1e-12);
  recording::Recording again = noisy;
  EXPECT_FALSE(add_missing_noise(again)) << "now there is some";
  EXPECT_EQ(again.find("acc")->values, noisy.find("acc")->values);
}

TEST(SensorNoise, IsLeftWhereOneSensorHasSome) {
  for (recording::Recording r : {flown(0.05, 0), flown(0, 0.005)}) EXPECT_FALSE(add_missing_noise(r));
  recording::Recording wide = flown(0, 0);
  wide.signals.at("gyro").values.conservativeResize(Eigen::NoChange, 2);
  EXPECT_FALSE(add_missing_noise(wide)) << "no rate about three axes";
  recording::Recording motors;
  EXPECT_FALSE(add_missing_noise(motors)) << "no sensor of motion";
}

}  // namespace
}  // namespace omniflight::diagnosis
