#include "omniflight_campaign/importance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "omniflight_core/random.hpp"

namespace omniflight::campaign {
namespace {

constexpr std::size_t kLeast = 20;       // flights
constexpr int kResamples = 500;          // of the bootstrap
constexpr std::size_t kMostBins = 16;    // a smooth relation needs no more
constexpr double kFlightsPerBin = 10.0;  // at least

/// Var(E[Y | bin]) / Var(Y) less its expectation under chance: 1 - (within / (n - m)) / (total / (n - 1)).
double epsilon_squared(std::span<const int> bin, std::span<const double> y, std::span<const std::size_t> rows,
                       std::size_t bins) {
  std::vector<double> sum(bins, 0.0), count(bins, 0.0);
  double all = 0, squares = 0;
  for (const std::size_t i : rows) {
    sum[static_cast<std::size_t>(bin[i])] += y[i];
    ++count[static_cast<std::size_t>(bin[i])];
    all += y[i];
    squares += y[i] * y[i];
  }
  const double n = static_cast<double>(rows.size());
  const double total = squares - all * all / n;
  double between = -all * all / n, used = 0;
  for (std::size_t b = 0; b < bins; ++b)
    if (count[b] > 0) between += sum[b] * sum[b] / count[b], ++used;
  if (!(total > 0) || n - used < 1) return 0;
  return 1 - ((total - between) / (n - used)) / (total / (n - 1));
}

std::vector<int> bins_of(std::span<const double> x, std::size_t bins) {
  const std::vector<double> rank = ranks(x);
  std::vector<int> out;
  for (const double r : rank)
    out.push_back(
        std::min(static_cast<int>(bins) - 1,
                 static_cast<int>((r - 0.5) / static_cast<double>(x.size()) * static_cast<double>(bins))));
  return out;
}

Eigen::VectorXd standardised(std::span<const double> x) {
  const std::vector<double> r = ranks(x);
  Eigen::VectorXd v = Eigen::Map<const Eigen::VectorXd>(r.data(), static_cast<Eigen::Index>(r.size()));
  v.array() -= v.mean();
  const double norm = v.norm();
  if (norm > 0) v /= norm;
  return v;
}

void rank_regression(std::span<const std::vector<double>> parameters, std::span<const double> y,
                     ImportanceResult& out) {
  const auto n = static_cast<Eigen::Index>(y.size()), p = static_cast<Eigen::Index>(parameters.size());
  Eigen::MatrixXd X(n, p);
  for (Eigen::Index k = 0; k < p; ++k) X.col(k) = standardised(parameters[static_cast<std::size_t>(k)]);
  const Eigen::VectorXd Y = standardised(y);
  const Eigen::VectorXd b = (X.transpose() * X).ldlt().solve(X.transpose() * Y);
  for (Eigen::Index k = 0; k < p; ++k) out.of[static_cast<std::size_t>(k)].rank_coefficient = b[k];
  out.explained_by_ranks = 1 - (Y - X * b).squaredNorm();
}

}  // namespace

ImportanceResult importance(std::span<const std::vector<double>> parameters, std::span<const double> result,
                            std::uint64_t seed) {
  ImportanceResult out;
  const std::size_t n = result.size();
  if (n < kLeast || parameters.empty()) return out;
  if (std::all_of(result.begin(), result.end(), [&](double v) { return v == result[0]; })) return out;
  const std::vector<double> y = ranks(result);
  const std::size_t bins = std::clamp<std::size_t>(
      static_cast<std::size_t>(static_cast<double>(n) / kFlightsPerBin), 2, kMostBins);
  std::vector<std::size_t> rows(n);
  std::iota(rows.begin(), rows.end(), 0);
  std::vector<std::vector<int>> bin;
  for (const auto& x : parameters) {
    bin.push_back(bins_of(x, bins));
    out.of.push_back({{epsilon_squared(bin.back(), y, rows, bins), 0, 0}, 0});
  }
  rank_regression(parameters, result, out);
  std::vector<std::vector<double>> again(parameters.size());
  Random random(seed, "bootstrap");
  for (int k = 0; k < kResamples; ++k) {
    for (std::size_t& row : rows) row = static_cast<std::size_t>(random.next() % n);
    for (std::size_t i = 0; i < parameters.size(); ++i)
      again[i].push_back(epsilon_squared(bin[i], y, rows, bins));
  }
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    std::sort(again[i].begin(), again[i].end());
    // a resample repeats rows, which bins explain: the shift is taken out (basic correction of the bias)
    const double shift =
        std::accumulate(again[i].begin(), again[i].end(), 0.0) / kResamples - out.of[i].first_order.value;
    out.of[i].first_order.low = again[i][static_cast<std::size_t>(0.025 * kResamples)] - shift;
    out.of[i].first_order.high = again[i][static_cast<std::size_t>(0.975 * kResamples) - 1] - shift;
  }
  return out;
}

}  // namespace omniflight::campaign
