// Lines of the rotors in the accelerometer.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../src/sensor_checks/vibration_check.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// The accelerometer of a flight with an imbalance [m] of one rotor added, at speeds that wander.
recording::Recording shaken(const vehicle::Vehicle& v, double imbalance, std::size_t rotor) {
  recording::Recording r = test::fly(v, {}, {.duration_s = 20, .rate_hz = 200});
  recording::Signal &speed = r.signals.at("rotor_speed"), &acc = r.signals.at("acc");
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  for (Eigen::Index c = 0; c < speed.width(); ++c) {
    double wander = 0;
    for (Eigen::Index i = 0; i < speed.size(); ++i) {
      wander = 0.98 * wander + 2 * normal(random);
      speed.values(i, c) = std::abs(speed.values(i, c)) + wander;
    }
  }
  double angle = 0;
  for (Eigen::Index i = 0; i < acc.size(); ++i) {
    const double omega = speed.values(i, static_cast<Eigen::Index>(rotor));
    if (i > 0) angle += 0.5 * (omega + speed.values(i - 1, static_cast<Eigen::Index>(rotor))) / 200;
    acc.values(i, 0) += imbalance * omega * omega * std::cos(angle);
    acc.values(i, 1) += imbalance * omega * omega * std::sin(angle);
  }
  return r;
}

Diagnosis judged(const recording::Recording& r, const vehicle::Vehicle& v, double told) {
  Options o;
  o.noise.accelerometer = told;
  Diagnosis d;
  add_vibration(r, v, o, d);
  return d;
}

TEST(Vibration, AnImbalanceIsNamedWithItsRotorAndItsSize) {
  const vehicle::Vehicle v = test::omnimorph();
  const Diagnosis d = judged(shaken(v, 4e-7, 2), v, 0.05);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_EQ(d.findings[0].effect, "vibration");
  EXPECT_GT(d.findings[0].log_factor, 20);
  EXPECT_NE(d.findings[0].sentence.find("rotor 3"), std::string::npos) << d.findings[0].sentence;
  ASSERT_EQ(d.findings[0].parameters.size(), 1u);
  EXPECT_NEAR(d.findings[0].parameters[0].value, 4e-7, 1e-7);
}

TEST(Vibration, BalancedRotorsAreNotNamedNorWhatNobodyToldTheNoiseOf) {
  const vehicle::Vehicle v = test::omnimorph();
  const Diagnosis calm = judged(shaken(v, 0, 2), v, 0.05);
  EXPECT_TRUE(calm.findings.empty() || calm.findings[0].log_factor < 2) << calm.findings[0].log_factor;
  EXPECT_TRUE(judged(shaken(v, 4e-7, 2), v, 0).findings.empty());
}

}  // namespace
}  // namespace omniflight::diagnosis
