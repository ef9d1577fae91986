#include "baseline_methods.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace omniflight::proof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// All six channels under each other, each divided by its weight; after an optional filter of each channel.
struct Problem {
  MatrixXd X;
  VectorXd y;
};
using Filters = std::vector<VectorXd>;  // a channel: coefficients of an autoregressive model

MatrixXd filtered(const MatrixXd& x, const Filters& filters) {
  if (filters.empty()) return x;
  const Eigen::Index order = filters[0].size();
  MatrixXd out(x.rows() - order, x.cols());
  for (Eigen::Index c = 0; c < x.cols(); ++c)
    for (Eigen::Index i = order; i < x.rows(); ++i) {
      double e = x(i, c);
      for (Eigen::Index k = 0; k < order; ++k) e -= filters[static_cast<std::size_t>(c)][k] * x(i - 1 - k, c);
      out(i - order, c) = e;
    }
  return out;
}

VectorXd stacked(const MatrixXd& x, const VectorXd& weight) {
  VectorXd out(x.size());
  for (Eigen::Index c = 0; c < x.cols(); ++c) out.segment(c * x.rows(), x.rows()) = x.col(c) / weight[c];
  return out;
}

VectorXd spread(const MatrixXd& x) {
  VectorXd out(x.cols());
  for (Eigen::Index c = 0; c < x.cols(); ++c)
    out[c] = std::max(1e-9, std::sqrt(x.col(c).squaredNorm() / static_cast<double>(x.rows())));
  return out;
}

Problem assemble(const BaselineData& d, const std::vector<int>& columns, const Filters& filters,
                 const VectorXd& weight) {
  Problem p;
  p.y = stacked(filtered(d.residual, filters), weight);
  p.X.resize(p.y.size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k)
    p.X.col(static_cast<Eigen::Index>(k)) =
        stacked(filtered(d.columns[static_cast<std::size_t>(columns[k])], filters), weight);
  return p;
}

struct Fit {
  VectorXd value, error;
  double rss = 0;
};
Fit solve(const Problem& p) {
  Fit fit;
  if (p.X.cols() == 0) {
    fit.rss = p.y.squaredNorm();
    return fit;
  }
  const VectorXd scale = p.X.colwise().norm().cwiseMax(1e-12);
  const MatrixXd Z = p.X * scale.cwiseInverse().asDiagonal();
  MatrixXd G = Z.transpose() * Z;
  G.diagonal().array() += 1e-9;  // aliases share their value
  const Eigen::LDLT<MatrixXd> ldlt(G);
  const VectorXd z = ldlt.solve(Z.transpose() * p.y);
  fit.rss = (p.y - Z * z).squaredNorm();
  const double variance = fit.rss / std::max(1.0, static_cast<double>(p.y.size() - p.X.cols()));
  const MatrixXd covariance = ldlt.solve(MatrixXd::Identity(G.rows(), G.cols()));
  fit.value = z.cwiseQuotient(scale);
  fit.error = (variance * covariance.diagonal()).cwiseMax(0).cwiseSqrt().cwiseQuotient(scale);
  return fit;
}

std::vector<int> all_columns(const BaselineData& d) {
  std::vector<int> out(d.columns.size());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = static_cast<int>(k);
  return out;
}

NamedTerm named(const Term& t, const std::vector<int>& columns, const Fit& fit, double strength) {
  NamedTerm n{t.id, t.stage, strength, t.parameters, {}, {}};
  for (int k = 0; k < t.columns(); ++k) {
    const auto it = std::find(columns.begin(), columns.end(), t.first + k);
    const auto at = it - columns.begin();
    n.values.push_back(it == columns.end() ? 0.0 : fit.value[at]);
    n.errors.push_back(it == columns.end() ? 0.0 : fit.error[at]);
  }
  return n;
}

BaselineAnswer answer(std::vector<NamedTerm> terms) {
  std::stable_sort(terms.begin(), terms.end(),
                   [](const NamedTerm& a, const NamedTerm& b) { return a.strength > b.strength; });
  return {!terms.empty(), std::move(terms)};
}

