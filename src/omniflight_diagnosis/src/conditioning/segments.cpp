#include "segments.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {

std::vector<Segment> long_runs(const std::vector<char>& good, double rate_hz) {
  std::vector<Segment> out;
  const int n = static_cast<int>(good.size());
  for (int i = 0; i < n;) {
    int j = i;
    while (j < n && good[static_cast<std::size_t>(j)]) ++j;
    if (j - i >= static_cast<int>(rate_hz)) out.push_back({i, j});
    i = std::max(j, i + 1);
  }
  return out;
}

int samples(const std::vector<Segment>& segments) {
  int n = 0;
  for (const Segment& s : segments) n += s.end - s.begin;
  return n;
}

std::vector<char> in_free_flight(const recording::Signal& phase, const std::vector<double>& t) {
  const Eigen::MatrixXd value = recording::resample(phase, t);
  std::vector<char> out(t.size());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = std::abs(value(static_cast<Eigen::Index>(i), 0) - 1.0) < 0.01;
  return out;
}

}  // namespace omniflight::diagnosis
