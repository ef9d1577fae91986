#include "gate.hpp"

#include <algorithm>
#include <cmath>

#include "blocks.hpp"
#include "bounded_step.hpp"
#include "statistics.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;
using physics::Parameter;

/// As many equal blocks as these are worth by their information.
double worth_of(const std::vector<double>& information) {
  double sum = 1e-300, squares = 0;
  for (double v : information) sum += v;
  for (double v : information) squares += std::pow(v / sum, 2);
  return squares > 0 ? 1 / squares : 0.0;
}

/// Mean of the gains in its standard errors. Where blocks differ much in how strongly the effect acts, their
/// gains spread for that reason alone: then the gain per information (ratio estimator) is asked as well, as a
/// normal score; two stands for an error rate of one per cent.
double standard_errors_above_zero(const std::vector<double>& gains, const std::vector<double>& information) {
  const auto count = static_cast<double>(gains.size());
  double mean = 0, all = 1e-300, variance = 0, off = 0;
  for (double v : gains) mean += v / count;
  for (double v : information) all += v;
  for (std::size_t k = 0; k < gains.size(); ++k) {
    const double share = information[k] / all;
    variance += std::pow(gains[k] - mean, 2) / std::max(1.0, count - 1);
    off += std::pow(gains[k] - count * mean * share, 2);
  }
  if (!(variance > 0)) return mean > 0 ? 1e9 : 0.0;
  const double plain = mean / std::sqrt(variance / count);
  const double worth = worth_of(information), freedom = worth - 1;
  if (freedom < 1 || !(off > 0)) return plain;
  const double t = count * mean / std::sqrt(off / (1 - 1 / worth));
  const double score = t * (1 - 0.25 / freedom) / std::sqrt(1 + 0.5 * t * t / freedom);
  constexpr double kOnePercent = 2.326;
  return std::max(plain, 2 / kOnePercent * score);
}

/// The share of energy that is gone from `before` to `after`, in the channel and flight where that is most.
/// Another flight in which an effect hardly acts does not make it smaller.
double most_removed(const Problem& problem, const Eigen::VectorXd& before, const Eigen::VectorXd& after) {
  double most = 0;
  for (int c = 0; c < 6; ++c)
    for (int flight = 0; flight < problem.flights(); ++flight) {
      double energy = 0, left = 0;
      for (const Run& run : problem.runs()) {
        if (run.flight != flight) continue;
        const int first = c * problem.samples() + run.begin, count = run.end - run.begin;
        energy += before.segment(first, count).squaredNorm();
        left += after.segment(first, count).squaredNorm();
      }
      if (energy > 0) most = std::max(most, (energy - left) / energy);
    }
  return most;
}

}  // namespace