/// Autoregressive model of each channel by least squares.
Filters autoregression(const MatrixXd& e, int order) {
  Filters out;
  for (Eigen::Index c = 0; c < e.cols(); ++c) {
    const Eigen::Index n = e.rows() - order;
    MatrixXd A(n, order);
    for (int k = 0; k < order; ++k) A.col(k) = e.col(c).segment(order - 1 - k, n);
    MatrixXd G = A.transpose() * A;
    G.diagonal().array() += 1e-9 * (1e-12 + G.diagonal().maxCoeff());
    out.push_back(G.ldlt().solve(A.transpose() * e.col(c).tail(n)));
  }
  return out;
}

MatrixXd remainder(const BaselineData& d, const std::vector<int>& columns, const VectorXd& value) {
  MatrixXd e = d.residual;
  for (std::size_t k = 0; k < columns.size(); ++k)
    e -= value[static_cast<Eigen::Index>(k)] * d.columns[static_cast<std::size_t>(columns[k])];
  return e;
}

}  // namespace

BaselineAnswer least_squares(const BaselineData& d) {
  const auto columns = all_columns(d);
  const Fit fit = solve(assemble(d, columns, {}, spread(d.residual)));
  const double bonferroni = 3.3;  // |t| at 5 % over about 40 columns, two-sided
  std::vector<NamedTerm> terms;
  for (const Term& t : d.terms) {
    double strongest = 0;
    for (int k = 0; k < t.columns(); ++k)
      strongest =
          std::max(strongest, std::abs(fit.value[t.first + k]) / std::max(1e-300, fit.error[t.first + k]));
    if (strongest > bonferroni) terms.push_back(named(t, columns, fit, strongest));
  }
  return answer(std::move(terms));
}

BaselineAnswer thresholded(const BaselineData& d, double threshold) {
  std::vector<int> columns = all_columns(d);
  const VectorXd weight = spread(d.residual);
  Fit fit;
  std::vector<double> size;
  for (int round = 0; round < 20 && !columns.empty(); ++round) {
    const Problem p = assemble(d, columns, {}, weight);
    fit = solve(p);
    const double scale = std::sqrt(p.y.squaredNorm());
    std::vector<int> kept;
    size.clear();
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const auto c = static_cast<Eigen::Index>(k);
      const double contribution = std::abs(fit.value[c]) * p.X.col(c).norm() / scale;
      if (contribution >= threshold) {
        kept.push_back(columns[k]);
        size.push_back(contribution);
      }
    }
    if (kept.size() == columns.size()) break;
    columns = kept;
  }
  std::vector<NamedTerm> terms;
  for (const Term& t : d.terms) {
    double strongest = 0;
    for (std::size_t k = 0; k < columns.size(); ++k)
      if (columns[k] >= t.first && columns[k] < t.first + t.columns() && k < size.size())
        strongest = std::max(strongest, size[k]);
    if (strongest > 0) terms.push_back(named(t, columns, fit, strongest));
  }
  return answer(std::move(terms));
}

