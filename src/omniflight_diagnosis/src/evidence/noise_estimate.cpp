#include "noise_estimate.hpp"

#include "../discrepancy/patterns.hpp"
#include "inner_products.hpp"

namespace omniflight::diagnosis {
namespace {

/// Prior standard deviations of the rich model over those of the hypotheses.
constexpr double kGenerous = 3;
/// Where slow columns of one prior standard deviation have less than this part of an amplitude's variance,
/// they are left out of it: the frequencies, nine tenths of them, above what a function of place does.
constexpr double kLeastShare = 0.1;

}  // namespace

SlowColumns slow_columns(const RegressionProblem& problem) {
  std::vector<Eigen::MatrixXd> parts;
  const Calibration& c = problem.calibration();
  Eigen::Index total = 0;
  for (std::size_t k = 0; k < c.names.size(); ++k) {
    const bool constant =
        c.kinds[k] == "torque_trim" || c.kinds[k] == "world_force" || c.kinds[k] == "acceleration_bias";
    if (!constant) continue;
    parts.emplace_back(c.columns.col(static_cast<Eigen::Index>(k)));
    ++total;
  }
  for (Pattern& p : make_patterns(problem)) {
    if (p.world || (p.variable != "height" && p.variable != "position x" && p.variable != "position y" &&
                    p.variable != "rotor tilt"))
      continue;
    total += p.raw.cols();
    parts.push_back(kGenerous * p.raw);
  }
  SlowColumns out;
  out.raw.resize(problem.rows(), total);
  Eigen::Index at = 0;
  for (const Eigen::MatrixXd& part : parts) {
    out.raw.middleCols(at, part.cols()) = part;
    at += part.cols();
  }
  out.amplitudes = cosine_amplitudes(problem, out.raw);
  out.power = out.amplitudes.rowwise().squaredNorm();
  return out;
}

std::unique_ptr<NoiseModel> estimate_noise(const RegressionProblem& problem, const SlowColumns& slow,
                                           const Eigen::VectorXd& known, double temperature) {
  const Eigen::VectorXd y = problem.residual() - known;
  Eigen::VectorXd rest = y;
  const int n = problem.samples();
  for (int c = 0; c < 6; ++c) rest.segment(c * n, n).array() -= rest.segment(c * n, n).mean();
  const Eigen::VectorXd z = cosine_amplitudes(problem, y);
  Eigen::VectorXd freedom = Eigen::VectorXd::Ones(z.size());
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::VectorXd inverse = NoiseModel(problem, rest, freedom, 1).inverse_deviations();
    std::vector<Eigen::Index> rows;
    for (Eigen::Index i = 0; i < z.size(); ++i)
      if (inverse[i] * inverse[i] * slow.power[i] > kLeastShare) rows.push_back(i);
    const Eigen::MatrixXd X = inverse(rows).asDiagonal() * slow.amplitudes(rows, Eigen::all);
    Eigen::MatrixXd H = inner_products(X);
    H.diagonal().array() += 1;
    const Eigen::LLT<Eigen::MatrixXd> factor(H);
    rest = y - slow.raw * factor.solve(X.transpose() * inverse(rows).cwiseProduct(z(rows)));
    // diagonal of X H^-1 X^T; by the inverse of a small triangle, since products are quicker than long
    // solutions
    const Eigen::MatrixXd inverse_root =
        factor.matrixL().solve(Eigen::MatrixXd::Identity(H.rows(), H.cols()));
    const Eigen::MatrixXd rooted =
        inner_products(Eigen::MatrixXd(X.transpose()), Eigen::MatrixXd(inverse_root.transpose()));
    freedom.setOnes();
    freedom(rows) = 1 - rooted.rowwise().squaredNorm().array();
  }
  return std::make_unique<NoiseModel>(problem, rest, freedom, temperature);
}

}  // namespace omniflight::diagnosis
