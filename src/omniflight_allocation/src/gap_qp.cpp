#include "omniflight_allocation/gap_qp.hpp"

#include <limits>

namespace omniflight::allocation {
namespace {

struct Node {
  QpVector lower, upper;
  ActiveSet start;
  long double bound;  // cost of the parent's relaxation; no point of this box is better
};

// Cost at u minus the cost at the relaxed minimum u0, from the difference: the two nearly cancel, and what
// tells the sides of a gap apart is many orders smaller. gradient0 = H u0 + g.
long double cost_above(const QpMatrix& H, const QpVector& u0, const QpVector& gradient0, const QpVector& u) {
  const auto n = u.size();
  long double sum = 0;
  for (Eigen::Index j = 0; j < n; ++j) {
    const long double d = static_cast<long double>(u[j]) - u0[j];
    long double row = 0.5L * d * H(j, j) + gradient0[j];
    for (Eigen::Index i = j + 1; i < n; ++i) row += (static_cast<long double>(u[i]) - u0[i]) * H(i, j);
    sum += d * row;
  }
  return sum;
}

// The variable deepest inside its gap, as a share of the gap; -1 when all stay out.
int deepest(const QpVector& u, const QpVector& gap) {
  int found = -1;
  double depth = 0.0;
  for (int i = 0; i < u.size(); ++i) {
    if (!(std::abs(u[i]) < gap[i])) continue;
    const double share = 1.0 - std::abs(u[i]) / gap[i];
    if (found < 0 || share > depth) found = i, depth = share;
  }
  return found;
}

// Ranges that reach to one side of their gap only need no branching.
bool trim(QpVector& lower, QpVector& upper, const QpVector& gap) {
  for (Eigen::Index i = 0; i < gap.size(); ++i) {
    if (!(gap[i] >= 0) || !std::isfinite(gap[i])) return false;
    if (lower[i] > -gap[i]) lower[i] = std::max(lower[i], gap[i]);
    if (upper[i] < gap[i]) upper[i] = std::min(upper[i], -gap[i]);
    if (lower[i] > upper[i]) return false;
  }
  return true;
}

// Depth first over the sides of the gaps that variables fall into; out holds the relaxed minimum, in whose
// gaps the variable `first` lies deepest.
void search(const QpMatrix& H, const QpVector& g, const QpVector& gap, const QpVector& lower,
            const QpVector& upper, int first, int max_nodes, GapQpSolution& out) {
  std::array<Node, kMaxInputs + 1> open;  // at most one sibling waits at each depth
  std::size_t waiting = 0;
  const auto branch = [&](const QpVector& low, const QpVector& high, const BoxQpSolution& at, int k,
                          long double cost) {
    // the side that is nearer is searched first: it is put down last
    const bool up_first = at.u[k] >= 0;
    for (const bool up : {!up_first, up_first}) {
      Node& child = open[waiting++];
      child = {low, high, at.active_set, cost};
      (up ? child.lower : child.upper)[k] = up ? gap[k] : -gap[k];
      child.start[static_cast<std::size_t>(k)] = up ? std::int8_t{-1} : std::int8_t{1};
    }
  };
  const QpVector u0 = out.best.u;
  const QpVector gradient0 = H.selfadjointView<Eigen::Lower>() * u0 + g;
  int iterations = out.best.iterations;
  branch(lower, upper, out.best, first, 0.0L);
  out.best = {};
  out.best.status = QpStatus::iteration_limit;
  long double lowest = std::numeric_limits<long double>::infinity();
  while (waiting > 0 && out.nodes < max_nodes) {
    const Node node = open[--waiting];
    if (node.bound >= lowest) continue;
    const BoxQpSolution qp = solve_box_qp(H, g, node.lower, node.upper, node.start);
    ++out.nodes;
    iterations += qp.iterations;
    if (qp.status != QpStatus::solved) {
      out.best = {};
      out.best.status = qp.status;
      return;
    }
    const long double cost = cost_above(H, u0, gradient0, qp.u);
    if (cost >= lowest) continue;
    if (const int k = deepest(qp.u, gap); k >= 0) {
      branch(node.lower, node.upper, qp, k, cost);
      continue;
    }
    lowest = cost;
    out.best = qp;
  }
  out.best.iterations = iterations;
  while (waiting > 0 && open[waiting - 1].bound >= lowest) --waiting;
  out.proven = waiting == 0;
}

}  // namespace

GapQpSolution solve_gap_qp(const QpMatrix& H, const QpVector& g, const QpVector& lower, const QpVector& upper,
                           const QpVector& gap, const ActiveSet& start, int max_nodes) {
  GapQpSolution out;
  BoxQpSolution& best = out.best;
  if (gap.size() != g.size() || lower.size() != g.size() || upper.size() != g.size()) return out;
  if (gap.hasNaN() || lower.hasNaN() || upper.hasNaN()) return best.status = QpStatus::not_finite, out;
  QpVector low = lower, high = upper;
  if (!trim(low, high, gap)) return best.status = QpStatus::bad_bounds, out;
  best = solve_box_qp(H, g, low, high, start);
  out.nodes = 1;
  out.relaxed_active_set = best.active_set;
  if (best.status != QpStatus::solved) return out;
  const int first = deepest(best.u, gap);
  if (first < 0) return out.proven = true, out;
  search(H, g, gap, low, high, first, max_nodes, out);
  return out;
}

}  // namespace omniflight::allocation
