// Exact solution of a small strictly convex quadratic program with bounds on every variable.
#pragma once

#include <array>
#include <cstdint>

#include "omniflight_core/frames.hpp"

namespace omniflight::allocation {

inline constexpr int kMaxInputs = 16;
/// Fixed capacity: no memory is allocated whatever the size.
using QpVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxInputs, 1>;
using QpMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxInputs, kMaxInputs>;

enum class QpStatus {
  solved,
  not_finite,       ///< a NaN anywhere, or an infinity in H or g
  bad_size,         ///< sizes differ, or n is 0 or above kMaxInputs
  bad_bounds,       ///< a lower bound above its upper bound
  not_convex,       ///< H is not positive definite to working precision
  iteration_limit,  ///< u meets the bounds but is not the minimum
};
const char* to_string(QpStatus status);

/// Guess of the active bounds: -1 at the lower one, 0 free, +1 at the upper one. All free by default.
using ActiveSet = std::array<std::int8_t, kMaxInputs>;

struct BoxQpSolution {
  QpStatus status = QpStatus::bad_size;
  QpVector u;              ///< the minimum; within the bounds to the bit whenever it is not empty
  ActiveSet active_set{};  ///< hand it to the next, similar problem
  int active_bounds = 0;   ///< variables held at a bound
  int iterations = 0;      ///< linear systems solved
  double kkt_residual =
      0;  ///< max_i |v_i - clip(v_i - (H v + g)_i)| with max diag H = 1 and v = u / max |bound|
};

/// Minimises 1/2 u'Hu + g'u subject to lower <= u <= upper (infinite bounds are allowed). Of H, symmetric and
/// positive definite, the lower triangle is read. Block principal pivoting (Judice and Pires, 1994) with the
/// single-pivot rule of Murty as fallback, which cannot cycle; then refinement with the true gradient. Each
/// pivot is one sweep (Goodnight, 1979) of the matrix, in vectors of the processor that runs it, with the
/// same bits on every processor. Pure; allocates nothing; the answer does not depend on start beyond
/// rounding.
BoxQpSolution solve_box_qp(const QpMatrix& H, const QpVector& g, const QpVector& lower, const QpVector& upper,
                           const ActiveSet& start = {});

/// A matrix and its principal pivots, padded to 8 or 16 columns. Private to BoxQpSolver and the kernel.
struct QpWorkspace {
  alignas(64) double h[kMaxInputs * kMaxInputs];  ///< scaled: largest diagonal element 1
  alignas(64) double t[kMaxInputs * kMaxInputs];  ///< h with the variables `pivoted` swept
  double h_scale = 1;                             ///< times h: the matrix
  std::uint32_t pivoted = 0;                      ///< a bit for each variable
  int n = 0;                                      ///< variables; 0: no matrix
  int exchanges = 0;                              ///< pivots since the sweeps began anew
  bool swept = false;                             ///< t holds something
  bool stiff = false;                             ///< a pivot was so small that rounding shows
};

/// The same for a matrix that stays while g, bounds and start change: its pivots are kept from one program to
/// the next, so that a program with the active set of the last one takes two products of matrix and vector.
class BoxQpSolver {
 public:
  /// The lower triangle of H is read; solved, not_finite, bad_size or not_convex (a diagonal element that is
  /// not positive; the rest shows while solving).
  QpStatus set_matrix(const QpMatrix& H);
  /// As solve_box_qp; bad_size also while no matrix is set. The answer depends on earlier calls by rounding
  /// only.
  BoxQpSolution solve(const QpVector& g, const QpVector& lower, const QpVector& upper,
                      const ActiveSet& start = {});

 private:
  QpWorkspace workspace_;
};

}  // namespace omniflight::allocation
