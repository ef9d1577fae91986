#include "prediction_horizon.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "../evidence/first_stage.hpp"
#include "../evidence/noise_estimate.hpp"
#include "../regression/predetermined.hpp"

namespace omniflight::diagnosis {
namespace {

/// Horizons [s] that are asked besides the shortest that the sensors' kernels allow; controllers of
/// multirotors answer within about 0.1 s, so that little of a disturbance is left in what was predicted 0.3 s
/// before.
constexpr std::array<double, 3> kHorizons{0.075, 0.15, 0.3};

constexpr std::array<const char*, 12> kAsked{"Fx of rotors", "Fy of rotors", "Fz of rotors", "Mx of rotors",
                                             "My of rotors", "Mz of rotors", "drag along x", "drag along y",
                                             "drag along z", "drag about x", "drag about y", "drag about z"};

/// The vector whose product with the whitened residual is the estimate of a coefficient; empty: not excited,
/// or not predictable.
using Estimator = Eigen::VectorXd;

std::array<Estimator, 12> estimators(const RegressionProblem& p, const NoiseModel& noise) {
  std::array<Estimator, 12> out;
  const int n = p.samples();
  std::vector<Vec6> predicted, measured;  // of the rotors
  for (int i = 0; i < n; ++i) {
    predicted.push_back(physics::rotor_wrench(p.situation(i)));
    measured.push_back(physics::rotor_wrench(p.measured(i)));
  }
  for (int c = 0; c < (p.forces_only() ? 3 : 6); ++c) {
    // of rotors and of drag: predicted, measured; constant
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(p.rows(), 5);
    for (int i = 0; i < n; ++i) {
      const physics::Situation &x = p.situation(i), &m = p.measured(i);
      const auto at = static_cast<std::size_t>(i);
      columns.row(c * n + i) << predicted[at][c], c < 3 ? x.v_WB_B[c] : x.body.w_WB_B[c - 3], measured[at][c],
          c < 3 ? m.v_WB_B[c] : m.body.w_WB_B[c - 3], p.scale(c);
    }
    Eigen::MatrixXd x = noise.apply(columns);
    const double constant = x.col(4).squaredNorm();
    if (!(constant > 0)) continue;
    for (int k = 0; k < 4; ++k) x.col(k) -= x.col(4) * (x.col(4).dot(x.col(k)) / constant);
    for (int k = 0; k < 2; ++k)
      if (first_stage(x.col(k), x.col(k + 2)) != 0)
        out[static_cast<std::size_t>(6 * k + c)] = x.col(k) / x.col(k).dot(x.col(k + 2));
  }
  return out;
}

}  // namespace

double HorizonChoice::dispersion() const {
  return tests.size() < 2 ? 1.0 : std::max(1.0, tests[tests.size() - 2].statistic / kHorizonsDisagree);
}

std::unique_ptr<RegressionProblem> problem_of_consistent_horizon(std::span<const Flight* const> flights,
                                                                 const vehicle::Vehicle& vehicle,
                                                                 const Options& o, HorizonChoice& choice) {
  double least = 0;
  for (const Flight* f : flights) least = std::max(least, least_horizon(*f));
  std::vector<double> horizons{least};
  for (const double h : kHorizons)
    if (h > horizons.back() + 0.5 / o.grid_hz) horizons.push_back(h);
  std::vector<std::unique_ptr<RegressionProblem>> problems;
  for (const double h : horizons)
    problems.push_back(std::make_unique<RegressionProblem>(flights, vehicle, o, h));
  const RegressionProblem& first = *problems.front();
  const auto noise = estimate_noise(first, slow_columns(first), Eigen::VectorXd::Zero(first.rows()), 1.0);
  const Eigen::VectorXd z = noise->apply(first.residual());
  std::vector<std::array<Estimator, 12>> all;
  for (const auto& p : problems) all.push_back(estimators(*p, *noise));
  for (std::size_t chosen = 0;; ++chosen) {  // the longest has nothing to disagree with
    HorizonTest test{horizons[chosen], 0, ""};
    for (std::size_t longer = chosen + 1; longer < horizons.size(); ++longer)
      for (std::size_t k = 0; k < 12; ++k) {
        const Estimator &here = all[chosen][k], &there = all[longer][k];
        if (here.size() == 0 || there.size() == 0) continue;
        const Eigen::VectorXd difference = here - there;
        const double statistic = std::pow(difference.dot(z), 2) / difference.squaredNorm();
        if (statistic > test.statistic) test = {horizons[chosen], statistic, kAsked[k]};
      }
    choice.tests.push_back(test);
    if (test.statistic < kHorizonsDisagree) return std::move(problems[chosen]);
  }
}

}  // namespace omniflight::diagnosis
