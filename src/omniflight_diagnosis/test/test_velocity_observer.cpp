#include "../src/conditioning/velocity_observer.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "omniflight_core/random.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kRate = 120;
constexpr Eigen::Index kSamples = 1800;

/// A flight along x at 0.1 and 1.3 Hz, whose poses and accelerometer are noisy; the latter has a bias, too.
struct Noisy {
  Eigen::MatrixXd truth, position, derivative, acceleration;
  std::vector<char> used = std::vector<char>(kSamples, 1);

  Noisy() {
    truth = position = derivative = acceleration = Eigen::MatrixXd::Zero(kSamples, 3);
    Random random(5);
    for (Eigen::Index i = 0; i < kSamples; ++i) {
      const double t = static_cast<double>(i) / kRate, slow = 2 * 3.14159 * 0.1, quick = 2 * 3.14159 * 1.3;
      truth(i, 0) = 0.3 * std::cos(slow * t) + 0.1 * std::cos(quick * t);
      position(i, 0) =
          0.3 / slow * std::sin(slow * t) + 0.1 / quick * std::sin(quick * t) + 5e-4 * random.normal();
      acceleration(i, 0) = -0.3 * slow * std::sin(slow * t) - 0.1 * quick * std::sin(quick * t) + 0.15 +
                           0.05 * random.normal();
    }
    for (Eigen::Index i = 1; i + 1 < kSamples; ++i)
      derivative.row(i) = 0.5 * kRate * (position.row(i + 1) - position.row(i - 1));
  }
  Eigen::MatrixXd observed() const {
    return observed_velocity(position, derivative, acceleration, used, kRate);
  }
};

double rms(const Eigen::MatrixXd& x, Eigen::Index from, Eigen::Index to) {
  return std::sqrt(x.col(0).segment(from, to - from).squaredNorm() / static_cast<double>(to - from));
}

TEST(VelocityObserver, IsQuieterThanADerivative) {
  const Noisy n;
  const double before = rms(n.derivative - n.truth, 600, kSamples - 1),
               now = rms(n.observed() - n.truth, 600, kSamples - 1);
  std::printf("error of the velocity: %.2f mm/s, of the derivative %.2f mm/s\n", 1e3 * now, 1e3 * before);
  EXPECT_LT(now, 0.1 * before);
}

TEST(VelocityObserver, KnowsOfNoLaterSample) {
  Noisy n;
  const Eigen::MatrixXd before = n.observed();
  n.position.bottomRows(kSamples - 901).array() += 1;
  n.acceleration.bottomRows(kSamples - 901).array() += 1;
  EXPECT_EQ(n.observed().topRows(901), before.topRows(901));
}

TEST(VelocityObserver, BeginsAnewBehindAGap) {
  Noisy n;
  for (Eigen::Index i = 800; i < 1000; ++i) {
    n.used[static_cast<std::size_t>(i)] = 0;
    n.position.row(i) = n.position.row(799);  // as gaps hold the last value
  }
  const Eigen::MatrixXd v = n.observed();
  EXPECT_EQ(v.middleRows(800, 201), n.derivative.middleRows(800, 201));
  EXPECT_LT(rms(v - n.truth, 1240, kSamples - 1), 0.015);
}

}  // namespace
}  // namespace omniflight::diagnosis
