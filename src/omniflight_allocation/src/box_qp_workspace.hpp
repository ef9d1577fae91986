// What the kernel of the box program works on: one matrix, its principal pivots, one right-hand side.
#pragma once

#include <cstdint>

#include "omniflight_allocation/box_qp.hpp"

namespace omniflight::allocation::qp_kernel {

inline constexpr double kStiff = 1e-8;  ///< pivot below which rounding of the gradient shows in the answer

/// Bounds and linear term of one program; arrays of n.
struct Terms {
  const double* g;
  const double* lower;
  const double* upper;
  const std::int8_t* start;
};

/// Checks and scales a matrix of n x n, column-major without gaps, of which the lower triangle is read.
QpStatus set_matrix(const double* H, int n, QpWorkspace& w);

/// Minimises for the matrix that was set. Begins from the pivots that w holds.
void solve(const Terms& terms, QpWorkspace& w, BoxQpSolution& out);

}  // namespace omniflight::allocation::qp_kernel