Gate gate_effect(const Problem& problem, const Fit& full, std::size_t index, const Options& options) {
  const Eigen::MatrixXd raw = jacobian_of(problem, full);
  const Eigen::MatrixXd X = problem.whitened(full.effects, raw);
  Eigen::Index first = 0;
  for (std::size_t k = 0; k < index; ++k) first += full.effects[k].effect->parameter_count();
  const Eigen::Index width = full.effects[index].effect->parameter_count();
  // shapes of the others stay as they are: linearised, they would run away on the blocks left out
  std::vector<Eigen::Index> kept;
  Eigen::Index column = 0;
  for (const ActiveEffect& e : full.effects)
    for (const Parameter& p : e.effect->info().parameters) {
      if (!is_shape(p) && (column < first || column >= first + width)) kept.push_back(column);
      ++column;
    }
  for (; column < X.cols(); ++column) kept.push_back(column);
  // the contribution to be predicted: what remains plus what the effect explains
  const Eigen::VectorXd value = contribution_of(problem, full, index);
  const Eigen::VectorXd without = problem.noise().apply_vector(problem, full.residual + value);
  const Eigen::VectorXd own = problem.noise().apply_vector(problem, value);
  Eigen::MatrixXd R(X.rows(), static_cast<Eigen::Index>(kept.size())), raw_R(X.rows(), R.cols());
  for (std::size_t k = 0; k < kept.size(); ++k) {
    R.col(static_cast<Eigen::Index>(k)) = X.col(kept[k]);
    raw_R.col(static_cast<Eigen::Index>(k)) = raw.col(kept[k]);
  }
  Eigen::MatrixXd F(X.rows(), R.cols() + 1);
  F << R, own;  // shape kept, amplitude free
  int count = 0;
  const std::vector<int> block =
      options.random_folds ? random_folds(problem, count) : blocks_of(problem, count);
  const int n = problem.samples();
  std::vector<Eigen::MatrixXd> H(static_cast<std::size_t>(count), Eigen::MatrixXd::Zero(F.cols(), F.cols()));
  std::vector<Eigen::VectorXd> g(static_cast<std::size_t>(count), Eigen::VectorXd::Zero(F.cols()));
  // per block sums; rows of a block are contiguous in each channel
  for (int c = 0; c < 6; ++c) {
    for (int i = 0; i < n;) {
      int j = i;
      while (j < n && block[static_cast<std::size_t>(j)] == block[static_cast<std::size_t>(i)]) ++j;
      const auto rows = F.middleRows(c * n + i, j - i);
      const auto b = static_cast<std::size_t>(block[static_cast<std::size_t>(i)]);
      H[b] += rows.transpose() * rows;
      g[b] += rows.transpose() * without.segment(c * n + i, j - i);
      i = j;
    }
  }
  Eigen::MatrixXd H_all = Eigen::MatrixXd::Zero(F.cols(), F.cols());
  Eigen::VectorXd g_all = Eigen::VectorXd::Zero(F.cols());
  for (int b = 0; b < count; ++b) {
    H_all += H[static_cast<std::size_t>(b)];
    g_all += g[static_cast<std::size_t>(b)];
  }
  // changes of the offsets stay inside their tolerances, all other coefficients are free
  const Eigen::Index offset_count = problem.offset_sigma().size();
  Eigen::VectorXd low = Eigen::VectorXd::Constant(F.cols(), -1e12), high = -low;
  const Eigen::Index from = R.cols() - offset_count;
  // the tolerances say how much an offset may do for free, with and without the effect
  Eigen::VectorXd tolerances = Eigen::VectorXd::Zero(F.cols()), found = tolerances;
  tolerances.segment(from, offset_count) = problem.offset_sigma().cwiseAbs2().cwiseInverse();
  found.segment(from, offset_count) = full.offsets;
  // where feedback colours the state, a law with a bend of its own must beat whatever their limits allow
  const Eigen::VectorXd prior =
      problem.instrumented() || width == 1 ? tolerances : Eigen::VectorXd::Zero(F.cols());
  low.segment(from, offset_count) = (-3 * problem.offset_sigma() - full.offsets).cwiseMin(0.0);
  high.segment(from, offset_count) = (3 * problem.offset_sigma() - full.offsets).cwiseMax(0.0);
  const auto solve = [&](const Eigen::MatrixXd& h, const Eigen::VectorXd& r, Eigen::Index size,
                         const Eigen::VectorXd& weight) {
    Eigen::MatrixXd with_prior = h.topLeftCorner(size, size);
    with_prior.diagonal() += weight.head(size);
    return bounded_step(with_prior, (r - weight.cwiseProduct(found)).head(size), low.head(size),
                        high.head(size));
  };
  const auto cost_of_offsets = [&](const Eigen::VectorXd& x) {
    return prior.head(x.size()).dot((0.5 * x + found.head(x.size())).cwiseProduct(x));
  };
  // An effect that acts in bursts leaves most blocks to the offsets. Free ones that the other blocks hardly
  // tell apart are carried into the one left out at their limits, and that error is then all it shows. Of
  // fewer than five bursts none can vouch for the others: a take-off or two.
  std::vector<double> gains, information;
  for (const Eigen::MatrixXd& h : H) information.push_back(h(F.cols() - 1, F.cols() - 1));
  const double worth = worth_of(information);
  const bool bursts = worth > 5 && worth < 0.5 * count;
  const Eigen::VectorXd& held = bursts ? tolerances : prior;
  for (int b = 0; b < count; ++b) {
    const auto k = static_cast<std::size_t>(b);
    const Eigen::VectorXd x1 = solve(H_all - H[k], g_all - g[k], F.cols(), held);
    const Eigen::VectorXd x0 = solve(H_all - H[k], g_all - g[k], R.cols(), held);
    const double loss1 = 0.5 * x1.dot(H[k] * x1) - x1.dot(g[k]);
    const auto H0 = H[k].topLeftCorner(R.cols(), R.cols());
    const double loss0 = 0.5 * x0.dot(H0 * x0) - x0.dot(g[k].head(R.cols()));
    gains.push_back(loss0 - loss1);
  }
  Gate gate;
  gate.cross_validated_se = standard_errors_above_zero(gains, information);
  const Eigen::VectorXd x0 = solve(H_all, g_all, R.cols(), prior), x1 = solve(H_all, g_all, F.cols(), prior);
  const Eigen::VectorXd all0 = without - R * x0, all1 = without - F * x1;
  const Eigen::VectorXd raw0 = full.residual + value - raw_R * x0;
  {  // the same question asked with a whitening fitted to what the full model leaves
    const Whitening own_noise = Whitening::autoregressive(problem, full.residual, options.ar_order);
    Eigen::MatrixXd raw_F(raw.rows(), F.cols());
    raw_F << raw_R, value;
    const Eigen::MatrixXd Fw = own_noise.apply(problem, raw_F);
    const Eigen::VectorXd yw = own_noise.apply_vector(problem, full.residual + value);
    const Eigen::MatrixXd Hw = Fw.transpose() * Fw;
    const Eigen::VectorXd gw = Fw.transpose() * yw;
    const Eigen::VectorXd z0 = solve(Hw, gw, R.cols(), prior), z1 = solve(Hw, gw, F.cols(), prior);
    const auto H0 = Hw.topLeftCorner(R.cols(), R.cols());
    gate.gain = gw.dot(z1) - 0.5 * z1.dot(Hw * z1) - cost_of_offsets(z1) -
                (gw.head(R.cols()).dot(z0) - 0.5 * z0.dot(H0 * z0) - cost_of_offsets(z0));
  }
  gate.energy_share = std::max(most_removed(problem, all0, all1), most_removed(problem, raw0, full.residual));
  // tolerances may stand in for a steady effect, the better the longer a flight is; here they do not
  gate.prominence = most_removed(problem, full.residual + value, full.residual);
  for (int c = 0; c < 6; ++c) {
    gate.magnitude =
        std::max(gate.magnitude, std::sqrt(value.segment(c * n, n).squaredNorm() / n) / problem.scale(c));
    const double gone = raw0.segment(c * n, n).squaredNorm() - full.residual.segment(c * n, n).squaredNorm();
    gate.removed = std::max(gate.removed, std::sqrt(std::max(0.0, gone) / n) / problem.scale(c));
  }
  return gate;
}

}  // namespace omniflight::diagnosis
