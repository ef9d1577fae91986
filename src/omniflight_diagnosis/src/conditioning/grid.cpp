#include "grid.hpp"

#include <algorithm>
#include <utility>

#include "attitude_rows.hpp"
#include "omniflight_diagnosis/filter.hpp"
#include "outliers.hpp"

namespace omniflight::diagnosis {
namespace {

/// Runs [begin, end) of set flags.
std::vector<std::pair<int, int>> runs_of(const std::vector<char>& flags) {
  std::vector<std::pair<int, int>> out;
  const int n = static_cast<int>(flags.size());
  for (int i = 0; i < n; ++i) {
    if (!flags[static_cast<std::size_t>(i)]) continue;
    const int begin = i;
    while (i < n && flags[static_cast<std::size_t>(i)]) ++i;
    out.emplace_back(begin, i);
  }
  return out;
}

}  // namespace

double kernel_variance(const recording::Signal& signal, const Grid& grid, int derivatives) {
  const double period = signal.median_period_s(), step = 1 / grid.rate_hz;
  return period * period / 6 + derivatives * step * step / 3;
}

Channel on_grid(const recording::Signal& signal, const Grid& grid, const Options& o, double more) {
  Channel c;
  const double gap = std::max(o.max_gap_s, 3.0 * signal.median_period_s());
  c.x = recording::resample(without_outliers(signal), grid.t, gap);
  c.valid.assign(grid.t.size(), 1);
  const Eigen::Index n = c.x.rows();
  Eigen::Index first = 0;
  while (first < n && !c.x.row(first).allFinite()) ++first;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (c.x.row(i).allFinite()) continue;
    c.valid[static_cast<std::size_t>(i)] = 0;
    if (first == n)
      c.x.row(i).setZero();
    else
      c.x.row(i) = c.x.row(i < first ? first : i - 1);
  }
  if (recording::is_attitude(signal.name)) make_continuous(c.x);
  c.x = blur(block_mean(c.x, grid.step), std::max(0.0, more) * grid.rate_hz * grid.rate_hz);
  return c;
}

std::vector<char> in_windows(const std::vector<Window>& windows, const Grid& grid) {
  std::vector<char> out(grid.t.size(), 0);
  const double half = 0.51 / grid.rate_hz;  // even the shortest window then covers a sample
  for (const Window& w : windows)
    for (std::size_t i = 0; i < out.size(); ++i)
      if (grid.t[i] >= w.from_s - half && grid.t[i] <= w.to_s + half) out[i] = 1;
  return out;
}

std::vector<char> negated(const std::vector<char>& flags) {
  std::vector<char> out(flags.size());
  for (std::size_t i = 0; i < flags.size(); ++i) out[i] = !flags[i];
  return out;
}

void UsedSamples::exclude(const std::vector<char>& bad, double margin_s, const std::string& why) {
  list(bad, why);
  const int n = static_cast<int>(bad.size()), margin = static_cast<int>(margin_s * grid_.rate_hz);
  for (const auto& [begin, end] : runs_of(bad))
    for (int k = std::max(0, begin - margin); k < std::min(n, end + margin); ++k)
      use_[static_cast<std::size_t>(k)] = 0;
}

void UsedSamples::list(const std::vector<char>& bad, const std::string& why) {
  for (const auto& [begin, end] : runs_of(bad))
    windows_.push_back(
        {grid_.t[static_cast<std::size_t>(begin)], grid_.t[static_cast<std::size_t>(end - 1)], why});
}

void UsedSamples::exclude_ends(double margin_s) {
  const auto margin = std::min(static_cast<std::size_t>(margin_s * grid_.rate_hz), use_.size());
  std::fill_n(use_.begin(), margin, 0);
  std::fill_n(use_.rbegin(), margin, 0);
}

}  // namespace omniflight::diagnosis
