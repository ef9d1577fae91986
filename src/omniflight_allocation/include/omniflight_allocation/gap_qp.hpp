// Exact solution of a small box-constrained quadratic program whose variables must also stay away from zero:
// rotors that turn both ways and cannot hold a small thrust.
#pragma once

#include "omniflight_allocation/box_qp.hpp"

namespace omniflight::allocation {

struct GapQpSolution {
  /// The minimum. kkt_residual and active_set belong to the box that it was found in, so a variable at the
  /// edge of its gap counts as one at a bound; iterations are those of all boxes together.
  BoxQpSolution best;
  ActiveSet relaxed_active_set{};  ///< of the problem without gaps: hand it to the next, similar problem
  int nodes = 0;                   ///< box problems solved
  /// No better point exists. False only when max_nodes ended the search first: best then meets all
  /// constraints when its status is `solved`, and nothing was found when it is `iteration_limit`.
  bool proven = false;
};

/// Minimises 1/2 u'Hu + g'u subject to lower <= u <= upper and |u_i| >= gap_i (0: no gap; same unit as u), by
/// branch and bound over the signs of the variables that fall into their gaps; boxes by solve_box_qp, whose
/// statuses apply. bad_bounds also when a gap is negative or leaves nothing of a range. At most
/// 2^(number of gaps + 1) - 1 boxes are ever needed, so the default of max_nodes is no limit up to 8 gaps.
/// Pure, deterministic, allocates nothing.
GapQpSolution solve_gap_qp(const QpMatrix& H, const QpVector& g, const QpVector& lower, const QpVector& upper,
                           const QpVector& gap, const ActiveSet& start = {}, int max_nodes = 1000);

}  // namespace omniflight::allocation