BaselineAnswer stepwise(const BaselineData& d, bool whiten) {
  std::vector<int> columns;
  std::vector<NamedTerm> terms;
  std::set<std::string> used;
  Filters filters;
  MatrixXd e = d.residual;
  std::vector<std::pair<const Term*, double>> chosen;
  Fit fit;
  for (int step = 0; step < 8; ++step) {
    if (whiten) filters = autoregression(e, 8);
    const VectorXd weight = spread(filtered(e, filters));
    const Problem all = assemble(d, all_columns(d), filters, weight);
    const auto rss_of = [&](const std::vector<int>& c) {
      Problem p;
      p.y = all.y;
      p.X.resize(all.y.size(), static_cast<Eigen::Index>(c.size()));
      for (std::size_t k = 0; k < c.size(); ++k) p.X.col(static_cast<Eigen::Index>(k)) = all.X.col(c[k]);
      return solve(p);
    };
    const double n = static_cast<double>(all.y.size()), now = rss_of(columns).rss;
    const Term* best = nullptr;
    double best_gain = 0;
    std::vector<int> best_columns;
    for (const Term& t : d.terms) {
      if (used.count(t.id)) continue;
      std::vector<int> trial = columns;
      for (int k = 0; k < t.columns(); ++k) trial.push_back(t.first + k);
      const double gain =
          n * std::log(now / std::max(1e-300, rss_of(trial).rss)) - t.columns() * std::log(n);  // of the BIC
      if (gain > best_gain) {
        best_gain = gain;
        best = &t;
        best_columns = trial;
      }
    }
    if (!best) break;
    columns = best_columns;
    used.insert(best->id);
    chosen.emplace_back(best, best_gain);
    fit = rss_of(columns);
    e = remainder(d, columns, fit.value);
  }
  for (const auto& [t, gain] : chosen) terms.push_back(named(*t, columns, fit, gain));
  BaselineAnswer a;
  a.mismatch = !terms.empty();
  a.terms = std::move(terms);  // in the order of entry
  return a;
}

BaselineAnswer oracle(const BaselineData& d, const std::vector<std::string>& ids) {
  std::vector<int> columns;
  std::vector<const Term*> chosen;
  for (const Term& t : d.terms)
    if (std::find(ids.begin(), ids.end(), t.id) != ids.end()) {
      chosen.push_back(&t);
      for (int k = 0; k < t.columns(); ++k) columns.push_back(t.first + k);
    }
  Fit fit;
  MatrixXd e = d.residual;
  for (int round = 0; round < 4 && !columns.empty(); ++round) {
    const Filters filters = autoregression(e, 8);
    fit = solve(assemble(d, columns, filters, spread(filtered(e, filters))));
    e = remainder(d, columns, fit.value);
  }
  std::vector<NamedTerm> terms;
  for (const Term* t : chosen) terms.push_back(named(*t, columns, fit, 0));
  return answer(std::move(terms));
}

BaselineAnswer black_box(const BaselineData& d) {
  constexpr int knots = 6, blocks = 6;
  const int k = static_cast<int>(d.features.cols());
  MatrixXd X(d.n, k * knots + 1);
  X.col(X.cols() - 1).setOnes();
  for (int c = 0; c < k; ++c) {
    const double low = d.features.col(c).minCoeff(), high = d.features.col(c).maxCoeff();
    const double width = std::max(1e-9, (high - low) / (knots - 1));
    for (int j = 0; j < knots; ++j)
      X.col(c * knots + j) = (1 - ((d.features.col(c).array() - low) / width - j).abs()).max(0.0);
  }
  BaselineAnswer a;
  for (int channel = 0; channel < 6; ++channel) {
    double before = 0, after = 0;
    for (int b = 0; b < blocks; ++b) {
      const int from = d.n * b / blocks, to = d.n * (b + 1) / blocks;
      MatrixXd G = MatrixXd::Zero(X.cols(), X.cols());
      VectorXd g = VectorXd::Zero(X.cols());
      double mean = 0;
      for (int i = 0; i < d.n; ++i)
        if (i < from || i >= to) {
          G.selfadjointView<Eigen::Lower>().rankUpdate(X.row(i).transpose());
          g += X.row(i).transpose() * d.residual(i, channel);
          mean += d.residual(i, channel);
        }
      mean = 0;  // the nominal model says zero
      MatrixXd full = G.selfadjointView<Eigen::Lower>();
      full.diagonal().array() += 1e-2 * d.n / knots;
      const VectorXd beta = full.ldlt().solve(g);
      for (int i = from; i < to; ++i) {
        before += std::pow(d.residual(i, channel) - mean, 2);
        after += std::pow(d.residual(i, channel) - X.row(i).dot(beta), 2);
      }
    }
    a.mismatch = a.mismatch || after < 0.98 * before;
  }
  return a;
}

}  // namespace omniflight::proof
