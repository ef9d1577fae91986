// Can this attitude be held? Answered by quadratic programs, without the zonotope: a second opinion for
// tests.
#pragma once

#include <gtest/gtest.h>

#include <optional>

#include "omniflight_allocation/box_qp.hpp"
#include "omniflight_allocation/rotor_load.hpp"

namespace omniflight::allocation {

/// Thrusts [N] that hold the vehicle at rest with the share `headroom` of every range kept free, or nothing
/// when there are none; exact to 1e-6 of the weight.
inline std::optional<vehicle::RotorVector> hover_thrusts(const vehicle::Vehicle& v, const Quat& q_WB,
                                                         double alpha, double headroom) {
  const int n = v.rotor_count();
  if (n < 1 || n > kMaxInputs || !q_WB.coeffs().allFinite() || !(q_WB.norm() > 1e-6) ||
      !std::isfinite(alpha) || !(headroom >= 0 && headroom < 1))
    return std::nullopt;
  vehicle::AllocationMatrix B = v.allocation_matrix(alpha);
  double lever = 1e-9;
  for (int i = 0; i < n; ++i) lever = std::max(lever, B.block<3, 1>(3, i).norm());
  B.bottomRows<3>() /= lever;
  const Vec3 force = q_WB.normalized().conjugate() * Vec3(0, 0, v.mass * kGravity);
  Vec6 wrench;
  wrench << force, v.center_of_mass.cross(force) / lever;
  vehicle::RotorVector lower = v.lower_thrusts(), upper = v.upper_thrusts();
  const vehicle::RotorVector margin = 0.5 * headroom * (upper - lower);
  lower += margin;
  upper -= margin;

  // Proximal point iteration on |B u - wrench|^2: each step is a strictly convex problem solved exactly, and
  // the steps end in a balance or in a residual that separates the wrench from everything the rotors can
  // give.
  QpMatrix H = B.transpose() * B;
  const double proximity = 1e-6 * H.diagonal().maxCoeff();
  H.diagonal().array() += proximity;
  const QpVector pull = -B.transpose() * wrench;
  vehicle::RotorVector u = (0.5 * (lower + upper)).eval();
  ActiveSet active{};
  const double tolerance = 1e-6 * wrench.norm();
  for (int i = 0; i < 50; ++i) {
    const QpVector g = pull - proximity * u;
    const BoxQpSolution qp = solve_box_qp(H, g, lower, upper, active);
    if (qp.status != QpStatus::solved) return std::nullopt;
    u = qp.u;
    active = qp.active_set;
    const Vec6 missing = wrench - B * u;
    if (missing.norm() <= tolerance) return u;
    const QpVector share = B.transpose() * missing;
    const double most = share.cwiseProduct(lower).cwiseMax(share.cwiseProduct(upper)).sum();
    if (missing.dot(wrench) > most + 1e-9 * missing.norm() * wrench.norm()) return std::nullopt;
  }
  return std::nullopt;
}

/// The answer of both ways, which must agree.
inline bool hover_feasible(const vehicle::Vehicle& v, const Quat& q_WB, double alpha, double headroom = 0) {
  const bool by_set = RotorLoad::create(v, alpha).value().hover_load(q_WB.normalized()) <= 1.0 - headroom;
  EXPECT_EQ(by_set, hover_thrusts(v, q_WB, alpha, headroom).has_value());
  return by_set;
}

}  // namespace omniflight::allocation
