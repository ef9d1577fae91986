#include "state_variables.hpp"

#include <algorithm>
#include <cmath>

#include "statistics.hpp"

namespace omniflight::diagnosis {

/// Quantities of the vehicle's own state on which a mismatch may depend.
std::vector<StateVariable> state_variables(const Problem& problem) {
  const int n = problem.samples();
  std::vector<StateVariable> v{
      {"height", "m", {}, true},   {"forward speed", "m/s", {}},    {"sideward speed", "m/s", {}},
      {"climb speed", "m/s", {}},  {"tilt of the body", "rad", {}}, {"rotor tilt", "rad", {}},
      {"position x", "m", {}},     {"position y", "m", {}},         {"roll rate", "rad/s", {}},
      {"pitch rate", "rad/s", {}}, {"yaw rate", "rad/s", {}}};
  for (StateVariable& x : v) x.x.resize(n);
  for (int i = 0; i < n; ++i) {
    const physics::Situation& s = problem.situation(i);
    const Vec3 &p = s.body.p_WB, &w = s.body.w_WB_B;
    const double values[] = {p.z(),
                             s.v_WB_B.x(),
                             s.v_WB_B.y(),
                             s.body.v_WB_W.z(),
                             std::acos(std::clamp(s.R_WB(2, 2), -1.0, 1.0)),
                             s.alpha,
                             p.x(),
                             p.y(),
                             w.x(),
                             w.y(),
                             w.z()};
    for (std::size_t k = 0; k < v.size(); ++k) v[k].x[i] = values[k];
  }
  return v;
}

double spread(const Eigen::VectorXd& x) { return x.size() > 0 ? x.maxCoeff() - x.minCoeff() : 0.0; }

/// Every channel without what state variables and a constant explain (ordinary least squares, a channel
/// each).
Eigen::VectorXd without_variables(const Problem& problem, const Eigen::VectorXd& residual,
                                  const std::vector<StateVariable>& v, int& dof) {
  const int n = problem.samples();
  Eigen::MatrixXd X(n, 0);
  for (const StateVariable& x : v) {
    if (spread(x.x) < 1e-6) continue;
    X.conservativeResize(Eigen::NoChange, X.cols() + 1);
    X.rightCols(1) = x.x;
  }
  dof = static_cast<int>(X.cols()) + 1;
  Eigen::VectorXd out = residual, b;
  for (int c = 0; c < 6; ++c) {
    const Eigen::VectorXd y = residual.segment(c * n, n);
    explained_share(X, y, &b);
    out.segment(c * n, n) = y - X * b.head(X.cols()) - Eigen::VectorXd::Constant(n, b[X.cols()]);
  }
  return out;
}

/// How close the vehicle comes to the axis below a neighbour: a bell of the horizontal distance for each of
/// three widths, from this vehicle's own size up; those that it flies into.
std::vector<Eigen::VectorXd> below_neighbours(const Problem& problem) {
  const double size = std::sqrt(problem.vehicle_scale().disc / kPi);
  std::vector<Eigen::VectorXd> out;
  for (const double widths : {1.0, 2.0, 4.0}) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(problem.samples());
    for (int i = 0; i < problem.samples(); ++i)
      for (const physics::Neighbour& other : problem.situation(i).all_neighbours()) {
        const Vec3 to = problem.situation(i).body.p_WB - other.p_WN;
        if (to.z() < 0) x[i] += std::exp(-to.head<2>().squaredNorm() / (widths * widths * size * size));
      }
    if (spread(x) > 0.1) out.push_back(std::move(x));
  }
  return out;
}

Whitening noise_model(const Problem& problem, const Options& options) {
  const int n = problem.samples();
  std::vector<StateVariable> v = state_variables(problem);
  const Eigen::VectorXd height = v[0].x;
  if (spread(height) > 0.05)
    for (int k = 1; k <= 4; ++k)
      v.push_back(
          {"height", "m", (height.array() - height.minCoeff() - 0.2 * k * spread(height)).max(0.0).matrix()});
  const std::vector<Eigen::VectorXd> wash = below_neighbours(problem);
  Eigen::VectorXd left = problem.residual(), b;
  std::array<Eigen::MatrixXd, 6> columns;
  // first what rotors do to the channel: their wrench stands for every scale and mass error; then neighbours,
  // whose wash would else be noise in which no short pass below them counts for much
  for (int c = 0; c < 6; ++c) {
    Eigen::MatrixXd X(n, 0);
    const auto add = [&](const Eigen::VectorXd& x) {
      if (spread(x) < 1e-9 || 60 * (X.cols() + 1) > n) return;
      X.conservativeResize(Eigen::NoChange, X.cols() + 1);
      X.rightCols(1) = x / x.norm();
    };
    add(problem.offsets().col(0).segment(c * n, n));
    if (c >= 3) {  // rotors that speed up push back on the body
      Eigen::VectorXd push(n);
      for (int i = 0; i < n; ++i) {
        push[i] = 0;
        for (const physics::RotorSituation& r : problem.situation(i).all_rotors())
          push[i] += r.spin * r.acceleration * r.n_B[c - 3];
      }
      add(push);
    }
    for (const Eigen::VectorXd& x : wash) add(x);
    for (const StateVariable& x : v) add(x.x);
    const Eigen::VectorXd y = left.segment(c * n, n);
    explained_share(X, y, &b);
    left.segment(c * n, n) = y - X * b.head(X.cols()) - Eigen::VectorXd::Constant(n, b[X.cols()]);
    X.conservativeResize(Eigen::NoChange, X.cols() + 1);
    X.rightCols(1).setOnes();
    columns[static_cast<std::size_t>(c)] = std::move(X);
  }
  // columns that feedback has coloured take more than chance would; their share cannot be computed
  return problem.instrumented() ? Whitening::autoregressive(problem, left, options.ar_order, columns)
                                : Whitening::autoregressive(problem, left, options.ar_order);
}

}  // namespace omniflight::diagnosis
