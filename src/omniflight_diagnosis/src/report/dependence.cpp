#include "dependence.hpp"

#include "../numerics/statistics.hpp"
#include "../numerics/text.hpp"

namespace omniflight::diagnosis {

std::string dependence_of(const Eigen::VectorXd& y, const std::vector<StateVariable>& v, const char* unit,
                          double noise) {
  constexpr double kLeast = 0.25;     ///< least share of the variance that is explained; chosen
  constexpr double kClearly = 0.002;  ///< gain in that share required of a kink; chosen
  std::string text;
  if (std::abs(y.mean()) > 2 * noise) text = format("present throughout, mean %+.3g %s", y.mean(), unit);
  double best = kLeast;
  std::string dependence;
  for (const StateVariable& x : v) {
    if (spread(x.x) < 1e-3) continue;
    Eigen::VectorXd b;
    const double linear = explained_share(x.x, y, &b);
    if (linear > best) {
      best = linear;
      dependence = format("%s with %s: %+.3g %s per %s", b[0] * y.mean() >= 0 ? "grows" : "changes",
                          x.name.c_str(), b[0], unit, x.unit.c_str());
    }
    if (!x.hinge) continue;
    for (int k = 1; k < 30; ++k) {
      const double from = x.x.minCoeff() + k / 30.0 * spread(x.x);
      const Eigen::VectorXd above = (x.x.array() - from).max(0.0).matrix();
      const double share = explained_share(above, y, &b);
      if (share <= best + kClearly) continue;
      best = share;
      dependence = format("%s with %s above %.2f m: %+.3g %s per m",
                          b[0] * y.mean() >= 0 ? "grows" : "changes", x.name.c_str(), from, b[0], unit);
    }
  }
  if (text.empty()) return dependence;
  return dependence.empty() ? text : text + "; " + dependence;
}

}  // namespace omniflight::diagnosis
