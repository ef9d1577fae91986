#include "noise_estimate.hpp"

#include "../discrepancy/patterns.hpp"

namespace omniflight::diagnosis {
namespace {

/// Prior standard deviations of the rich model over those of the hypotheses.
constexpr double kGenerous = 3;

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
  return out;
}

std::unique_ptr<NoiseModel> estimate_noise(const RegressionProblem& problem, const SlowColumns& slow,
                                           const Eigen::VectorXd& known, double temperature) {
  const Eigen::VectorXd y = problem.residual() - known;
  Eigen::VectorXd rest = y;
  const int n = problem.samples();
  for (int c = 0; c < 6; ++c) rest.segment(c * n, n).array() -= rest.segment(c * n, n).mean();
  Eigen::VectorXd freedom = Eigen::VectorXd::Ones(slow.amplitudes.rows());
  for (int pass = 0; pass < 2; ++pass) {
    const NoiseModel noise(problem, rest, freedom, 1);
    const Eigen::MatrixXd X = noise.scale(slow.amplitudes);
    Eigen::MatrixXd H = Eigen::MatrixXd::Identity(X.cols(), X.cols());
    H.selfadjointView<Eigen::Lower>().rankUpdate(X.transpose());
    const Eigen::LLT<Eigen::MatrixXd> factor(H);
    rest = y - slow.raw * factor.solve(X.transpose() * noise.apply(y));
    const Eigen::MatrixXd half = factor.matrixL().solve(X.transpose());
    freedom = noise.by_amplitude(1 - half.colwise().squaredNorm().transpose().array(), 1);
  }
  return std::make_unique<NoiseModel>(problem, rest, freedom, temperature);
}

}  // namespace omniflight::diagnosis
