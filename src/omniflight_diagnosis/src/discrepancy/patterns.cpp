#include "patterns.hpp"

#include <algorithm>
#include <cmath>

#include "../numerics/statistics.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr int kBasis = 5;  ///< radial basis functions over the range of a variable; chosen

struct Variable {
  const char* name;
  const char* unit;
  /// Least range (1 % to 99 % quantile) that is used, in `unit`; 0: 10 % of the weight. Chosen
  double least;
  double (*of)(const physics::Situation&);
};

constexpr Variable kVariables[] = {
    {"height", "m", 0.1, [](const physics::Situation& s) { return s.body.p_WB.z(); }},
    {"position x", "m", 0.1, [](const physics::Situation& s) { return s.body.p_WB.x(); }},
    {"position y", "m", 0.1, [](const physics::Situation& s) { return s.body.p_WB.y(); }},
    {"forward speed", "m/s", 0.1, [](const physics::Situation& s) { return s.v_WB_B.x(); }},
    {"sideward speed", "m/s", 0.1, [](const physics::Situation& s) { return s.v_WB_B.y(); }},
    {"climb speed", "m/s", 0.1, [](const physics::Situation& s) { return s.body.v_WB_W.z(); }},
    {"roll rate", "rad/s", 0.1, [](const physics::Situation& s) { return s.body.w_WB_B.x(); }},
    {"pitch rate", "rad/s", 0.1, [](const physics::Situation& s) { return s.body.w_WB_B.y(); }},
    {"yaw rate", "rad/s", 0.1, [](const physics::Situation& s) { return s.body.w_WB_B.z(); }},
    {"heading", "rad", 0.2,
     [](const physics::Situation& s) { return std::atan2(s.R_WB(1, 0), s.R_WB(0, 0)); }},
    {"rotor tilt", "rad", 0.02, [](const physics::Situation& s) { return s.alpha; }},
    {"rotor thrust", "N", 0, [](const physics::Situation& s) {
       double sum = 0;
       for (const auto& r : s.all_rotors()) sum += std::abs(r.thrust);
       return sum;
     }}};

}  // namespace

std::vector<Pattern> make_patterns(const RegressionProblem& problem) {
  const int n = problem.samples();
  std::vector<Pattern> out;
  if (n < 2) return out;
  for (const Variable& v : kVariables) {
    std::vector<double> x(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) x[static_cast<std::size_t>(i)] = v.of(problem.situation(i));
    const double low = quantile(x, 0.01), high = quantile(x, 0.99);
    const double least = v.least > 0 ? v.least : 0.1 * problem.scale(2);
    if (!(high - low > least)) continue;
    // Centres evenly over the range, standard deviation of one spacing. Means are removed: a constant force
    // is calibration.
    const double width = (high - low) / (kBasis - 1);
    Eigen::MatrixXd basis(n, kBasis);
    for (int b = 0; b < kBasis; ++b)
      for (int i = 0; i < n; ++i) {
        const double z = (std::clamp(x[static_cast<std::size_t>(i)], low, high) - low - b * width) / width;
        basis(i, b) = std::exp(-0.5 * z * z);
      }
    basis.rowwise() -= basis.colwise().mean();
    for (int axis = 0; axis < 9; ++axis) {
      const bool world = axis >= 6;
      const int channel = world ? axis - 6 : axis;
      if (problem.forces_only() && !world && channel >= 3) continue;
      Pattern p;
      p.channel = channel;
      p.world = world;
      p.variable = v.name;
      p.unit = v.unit;
      p.raw = Eigen::MatrixXd::Zero(problem.rows(), kBasis);
      const double size = kPatternShare * problem.scale(channel);
      for (int i = 0; i < n; ++i) {
        if (!world) {
          p.raw.row(channel * n + i) = size * basis.row(i);
          continue;
        }
        for (int c = 0; c < 3; ++c)
          p.raw.row(c * n + i) = size * problem.situation(i).R_WB(channel, c) * basis.row(i);
      }
      out.push_back(std::move(p));
    }
  }
  return out;
}

}  // namespace omniflight::diagnosis
