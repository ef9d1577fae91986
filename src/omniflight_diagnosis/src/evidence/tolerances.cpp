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
  std::set<std::string> kinds;
  for (std::size_t k = 0; k < calibration.kinds.size(); ++k)
    if (calibration.settled[static_cast<Eigen::Index>(k)] < 1) kinds.insert(calibration.kinds[k]);
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

Eigen::VectorXd tightest_tolerances(const Calibration& calibration) {
  return (calibration.settled.array() < 1)
      .select(Eigen::VectorXd::Constant(calibration.settled.size(), kFactors.back()), 1.0);
}

}  // namespace omniflight::diagnosis
