// The published figures contradict each other (34 % lost by the lower rotors, and a multiplier of 0.35 for
// all), so they belong to two sets of parameters of one law; the tilt enters through geometry only.
#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "downwash_interference";

/// Force [N] along n that each rotor gains, from the world positions of hubs and wakes.
std::vector<double> gains(const Situation& s, double kz, double beta, double mixing) {
  std::vector<double> out;
  for (std::size_t j = 0; j < 8; ++j) {
    double sum = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      if (i == j) continue;
      const RotorSituation &a = s.rotors[i], &b = s.rotors[j];
      const Vec3 wake = s.R_WB * a.n_B * (a.thrust > 0 ? -1.0 : 1.0), axis = s.R_WB * b.n_B;
      const Vec3 to = (s.body.p_WB + s.R_WB * b.p_BR) - (s.body.p_WB + s.R_WB * a.p_BR);
      const double v =
          std::sqrt(std::abs(a.thrust) / (2 * s.environment.air_density * kPi * a.radius * a.radius));
      const double z = to.dot(wake), off = (to - z * wake).norm();
      const double width = std::sqrt(b.radius * b.radius / 2 + beta * beta * a.radius * a.radius);
      const double air = v * (1 + z / std::hypot(z, a.radius)) / 2 * std::pow(a.radius / width, 2) *
                         std::exp(-std::pow(off / width, 2));
      sum += air * ((1 - mixing) * wake.dot(axis) - mixing * (b.thrust > 0 ? 1.0 : -1.0));
    }
    out.push_back(kz * std::abs(s.rotors[j].speed) * sum);
  }
  return out;
}

TEST(DownwashInterference, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states())
    for (const auto& theta : {std::vector<double>{2e-4, 0.8, 0.0}, {1e-3, 2.5, 0.6}}) {
      Vec6 expected = Vec6::Zero();
      const auto gain = gains(s, theta[0], theta[1], theta[2]);
      for (std::size_t j = 0; j < 8; ++j) expected += at_hub(s.rotors[j], gain[j] * s.rotors[j].n_B);
      EXPECT_GT(expected.norm(), 0.01);
      EXPECT_LT((wrench_of(kId, s, theta) - expected).norm(), 1e-12);
    }
  EXPECT_EQ(wrench_of(kId, six_states()[0], neutral_of(kId)).norm(), 0.0);
}

TEST(DownwashInterference, LowerRotorsLose34PercentAt120HertzAndUpperOnesNearlyNothing) {
  const auto lost = [](double kz) {
    const Situation s = hover(1.0);
    const auto gain = gains(s, kz, std::sqrt(0.5), 0.0);
    return std::pair(-gain[4] / s.rotors[4].thrust, -gain[0] / s.rotors[0].thrust);
  };
  const auto& parameters = find_effect(kId)->info().parameters;
  const auto [lower, upper] = lost(parameters[0].typical);
  EXPECT_NEAR(lower, 0.34, 0.01);  // Bazzana: 0.92 N of 2.7 N
  EXPECT_NEAR(hover(1.0).rotors[4].thrust * lower, 0.92, 0.03);
  EXPECT_LT(upper, 0.02);
  // nothing fitted: the inflow coefficient that RotorPy has for a rotor of the same radius (Hummingbird, 0.10
  // m)
  EXPECT_NEAR(lost(2.32e-4).first, 0.34, 0.04);
}

TEST(DownwashInterference, TheLossFollowsWhoBlowsAtWhom) {
  const auto gain = [](const Situation& s) { return gains(s, 2.1e-4, 0.7071, 0.0); };
  // turned over and flying on reversed rotors, the former upper ones are below
  RigidState upside_down;
  upside_down.q_WB = exp_rotation(Vec3(kPi, 0, 0));
  const Situation flipped = situation(cube(), upside_down, 0.0, std::vector<double>(8, -754.0));
  const Situation upright = hover(1.0, 0.0, 754.0);
  EXPECT_NEAR(-gain(flipped)[0] / flipped.rotors[0].thrust, -gain(upright)[4] / upright.rotors[4].thrust,
              1e-12);
  // less load above, less loss below
  Situation light = upright;
  light.rotors[0].thrust *= 0.25;
  EXPECT_NEAR(gain(light)[4] / gain(upright)[4], 0.5, 0.01);
  // at 45 degrees the wakes miss
  const Situation tilted = hover(1.0, kPi / 4);
  EXPECT_LT(-gain(tilted)[4] / tilted.rotors[4].thrust, 0.02);
}

TEST(DownwashInterference, TheThesisMultiplierIsAFitOfTheLaw) {
  // 0.35 at 0 deg rising linearly to 0.70 at 60 deg, for the thrust of all rotors: Gauss-Newton over the
  // three parameters with the law's own derivative, then a straight line through what the law gives.
  const Effect& e = *find_effect(kId);
  Eigen::Vector3d theta(1e-3, 2.0, 0.5);
  const auto efficiency = [&](double alpha, Eigen::RowVector3d* slope) {
    const Situation s = hover(1.0, alpha);
    Vec6 w;
    Eigen::Matrix<double, 6, 3> J;
    e.wrench_with_jacobian(s, theta.data(), w.data(), J.data());
    const double all = rotor_wrench(s)[2];
    if (slope) *slope = J.row(2) / all;
    return 1.0 + w[2] / all;
  };
  const int n = 13;
  Eigen::VectorXd rest(n);
  for (int step = 0; step < 60; ++step) {
    Eigen::MatrixXd J(n, 3);
    for (int k = 0; k < n; ++k) {
      Eigen::RowVector3d slope;
      rest[k] = 0.35 + 0.35 * k / (n - 1) - efficiency(k * kPi / 3 / (n - 1), &slope);
      J.row(k) = slope;
    }
    theta += 0.5 * J.colPivHouseholderQr().solve(rest);
    for (int k = 0; k < 3; ++k)
      theta[k] = std::clamp(theta[k], e.info().parameters[static_cast<std::size_t>(k)].lower + 1e-6,
                            e.info().parameters[static_cast<std::size_t>(k)].upper);
  }
  EXPECT_LT(rest.cwiseAbs().maxCoeff(), 0.02) << theta.transpose();
  Eigen::MatrixXd line(n, 2);
  Eigen::VectorXd eta(n);
  for (int k = 0; k < n; ++k) {
    line.row(k) << 1.0, static_cast<double>(k) / (n - 1);
    eta[k] = efficiency(k * kPi / 3 / (n - 1), nullptr);
  }
  const Eigen::Vector2d fit = line.colPivHouseholderQr().solve(eta);
  EXPECT_NEAR(fit[0], 0.35, 0.01);
  EXPECT_NEAR(fit[0] + fit[1], 0.70, 0.01);
}

}  // namespace
}  // namespace omniflight::physics::testing
