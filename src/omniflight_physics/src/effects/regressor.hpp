// For effects that are linear in many parameters: the columns are written once, value and exact derivative
// follow.
#pragma once

#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {

/// 6 x parameters: force [N] and torque [Nm] per unit of each parameter, body axes. Allocates nothing.
using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxParameters>;

/// Derive from this and write `void columns(const Situation&, Columns& out) const`; out arrives as zeros.
template <class Derived>
class RegressorEffect : public Effect {
 public:
  bool acts_on_wrench() const final { return true; }
  void add_wrench(const Situation& s, const double* theta, Wrench& out) const final {
    const Vec6 w = at(s) * Eigen::Map<const Eigen::VectorXd>(theta, parameter_count());
    out.force_B += w.head<3>();
    out.torque_B += w.tail<3>();
  }
  void wrench_with_jacobian(const Situation& s, const double* theta, double* value,
                            double* jacobian) const final {
    const Columns c = at(s);
    Eigen::Map<Vec6> w(value);
    w.noalias() = c * Eigen::Map<const Eigen::VectorXd>(theta, parameter_count());
    Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic>>(jacobian, 6, parameter_count()) = c;
  }

 private:
  Columns at(const Situation& s) const {
    Columns c = Columns::Zero(6, parameter_count());
    static_cast<const Derived*>(this)->columns(s, c);
    return c;
  }
};

}  // namespace omniflight::physics
