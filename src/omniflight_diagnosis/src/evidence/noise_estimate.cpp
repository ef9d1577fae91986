#include "noise_estimate.hpp"

#include <cmath>
#include <utility>

#include "../discrepancy/patterns.hpp"
#include "impulses.hpp"
#include "inner_products.hpp"
#include "told_noise.hpp"

namespace omniflight::diagnosis {
namespace {

/// Times at most that impulses are looked for: a spectrum that contains them hides them.
constexpr int kImpulseTurns = 4;
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
  Eigen::MatrixXd all(problem.rows(), total);
  Eigen::Index at = 0;
  for (const Eigen::MatrixXd& part : parts) {
    all.middleCols(at, part.cols()) = part;
    at += part.cols();
  }
  const Eigen::MatrixXd amplitudes = cosine_amplitudes(problem, all);
  SlowColumns out;
  out.told = told_spectra(problem);
  out.count = total;
  Eigen::Index row = 0;
  for (const Stretch& s : problem.stretches()) {
    const int size = transform_length(s.size());
    for (auto& channel : out.channels)
      for (int k = 0; k < size; ++k) channel.rows.push_back(row++);
  }
  for (auto& channel : out.channels) {
    const Eigen::MatrixXd own = amplitudes(channel.rows, Eigen::all);
    for (Eigen::Index k = 0; k < total; ++k)
      if (!own.col(k).isZero(0)) channel.columns.push_back(k);
    channel.amplitudes = own(Eigen::all, channel.columns);
    channel.power = channel.amplitudes.rowwise().squaredNorm();
  }
  return out;
}

namespace {

/// Amplitudes of one channel that slow columns may explain, and these columns there, whitened.
struct Explained {
  std::vector<Eigen::Index> rows;  ///< of these among the amplitudes of all channels
  Eigen::MatrixXd whitened;        ///< rows x columns of the channel
};

Explained explained(const SlowColumns::Channel& channel, const Eigen::VectorXd& inverse) {
  Explained out;
  std::vector<Eigen::Index> of_channel;
  for (std::size_t i = 0; i < channel.rows.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (!(std::pow(inverse[channel.rows[i]], 2) * channel.power[row] > kLeastShare)) continue;
    of_channel.push_back(row);
    out.rows.push_back(channel.rows[i]);
  }
  out.whitened = inverse(out.rows).asDiagonal() * channel.amplitudes(of_channel, Eigen::all);
  return out;
}

/// What a ridge regression on slow columns leaves.
struct SlowRegression {
  Eigen::VectorXd rest, freedom;  ///< cosine amplitudes, and how much of each is free
};

/// Of `y` (all rows), which these impulses were taken off.
SlowRegression regress(const RegressionProblem& problem, const SlowColumns& slow, const Eigen::VectorXd& y,
                       const Impulses& impulses, ToldShape shape) {
  const Eigen::VectorXd z = cosine_amplitudes(problem, y);
  SlowRegression out{z, {}};
  Eigen::VectorXd free = Eigen::VectorXd::Ones(z.size());
  const Eigen::RowVectorXd means = y.reshaped(problem.samples(), 6).colwise().mean();  // they are no noise
  Eigen::Index first = 0;
  for (const Stretch& s : problem.stretches()) {
    const int size = transform_length(s.size());
    for (int c = 0; c < 6; ++c, first += size) {
      out.rest[first] -= std::sqrt(size) * means[c];
      if (impulses.count == 0) continue;
      const auto here = impulses.sizes.segment(c * problem.samples() + s.begin, size).array();
      free.segment(first, size).setConstant(1 - static_cast<double>((here != 0).count()) / size);
    }
  }
  out.freedom = free;
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::VectorXd inverse =
        NoiseModel(problem, out.rest, out.freedom, 1, slow.told, shape).inverse_deviations();
    Eigen::MatrixXd H = Eigen::MatrixXd::Identity(slow.count, slow.count);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(slow.count);
    std::array<Explained, 6> parts;
    for (std::size_t c = 0; c < parts.size(); ++c) {
      const SlowColumns::Channel& channel = slow.channels[c];
      parts[c] = explained(channel, inverse);
      const std::vector<Eigen::Index>& rows = parts[c].rows;
      H(channel.columns, channel.columns) += inner_products(parts[c].whitened);
      g(channel.columns) += parts[c].whitened.transpose() * inverse(rows).cwiseProduct(z(rows));
    }
    const Eigen::LLT<Eigen::MatrixXd> factor(H);
    const Eigen::VectorXd coefficients = factor.solve(g);
    const Eigen::MatrixXd covariance = factor.solve(Eigen::MatrixXd::Identity(H.rows(), H.cols()));
    out.freedom = free;
    for (std::size_t c = 0; c < parts.size(); ++c) {
      const SlowColumns::Channel& channel = slow.channels[c];
      out.rest(channel.rows) = z(channel.rows) - channel.amplitudes * coefficients(channel.columns);
      const Eigen::MatrixXd own = covariance(channel.columns, channel.columns);
      out.freedom(parts[c].rows).array() -=
          (parts[c].whitened * own).cwiseProduct(parts[c].whitened).rowwise().sum().array();
    }
  }
  return out;
}

}  // namespace

std::unique_ptr<NoiseModel> estimate_noise(const RegressionProblem& problem, const SlowColumns& slow,
                                           const Eigen::VectorXd& known, double temperature, ToldShape shape,
                                           LoneSamples lone) {
  const Eigen::VectorXd y = problem.residual() - known;
  SlowRegression left = regress(problem, slow, y, {}, shape);
  const auto noise_beside = [&](Impulses impulses) {
    return std::make_unique<NoiseModel>(problem, left.rest, left.freedom, temperature, slow.told, shape,
                                        std::move(impulses));
  };
  auto noise = noise_beside({});
  const bool sought = lone == LoneSamples::sought && problem.heavy_tails();
  for (int turn = 0; turn < kImpulseTurns && sought; ++turn) {
    if (turn > 0) left.rest += cosine_amplitudes(problem, noise->impulses().wrench);
    Impulses found = find_impulses(problem, *noise, left.rest);
    if (found.count == 0 || found.count == noise->impulses().count) break;
    left = regress(problem, slow, y - found.wrench, found, shape);
    noise = noise_beside(std::move(found));
  }
  return noise;
}

}  // namespace omniflight::diagnosis
