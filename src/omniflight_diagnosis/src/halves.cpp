#include "halves.hpp"

namespace omniflight::diagnosis {

std::optional<Halves> halves_of(const recording::Signal& pose, double cutoff_hz) {
  std::vector<Eigen::Index> fresh;
  for (Eigen::Index i = 0; i < pose.size(); ++i)
    if (i == 0 || pose.values.row(i) != pose.values.row(i - 1)) fresh.push_back(i);
  const auto n = static_cast<Eigen::Index>(fresh.size() / 2);
  if (n < 2) return std::nullopt;
  Halves out{pose, pose};
  int which = 0;
  for (recording::Signal* half : {&out.seen, &out.differentiated}) {
    half->t_s.clear();
    half->values.resize(n, pose.width());
    for (Eigen::Index k = 0; k < n; ++k) {
      const Eigen::Index from = fresh[static_cast<std::size_t>(2 * k + which)];
      half->t_s.push_back(pose.t_s[static_cast<std::size_t>(from)]);
      half->values.row(k) = pose.values.row(from);
    }
    ++which;
  }
  if (out.seen.median_period_s() * 2 * cutoff_hz > 1) return std::nullopt;
  return out;
}

}  // namespace omniflight::diagnosis
