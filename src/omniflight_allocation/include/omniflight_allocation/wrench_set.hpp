// Every wrench a vehicle can exert at one tilt, exactly: the zonotope of its rotors, and slices of it.
#pragma once

#include "omniflight_allocation/polytope.hpp"
#include "omniflight_core/result.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::allocation {

class WrenchSet {
 public:
  /// The set of B u over lower <= u <= upper [N], torques about the centre of mass, body axes.
  /// f_max [N] replaces the largest thrust of every rotor; 0 keeps the vehicle's.
  static Result<WrenchSet> create(const vehicle::Vehicle& vehicle, double alpha, double f_max = 0);

  /// Share of the rotors' ranges that the best allocation of a wrench needs: the least over all thrusts that
  /// give it of max |u_i - middle_i| / half range_i. 1 is the limit; infinite when no thrusts of any size
  /// give it, or it is not finite. wrench: force [N], then torque [Nm] about the centre of mass, body axes.
  double load(const Vec6& wrench) const;

  /// The load of a force [N] without torque, for less time.
  double load_of_force(const Vec3& force) const;
  /// The most that load_of_force changes by for each newton of a change of the force [1/N]; infinite below
  /// rank 6.
  double load_slope_of_force() const;

  /// Part of a wrench (or of a change of one) that no thrusts of any size give: its projection on the
  /// complement of the range of the allocation matrix. Zero at rank 6. Torques divided by the lever arm, so
  /// that all is in N.
  Vec6 unreachable(const Vec6& wrench) const { return outside_ * wrench; }
  /// Norm of a wrench [N], torques divided by the same lever arm.
  double scaled_norm(const Vec6& wrench) const {
    return std::hypot(wrench.head<3>().norm(), wrench.tail<3>().norm() / lever_);
  }

  int rank() const { return rank_; }  ///< 6: force and torque can be chosen independently near the centre

  Polytope force_at_torque(const Vec3& torque) const;  ///< N, the forces that leave exactly this torque [Nm]
  Polytope torque_at_force(const Vec3& force) const;   ///< Nm, the torques that leave exactly this force [N]
  /// Nm, the torques that are left whatever the attitude, while the weight [N] is carried.
  Polytope torque_at_any_attitude(double weight) const;

  /// N, largest force that can be exerted in every direction at zero torque; the inradius, without the
  /// vertices.
  double omnidirectional_force() const;

 private:
  struct Face {
    Vec6 normal;    // wrench with torques divided by lever_, unit length, within the span of the set
    double offset;  // normal . wrench <= offset
  };
  enum class Part { force, torque };
  struct Slice {
    bool empty = true;
    Flat flat;
    std::vector<HalfSpace> half_spaces;
  };
  using Generators = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  /// Sets rank_ and span_; the size of the generators [N].
  double find_span(const Generators& generators);
  Slice slice(Part shown, const Vec3& fixed_value) const;
  Polytope body(const Slice& slice, double scale) const;

  Eigen::Matrix<double, 6, Eigen::Dynamic> span_;  // orthonormal, 6 x rank
  Vec6 centre_ = Vec6::Zero();                     // scaled wrench of the middle of the box
  std::vector<Face> faces_;
  // load = max |loads (wrench - middle)|, N and Nm; rows of zeros fill the last four
  Eigen::Matrix<double, Eigen::Dynamic, 6> loads_;
  Eigen::VectorXd load_of_none_;  // loads (0 - middle)
  Mat6 outside_ = Mat6::Zero();   // part of a wrench that no rotor can give
  int rank_ = 0;
  double lever_ = 1;  // m
  double reach_ = 0;  // N, bound of |scaled wrench|
};

}  // namespace omniflight::allocation
