#include "omniflight_allocation/box_qp.hpp"

#include "box_qp_workspace.hpp"

namespace omniflight::allocation {
namespace {

/// KKT residual above which kept pivots are not trusted; what they give is below 1e-13.
constexpr double kTrusted = 1e-10;

}  // namespace

const char* to_string(QpStatus status) {
  switch (status) {
    case QpStatus::solved:
      return "solved";
    case QpStatus::not_finite:
      return "not finite";
    case QpStatus::bad_size:
      return "bad size";
    case QpStatus::bad_bounds:
      return "a lower bound above its upper bound";
    case QpStatus::not_convex:
      return "not positive definite";
    case QpStatus::iteration_limit:
      return "iteration limit";
  }
  return "unknown";
}

QpStatus BoxQpSolver::set_matrix(const QpMatrix& H) {
  workspace_.n = 0;
  const auto n = H.rows();
  if (n < 1 || n > kMaxInputs || H.cols() != n) return QpStatus::bad_size;
  return qp_kernel::set_matrix(H.data(), static_cast<int>(n), workspace_);
}

BoxQpSolution BoxQpSolver::solve(const QpVector& g, const QpVector& lower, const QpVector& upper,
                                 const ActiveSet& start) {
  BoxQpSolution out;
  const auto n = g.size();
  if (n < 1 || n != workspace_.n || lower.size() != n || upper.size() != n) return out;
  qp_kernel::solve({g.data(), lower.data(), upper.data(), start.data()}, workspace_, out);
  const bool ended = out.status == QpStatus::solved || out.status == QpStatus::iteration_limit;
  if (ended && !(out.kkt_residual < kTrusted)) {
    // Kept pivots of a nearly singular matrix, and a minimum that all but touches a bound: refinement has
    // stalled there. From nothing the same program is solved to rounding.
    workspace_.swept = false;
    workspace_.pivoted = 0;
    workspace_.exchanges = 0;
    const ActiveSet none{};
    const int before = out.iterations;
    qp_kernel::solve({g.data(), lower.data(), upper.data(), none.data()}, workspace_, out = {});
    out.iterations += before;
  }
  return out;
}

BoxQpSolution solve_box_qp(const QpMatrix& H, const QpVector& g, const QpVector& lower, const QpVector& upper,
                           const ActiveSet& start) {
  QpWorkspace w;
  BoxQpSolution out;
  const auto n = g.size();
  if (n < 1 || n > kMaxInputs || H.rows() != n || H.cols() != n || lower.size() != n || upper.size() != n)
    return out;
  out.status = qp_kernel::set_matrix(H.data(), static_cast<int>(n), w);
  if (out.status == QpStatus::solved)
    qp_kernel::solve({g.data(), lower.data(), upper.data(), start.data()}, w, out);
  return out;
}

}  // namespace omniflight::allocation
