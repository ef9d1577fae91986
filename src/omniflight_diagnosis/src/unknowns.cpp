#include "unknowns.hpp"

#include <cmath>

namespace omniflight::diagnosis {

Eigen::VectorXd bounded_step(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const Unknowns& u) {
  const Eigen::Index m = g.size();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(m);
  std::vector<char> fixed(static_cast<std::size_t>(m), 0);
  for (Eigen::Index round = 0; round <= m; ++round) {
    std::vector<Eigen::Index> open;
    for (Eigen::Index k = 0; k < m; ++k)
      if (!fixed[static_cast<std::size_t>(k)]) open.push_back(k);
    const auto size = static_cast<Eigen::Index>(open.size());
    if (size == 0) break;
    Eigen::MatrixXd h(size, size);
    Eigen::VectorXd r(size), scale(size);
    for (Eigen::Index a = 0; a < size; ++a) {
      r[a] = g[open[static_cast<std::size_t>(a)]];
      for (Eigen::Index k = 0; k < m; ++k)
        if (fixed[static_cast<std::size_t>(k)]) r[a] -= H(open[static_cast<std::size_t>(a)], k) * step[k];
      for (Eigen::Index b = 0; b < size; ++b)
        h(a, b) = H(open[static_cast<std::size_t>(a)], open[static_cast<std::size_t>(b)]);
      scale[a] = h(a, a) > 0 ? 1.0 / std::sqrt(h(a, a)) : 0.0;
    }
    h = scale.asDiagonal() * h * scale.asDiagonal();
    h.diagonal().array() += 1e-10;
    const Eigen::VectorXd d = scale.asDiagonal() * h.ldlt().solve(scale.asDiagonal() * r);
    bool violated = false;
    for (Eigen::Index a = 0; a < size; ++a) {
      const Eigen::Index k = open[static_cast<std::size_t>(a)];
      step[k] = d[a];
      const double to = u.x[k] + d[a];
      if (to < u.lower[k] - 1e-12 || to > u.upper[k] + 1e-12) {
        step[k] = std::clamp(to, u.lower[k], u.upper[k]) - u.x[k];
        fixed[static_cast<std::size_t>(k)] = 1;
        violated = true;
      }
    }
    if (!violated) break;
  }
  return step;
}

}  // namespace omniflight::diagnosis
