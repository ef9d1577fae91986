#include "tolerances.hpp"

#include <array>
#include <set>

namespace omniflight::diagnosis {

namespace {

/// Factors that are asked, equally likely before the flight: from half as well as assumed to instruments of a
/// metrologist.
constexpr std::array<double, 6> kFactors{2, 1, 0.5, 0.25, 0.125, 0.0625};
constexpr int kSweeps = 3;  ///< over the kinds

}  // namespace

Eigen::VectorXd likeliest_tolerances(const Calibration& calibration, const SetFit& fit,
                                     const Eigen::VectorXd& current) {
  if (current.size() == 0) return current;
  // about the optimum the residual is linear in the coordinates, so that a change of the prior is exact
  const Eigen::Index size = fit.coordinates.size();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(size, size);
  const Eigen::MatrixXd products = fit.precision - identity;
  const Eigen::VectorXd moment = products * fit.coordinates + fit.columns.transpose() * fit.rest;
  const Eigen::VectorXd now = calibration.deviations(current);
  const auto evidence = [&](const Eigen::VectorXd& factors) {
    Eigen::VectorXd scale = Eigen::VectorXd::Ones(size);
    scale.head(now.size()) = calibration.deviations(factors).cwiseQuotient(now);
    const Eigen::LLT<Eigen::MatrixXd> llt(scale.asDiagonal() * products * scale.asDiagonal() + identity);
    const Eigen::VectorXd b = scale.cwiseProduct(moment);
    return 0.5 * b.dot(llt.solve(b)) - llt.matrixLLT().diagonal().array().log().sum();
  };
  Eigen::VectorXd best = current;
  double most = evidence(best);
  std::set<std::string> kinds;
  for (std::size_t k = 0; k < calibration.kinds.size(); ++k)
    if (calibration.settled[static_cast<Eigen::Index>(k)] < 1) kinds.insert(calibration.kinds[k]);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const Eigen::VectorXd before = best;
    for (const std::string& kind : kinds)
      for (const double factor : kFactors) {
        Eigen::VectorXd trial = best;
        for (std::size_t k = 0; k < calibration.kinds.size(); ++k)
          if (calibration.kinds[k] == kind) trial[static_cast<Eigen::Index>(k)] = factor;
        if (trial == best) continue;
        const double value = evidence(trial);
        if (value > most) most = value, best = trial;
      }
    if (best == before) break;
  }
  return best;
}

}  // namespace omniflight::diagnosis
