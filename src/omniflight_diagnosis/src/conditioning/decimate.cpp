#include "decimate.hpp"

#include <algorithm>

namespace omniflight::diagnosis {

using recording::Signal;

Signal decimate(const Signal& s, double period_s) {
  const auto n = static_cast<Eigen::Index>(period_s / std::max(1e-6, s.median_period_s()));
  if (n < 2) return s;
  Signal out = s;
  const Eigen::Index m = s.size() / n;
  out.values.resize(m, s.width());
  out.t_s.resize(static_cast<std::size_t>(m));
  for (Eigen::Index i = 0; i < m; ++i) {
    out.values.row(i) = s.values.middleRows(i * n, n).colwise().mean();
    double t = 0;
    for (Eigen::Index k = 0; k < n; ++k) t += s.t_s[static_cast<std::size_t>(i * n + k)];
    out.t_s[static_cast<std::size_t>(i)] = t / static_cast<double>(n);
  }
  return out;
}

}  // namespace omniflight::diagnosis
