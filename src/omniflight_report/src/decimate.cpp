#include "omniflight_report/decimate.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace omniflight::report {
namespace {

// The indices of the smallest and the largest finite value in [from, to), appended when there are any.
void append_extremes(std::span<const double> channel, std::size_t from, std::size_t to,
                     std::vector<std::size_t>& out) {
  std::size_t lowest = to, highest = to;
  for (std::size_t i = from; i < to; ++i) {
    if (!std::isfinite(channel[i])) continue;
    if (lowest == to || channel[i] < channel[lowest]) lowest = i;
    if (highest == to || channel[i] > channel[highest]) highest = i;
  }
  if (lowest != to) out.insert(out.end(), {lowest, highest});
}

void append_gap(std::span<const double> channel, std::size_t from, std::size_t to,
                std::vector<std::size_t>& out) {
  std::size_t first = to, last = to;
  for (std::size_t i = from; i < to; ++i) {
    if (std::isfinite(channel[i])) continue;
    if (first == to) first = i;
    last = i;
  }
  if (first != to) out.insert(out.end(), {first, last});
}

}  // namespace

std::vector<std::size_t> kept_samples(std::span<const std::span<const double>> channels,
                                      std::size_t max_samples) {
  const std::size_t n = channels.front().size();
  std::vector<std::size_t> kept;
  if (n <= max_samples) {
    kept.resize(n);
    std::iota(kept.begin(), kept.end(), std::size_t{0});
    return kept;
  }
  const bool gaps = std::any_of(channels.front().begin(), channels.front().end(),
                                [](double v) { return !std::isfinite(v); });
  const std::size_t per_bucket = 2 + 2 * channels.size() + (gaps ? 2 : 0);
  const std::size_t buckets = std::max<std::size_t>(1, max_samples / per_bucket);
  std::vector<std::size_t> bucket;
  for (std::size_t b = 0; b < buckets; ++b) {
    const std::size_t from = b * n / buckets, to = (b + 1) * n / buckets;
    if (from == to) continue;
    bucket.assign({from, to - 1});
    for (const auto& channel : channels) append_extremes(channel, from, to, bucket);
    if (gaps) append_gap(channels.front(), from, to, bucket);
    std::sort(bucket.begin(), bucket.end());
    bucket.erase(std::unique(bucket.begin(), bucket.end()), bucket.end());
    kept.insert(kept.end(), bucket.begin(), bucket.end());
  }
  return kept;
}

}  // namespace omniflight::report
