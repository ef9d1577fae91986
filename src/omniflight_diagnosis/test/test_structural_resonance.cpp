// Motion that resonates in what the rotors do.
#include "../src/conditioning/structural_resonance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kRate = 250, kPeriod = 1 / kRate;  // Hz, s

/// What moves as a body of mass one with a mass of `share` on a spring, whose resonance with the body is at
/// this frequency [Hz]: by small steps of the two of them.
Eigen::VectorXd with_a_loose_mass(const Eigen::VectorXd& torque, double share, double frequency,
                                  double damping) {
  constexpr int kSteps = 50;
  const double wn = 2 * kPi * frequency, reduced = share / (1 + share), k = reduced * wn * wn,
               d = 2 * damping * wn * reduced;
  double apart = 0, rate = 0;  // of the loose mass from the body
  Eigen::VectorXd out(torque.size());
  for (Eigen::Index i = 0; i < torque.size(); ++i) {
    double mean = 0;
    for (int s = 0; s < kSteps; ++s) {
      const double pull = k * apart + d * rate;
      const double body = torque[i] + pull;
      rate += (-pull / share - body) * kPeriod / kSteps;
      apart += rate * kPeriod / kSteps;
      mean += body / kSteps;
    }
    out[i] = mean;
  }
  return out;
}

std::optional<StructuralResonance> resonance_of(const auto& real_motion) {
  const vehicle::Vehicle v = test::omnimorph();
  const Eigen::MatrixXd speed = test::jittering_speeds(v, kRate),
                        alpha = Eigen::MatrixXd::Constant(speed.rows(), 1, 0.5);
  const std::vector<char> use(static_cast<std::size_t>(speed.rows()), 1);
  const RotorExcitation rotors = rotor_excitation(speed, speed, alpha, kRate, v);
  Eigen::MatrixXd dw = real_motion(Eigen::MatrixXd(rotors.torque * v.inertia.inverse()));
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal(0, 0.1 * dw.norm() / std::sqrt(dw.size()));
  for (double& value : dw.reshaped()) value += normal(random);
  return structural_resonance(RotorRegression(dw, Eigen::MatrixXd(0, 3), rotors, kRate, use), 0.0015, 2.5);
}

TEST(StructuralResonance, ALooseMassIsTold) {
  const auto found = resonance_of([](Eigen::MatrixXd dw) {
    for (Eigen::Index c = 0; c < 2; ++c) dw.col(c) = with_a_loose_mass(dw.col(c), 0.15, 12, 0.05);
    return dw;
  });
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->frequency_hz, 12, 0.3);
  EXPECT_NEAR(found->share, 0.15, 0.06);
  EXPECT_GT(found->log_factor, 20);
  EXPECT_EQ(as_fault(*found).effect, "structural_mode");
}

TEST(StructuralResonance, RotorsThatAnswerToTheMotionTellNothing) {
  EXPECT_FALSE(resonance_of([](const Eigen::MatrixXd& dw) {
    Eigen::MatrixXd before = dw;  // by 12 ms
    for (Eigen::Index c = 0; c < 2; ++c) before.col(c) = with_a_loose_mass(dw.col(c), 0.15, 12, 0.05);
    before.topRows(dw.rows() - 3) = Eigen::MatrixXd(before.bottomRows(dw.rows() - 3));
    return before;
  }));
}

TEST(StructuralResonance, MotionAtOnceAndALateClockAreNot) {
  EXPECT_FALSE(resonance_of([](Eigen::MatrixXd dw) { return dw; }));
  EXPECT_FALSE(resonance_of([](const Eigen::MatrixXd& dw) {
    Eigen::MatrixXd late = dw;
    late.bottomRows(dw.rows() - 2) = dw.topRows(dw.rows() - 2);
    return late;
  }));
}

}  // namespace
}  // namespace omniflight::diagnosis
