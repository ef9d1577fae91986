#include "bounded_step.hpp"

#include <cmath>
#include <vector>

namespace omniflight::diagnosis {

Eigen::VectorXd bounded_step(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const Eigen::VectorXd& low,
                             const Eigen::VectorXd& high) {
  const Eigen::Index m = g.size();
  // every unknown in units of what one of it does; what does nothing stays
  Eigen::VectorXd unit(m), from(m), to(m);
  for (Eigen::Index k = 0; k < m; ++k) {
    unit[k] = H(k, k) > 0 ? 1 / std::sqrt(H(k, k)) : 0.0;
    from[k] = unit[k] > 0 ? low[k] / unit[k] : 0.0;
    to[k] = unit[k] > 0 ? high[k] / unit[k] : 0.0;
  }
  Eigen::MatrixXd A = unit.asDiagonal() * H * unit.asDiagonal();
  A.diagonal().array() += 1e-10;
  const Eigen::VectorXd r = unit.asDiagonal() * g;
  const double still = 1e-9 * (1 + r.cwiseAbs().maxCoeff());
  Eigen::VectorXd d = Eigen::VectorXd::Zero(m), down = r;  // down the slope
  std::vector<char> held(static_cast<std::size_t>(m), 0);
  // about m exchanges do; the limit ends what rounding would turn in a circle
  for (Eigen::Index exchange = 0; exchange < 10 * m + 10; ++exchange) {
    std::vector<Eigen::Index> open;
    for (Eigen::Index k = 0; k < m; ++k)
      if (!held[static_cast<std::size_t>(k)]) open.push_back(k);
    const Eigen::VectorXd way = A(open, open).ldlt().solve(down(open));
    double share = 1, bound = 0;
    Eigen::Index met = -1;
    for (std::size_t a = 0; a < open.size(); ++a) {
      const Eigen::Index k = open[a];
      const double by = way[static_cast<Eigen::Index>(a)], end = by > 0 ? to[k] : from[k];
      if (std::abs(end - d[k]) >= share * std::abs(by)) continue;
      share = std::abs((end - d[k]) / by);
      bound = end;
      met = k;
    }
    d(open) += share * way;
    if (met >= 0) {
      d[met] = bound;
      held[static_cast<std::size_t>(met)] = 1;
    }
    down = r - A * d;
    if (met >= 0) continue;
    Eigen::Index back = -1;  // to let go: what leads inside the steepest
    double steepest = still;
    for (Eigen::Index k = 0; k < m; ++k) {
      const double inside = d[k] >= to[k] ? -down[k] : down[k];
      if (held[static_cast<std::size_t>(k)] && from[k] < to[k] && inside > steepest)
        steepest = inside, back = k;
    }
    if (back < 0) break;
    held[static_cast<std::size_t>(back)] = 0;
  }
  return unit.cwiseProduct(d);
}

}  // namespace omniflight::diagnosis
