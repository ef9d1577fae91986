// Clocks of rotors and gyroscope, told by the torques.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../src/conditioning/torque_alignment.hpp"
#include "omniflight_diagnosis/filter.hpp"
#include "omniflight_physics/situation.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kRate = 500;  // Hz

/// Rotor speeds that shake the vehicle, and the angular acceleration they cause `lag_s` later beside a
/// disturbance of `share` of its size.
struct Shaken {
  Eigen::MatrixXd dw, speed, alpha;
  std::vector<char> use;

  Shaken(const vehicle::Vehicle& v, double lag_s, double share) {
    constexpr int n = 5000;
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    const auto noise = [&](Eigen::Index columns) {
      Eigen::MatrixXd x(n, columns);
      for (double& value : x.reshaped()) value = normal(random);
      return low_pass(x, kRate, 12);
    };
    speed = noise(v.rotor_count());
    for (Eigen::Index r = 0; r < speed.cols(); ++r) {
      const double hover = 0.6 * v.rotors[static_cast<std::size_t>(r)].max_speed();
      speed.col(r) = (hover + 0.3 * hover * speed.col(r).array()).matrix();
    }
    alpha = Eigen::MatrixXd::Constant(n, 1, 0.5);
    use.assign(n, 1);
    Eigen::MatrixXd torque(n, 3);
    physics::Situation s;
    for (int i = 0; i < n; ++i) {
      const Eigen::VectorXd now = speed.row(i);
      physics::prepare(v, {}, 0.5, {now.data(), static_cast<std::size_t>(now.size())}, {}, {}, s);
      torque.row(i) = physics::rotor_wrench(s).tail<3>().transpose();
    }
    dw = delayed(torque * v.inertia.inverse(), lag_s, kRate);
    const Eigen::MatrixXd push = noise(3);
    for (int c = 0; c < 3; ++c) dw.col(c) += share * dw.col(c).norm() / push.col(c).norm() * push.col(c);
  }
  std::optional<TorqueLag> lag(const vehicle::Vehicle& v) const {
    const RotorExcitation rotors = rotor_excitation(speed, speed, alpha, kRate, v);
    return lag_behind_rotors(RotorRegression(dw, Eigen::MatrixXd(0, 3), rotors, kRate, use));
  }
};

TEST(TorqueAlignment, TheFilterOfAGyroscopeIsFound) {
  const vehicle::Vehicle v = test::omnimorph();
  for (const double lag_s : {-0.003, 0.0, 0.0045, 0.011}) {
    const Shaken x(v, lag_s, 0.2);
    const auto lag = x.lag(v);
    ASSERT_TRUE(lag) << lag_s;
    EXPECT_NEAR(lag->lag_s, lag_s, 5e-4);
    EXPECT_GT(lag->explained, 0.9);
  }
}

TEST(TorqueAlignment, WhereSomethingElsePushesNothingIsSaid) {
  const vehicle::Vehicle v = test::omnimorph();
  const Shaken x(v, 0.0045, 1.0);
  EXPECT_FALSE(x.lag(v));
}

}  // namespace
}  // namespace omniflight::diagnosis
