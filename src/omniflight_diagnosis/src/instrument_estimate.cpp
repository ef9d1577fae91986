#include "instrument_estimate.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;
using physics::Parameter;

constexpr double kWeakest = 0.5;   ///< correlation of an instrument with what it stands for
constexpr double kFurthest = 0.5;  ///< share by which a value may move

/// Columns of X or Z that belong to the unknowns: amplitudes of effects, then offsets.
Eigen::MatrixXd chosen(const Eigen::MatrixXd& all, const std::vector<Eigen::Index>& columns) {
  Eigen::MatrixXd out(all.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k)
    out.col(static_cast<Eigen::Index>(k)) = all.col(columns[k]);
  return out;
}

}  // namespace

std::optional<Fit> by_instruments(const Problem& instruments, const Problem& measured, const Fit& fit,
                                  const Eigen::VectorXd& near_zero, const Eigen::VectorXd& se) {
  if (fit.effects.empty() || measured.samples() != instruments.samples()) return std::nullopt;
  const Whitening& noise = instruments.noise();
  std::vector<Eigen::Index> columns;
  std::vector<double*> value;
  std::vector<Range> range;
  Fit out = fit;
  Eigen::Index column = 0;
  bool bent = false;
  const Eigen::MatrixXd first_Z = noise.apply(instruments, jacobian_of(instruments, fit)),
                        first_X = noise.apply(measured, jacobian_of(measured, fit));
  for (ActiveEffect& e : out.effects)
    for (std::size_t k = 0; k < e.theta.size(); ++k, ++column) {
      if (is_shape(e.effect->info().parameters[k])) {
        bent = true;
        continue;
      }
      const auto z = first_Z.col(column), x = first_X.col(column);
      if (!(z.dot(x) > kWeakest * z.norm() * x.norm())) continue;  // the flight does not move it
      columns.push_back(column);
      value.push_back(&e.theta[k]);
      range.push_back(instruments.range(*e.effect, k));
    }
  const Eigen::Index effects = column, amplitudes = static_cast<Eigen::Index>(columns.size());
  const Eigen::Index offsets = near_zero.size(), all = amplitudes + offsets;
  if (amplitudes == 0) return std::nullopt;
  const std::vector<Eigen::Index> solved = columns;
  for (Eigen::Index k = 0; k < offsets; ++k) columns.push_back(effects + k);
  const auto precision = [&](const Eigen::VectorXd& sigma) {
    Eigen::VectorXd p = Eigen::VectorXd::Zero(all);
    p.tail(offsets) = sigma.cwiseAbs2().cwiseInverse();
    return p;
  };
  const Eigen::VectorXd held = precision(near_zero), told = precision(instruments.offset_sigma());
  Eigen::MatrixXd Z, ZX;
  Eigen::VectorXd e;
  for (int iteration = 0; iteration < 4; ++iteration) {
    Z = noise.apply(instruments, chosen(jacobian_of(instruments, out), columns));
    const Eigen::MatrixXd X = noise.apply(measured, chosen(jacobian_of(measured, out), columns));
    Eigen::VectorXd rest;
    measured.predict(out.effects, out.offsets, rest, nullptr);
    e = noise.apply_vector(measured, rest);
    ZX = Z.transpose() * X;
    Eigen::MatrixXd H = ZX;
    H.diagonal() += held;
    Eigen::VectorXd g = Z.transpose() * e;
    g.tail(offsets) -= held.tail(offsets).cwiseProduct(out.offsets);
    const Eigen::VectorXd step = H.partialPivLu().solve(g);
    if (!step.allFinite()) return std::nullopt;
    for (Eigen::Index k = 0; k < amplitudes; ++k) {
      const auto at = static_cast<std::size_t>(k);
      *value[at] = std::clamp(*value[at] + step[k], range[at].lower, range[at].upper);
    }
    out.offsets += step.tail(offsets);
  }
  for (std::size_t k = 0; k < fit.effects.size(); ++k) {  // an effect as a whole must stay what it is
    double moved = 0, size = 0;
    for (std::size_t p = 0; p < fit.effects[k].theta.size(); ++p) {
      const Parameter& about = fit.effects[k].effect->info().parameters[p];
      const double usual = std::abs(about.typical - about.neutral), unit = usual > 0 ? usual : 1.0;
      moved = std::max(moved, std::abs(out.effects[k].theta[p] - fit.effects[k].theta[p]) / unit);
      if (!is_shape(about)) size = std::max(size, std::abs(fit.effects[k].theta[p] - about.neutral) / unit);
    }
    if (!(moved < kFurthest * size)) return std::nullopt;
  }
  // errors: as the noise model has them, and by the scatter of some thirty blocks
  Eigen::MatrixXd H = ZX;
  H.diagonal() += told;
  const Eigen::MatrixXd inverse = H.partialPivLu().inverse();
  Eigen::MatrixXd ZZ = Z.transpose() * Z;
  ZZ.diagonal() += told;
  const Eigen::MatrixXd model = inverse * ZZ * inverse.transpose();
  const int n = instruments.samples(), length = std::max(40, n / 30), blocks = (n + length - 1) / length;
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(all, blocks);
  for (int c = 0; c < 6; ++c)
    for (int i = 0; i < n; ++i) scores.col(i / length) += e[c * n + i] * Z.row(c * n + i).transpose();
  Eigen::MatrixXd meat = scores * scores.transpose();
  meat.diagonal() += told;
  const Eigen::MatrixXd robust = inverse * meat * inverse.transpose();
  out.se = se;
  if (!bent) {  // beside a bend the joint errors of the search stay: they know that it is uncertain
    for (Eigen::Index k = 0; k < amplitudes; ++k)
      out.se[solved[static_cast<std::size_t>(k)]] = std::sqrt(std::max({model(k, k), robust(k, k), 0.0}));
    if (!out.se.allFinite()) return std::nullopt;
    out.plausible.clear();
  }
  instruments.predict(out.effects, out.offsets, out.residual, nullptr);
  return out;
}

}  // namespace omniflight::diagnosis
