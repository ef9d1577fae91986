#include "halves.hpp"

namespace omniflight::diagnosis {

std::optional<Halves> halves_of(const recording::Signal& signal, double cutoff_hz, Repeats repeats) {
  std::vector<Eigen::Index> fresh;
  for (Eigen::Index i = 0; i < signal.size(); ++i)
    if (repeats == Repeats::kept || i == 0 || signal.values.row(i) != signal.values.row(i - 1))
      fresh.push_back(i);
  const auto n = static_cast<Eigen::Index>(fresh.size() / 2);
  if (n < 2) return std::nullopt;
  Halves out{signal, signal};
  int which = 0;
  for (recording::Signal* half : {&out.seen, &out.subtracted}) {
    half->t_s.clear();
    half->values.resize(n, signal.width());
    for (Eigen::Index k = 0; k < n; ++k) {
      const Eigen::Index from = fresh[static_cast<std::size_t>(2 * k + which)];
      half->t_s.push_back(signal.t_s[static_cast<std::size_t>(from)]);
      half->values.row(k) = signal.values.row(from);
    }
    ++which;
  }
  if (out.seen.median_period_s() * 2 * cutoff_hz > 1) return std::nullopt;
  return out;
}

}  // namespace omniflight::diagnosis
