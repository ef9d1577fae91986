#include "thrust_response.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured.
constexpr std::array kLeads{-1.0, 0.2, 0.4, 0.7, 1.0};  // 1
constexpr int kTimes = 13;                              // time constants, evenly in their logarithm
constexpr double kShortest = 0.004, kLongest = 0.1;     // s

double time_at(int k) { return kShortest * std::pow(kLongest / kShortest, k / (kTimes - 1.0)); }

double log_mean_exp(const std::vector<double>& x) {
  const double most = *std::max_element(x.begin(), x.end());
  double sum = 0;
  for (const double v : x) sum += std::exp(v - most);
  return most + std::log(sum / static_cast<double>(x.size()));
}

/// ln likelihood of each lead, summed over the axes, with what the wrench of each settles to; `explained` is
/// the largest share of an axis so far.
std::array<double, kLeads.size()> log_likelihood(const RotorRegression& regression,
                                                 const std::vector<Eigen::VectorXd>& settled, int shift,
                                                 double& explained) {
  std::array<double, kLeads.size()> out{};
  for (int c = 0; c < regression.axes(); ++c) {
    const std::vector<double> left = regression.left(c, settled[static_cast<std::size_t>(c)], shift, kLeads);
    for (std::size_t k = 0; k < left.size(); ++k) {
      explained = std::max(explained, 1 - left[k]);
      out[k] -= 0.5 * std::log(left[k]) * regression.independent_samples();
    }
  }
  return out;
}

/// The same of thrust that follows at once, for each shift within reach.
std::vector<double> log_likelihood_of_clocks(const RotorRegression& regression) {
  std::vector<double> out;
  for (int shift = -regression.reach(); shift <= regression.reach(); ++shift) {
    double sum = 0;
    for (int c = 0; c < regression.axes(); ++c)
      sum -= 0.5 * std::log(regression.left_at_once(c, shift)) * regression.independent_samples();
    out.push_back(sum);
  }
  return out;
}

}  // namespace

std::optional<ThrustResponse> thrust_response(const RotorRegression& regression, double clock_s) {
  if (!regression.enough() || regression.is_feedback(clock_s)) return std::nullopt;
  const std::vector<double> clocks = log_likelihood_of_clocks(regression);
  const double at_once = clocks[static_cast<std::size_t>(regression.reach())];
  const int tolerated = static_cast<int>(std::lround(clock_s * regression.rate_hz()));
  std::vector<double> all;
  double explained = 0;
  std::array<std::array<double, kTimes>, kLeads.size()> best;
  for (auto& some : best) some.fill(-1e300);
  for (int k = 0; k < kTimes; ++k) {
    std::vector<Eigen::VectorXd> settled;
    for (int c = 0; c < regression.axes(); ++c)
      settled.emplace_back(lagged(regression.wrench(c), time_at(k), regression.rate_hz()));
    for (int shift = -tolerated; shift <= tolerated; ++shift) {
      const auto here = log_likelihood(regression, settled, shift, explained);
      all.insert(all.end(), here.begin(), here.end());
      for (std::size_t l = 0; l < kLeads.size(); ++l)
        best[l][static_cast<std::size_t>(k)] = std::max(best[l][static_cast<std::size_t>(k)], here[l]);
    }
  }
  if (explained < kLeastByRotors) return std::nullopt;
  ThrustResponse out;
  out.log_factor = log_mean_exp(all) - std::max(log_mean_exp(clocks), at_once);
  if (!(out.log_factor > 0)) return std::nullopt;
  double most = -1e300;
  int at = 0;
  std::size_t lead = 0;
  for (std::size_t l = 0; l < kLeads.size(); ++l)
    for (int k = 1; k + 1 < kTimes; ++k)  // not at the edge of the search
      if (const double here = best[l][static_cast<std::size_t>(k)]; here > most)
        most = here, at = k, lead = l;
  const auto k = static_cast<std::size_t>(at);
  const auto& row = best[lead];
  const double bend = -(row[k - 1] - 2 * row[k] + row[k + 1]);
  if (!(bend > 0) || row[k - 1] > row[k] || row[k + 1] > row[k]) return std::nullopt;
  const double step = std::log(time_at(1) / time_at(0));
  out.lead = kLeads[lead];
  out.time = time_at(at) * std::exp(0.5 * (row[k + 1] - row[k - 1]) / bend * step);
  out.time_se = out.time * step / std::sqrt(bend);
  return out;
}

Eigen::MatrixXd responding(const Eigen::MatrixXd& speed, const ThrustResponse& response, double rate_hz) {
  const Eigen::MatrixXd now = speed.cwiseProduct(speed.cwiseAbs());
  const Eigen::MatrixXd then = now + response.lead * (now - lagged(now, response.time, rate_hz));
  return then.array().abs().sqrt() * then.array().sign();
}

}  // namespace omniflight::diagnosis
