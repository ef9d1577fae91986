#include "tolerances.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <string>

namespace omniflight::diagnosis {

namespace {

/// Factors that are asked, equally likely before the flight: from half as well as assumed to instruments of a
/// metrologist.
constexpr std::array<double, 6> kFactors{2, 1, 0.5, 0.25, 0.125, 0.0625};
constexpr int kSweeps = 3;  ///< over the kinds
/// ln: one standard deviation between laboratories, and between kinds of numbers within one.
const double kBetween = std::log(4.0), kWithin = std::log(3.0);

std::set<std::string> untold_kinds(const Calibration& calibration) {
  std::set<std::string> kinds;
  for (std::size_t k = 0; k < calibration.kinds.size(); ++k)
    if (calibration.settled[static_cast<Eigen::Index>(k)] < 1) kinds.insert(calibration.kinds[k]);
  return kinds;
}

}  // namespace

Eigen::VectorXd likeliest_tolerances(const Calibration& calibration, const SetFit& fit,
                                     const Eigen::VectorXd& current) {
  if (current.size() == 0) return current;
  // about the optimum the residual is linear in the coordinates, so that a change of the prior is exact
  const Eigen::Index size = fit.coordinates.size();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(size, size);
  const Eigen::MatrixXd products = fit.precision - identity;
  const Eigen::VectorXd moment = products * fit.coordinates + fit.moment;
  const Eigen::VectorXd now = calibration.deviations(current);
  const auto evidence = [&](const Eigen::VectorXd& factors) {
    Eigen::VectorXd scale = Eigen::VectorXd::Ones(size);
    const Eigen::VectorXd then = calibration.deviations(factors);
    scale.head(now.size()) = then.cwiseQuotient(now);
    const Eigen::LLT<Eigen::MatrixXd> llt(scale.asDiagonal() * products * scale.asDiagonal() + identity);
    const Eigen::VectorXd b = scale.cwiseProduct(moment);
    return 0.5 * b.dot(llt.solve(b)) - llt.matrixLLT().diagonal().array().log().sum() -
           log_density_of_totals(calibration, then) + log_prior_of_tolerances(calibration, factors);
  };
  const std::set<std::string> kinds = untold_kinds(calibration);
  Eigen::VectorXd best = current;
  double most = evidence(best);
  // what a wide tolerance takes up may also be an effect of the set: asked from both ends
  for (Eigen::VectorXd here : {current, tightest_tolerances(calibration)}) {
    double value = evidence(here);
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      const double before = value;
      for (const std::string& kind : kinds)
        for (const double factor : kFactors) {
          Eigen::VectorXd trial = here;
          for (std::size_t k = 0; k < calibration.kinds.size(); ++k)
            if (calibration.kinds[k] == kind) trial[static_cast<Eigen::Index>(k)] = factor;
          if (trial == here) continue;
          if (const double there = evidence(trial); there > value) value = there, here = trial;
        }
      if (value == before) break;
    }
    if (value > most) most = value, best = here;
  }
  return best;
}

double log_prior_of_tolerances(const Calibration& calibration, const Eigen::VectorXd& factors) {
  if (calibration.told.empty()) return 0;
  // normal in both stages: the laboratory given what it told, then a kind of numbers given the laboratory
  const double n = static_cast<double>(calibration.told.size()), within = kWithin * kWithin;
  const double sum = std::accumulate(calibration.told.begin(), calibration.told.end(), 0.0);
  const double mean = sum / (n + within / (kBetween * kBetween));
  const double variance = within + 1 / (n / within + 1 / (kBetween * kBetween));
  const auto loss = [&](double factor) { return 0.5 * std::pow(std::log(factor) - mean, 2) / variance; };
  double least = 1e300;
  for (const double factor : kFactors) least = std::min(least, loss(factor));
  double out = 0;
  for (const std::string& kind : untold_kinds(calibration)) {
    const auto at = std::find(calibration.kinds.begin(), calibration.kinds.end(), kind);
    out -= loss(factors[at - calibration.kinds.begin()]) - least;
  }
  return out;
}

Eigen::VectorXd tightest_tolerances(const Calibration& calibration) {
  return (calibration.settled.array() < 1)
      .select(Eigen::VectorXd::Constant(calibration.settled.size(), kFactors.back()), 1.0);
}

}  // namespace omniflight::diagnosis
