// A second-order low-pass 1/(1 + 2 z T s + T^2 s^2) of a vector signal, exact between samples for an input
// that is held.
#pragma once

#include "omniflight_core/frames.hpp"

namespace omniflight::simulation {

class LowPass {
 public:
  LowPass() = default;
  /// time T [s], damping z [1], step [s]; T = 0 passes everything.
  LowPass(double time, double damping, double step) : active_(time > 0) {
    if (!active_) return;
    // x = (y, T dy, u): dx = A x with the input u held; exp(A step) by scaling and squaring
    Mat3 A;
    A << 0, 1, 0, -1, -2 * damping, 1, 0, 0, 0;
    A *= step / time;
    int halvings = 0;
    while (A.cwiseAbs().maxCoeff() > 0.01) A *= 0.5, ++halvings;
    Mat3 E = Mat3::Identity(), term = Mat3::Identity();
    for (int k = 1; k <= 8; ++k) term = (term * A / k).eval(), E += term;
    for (; halvings > 0; --halvings) E = (E * E).eval();
    step_ = E.topRows<2>();
  }
  /// One step with the input u; the first input is taken to have lasted for ever.
  Vec3 operator()(const Vec3& u) {
    if (!active_) return u;
    if (!started_) y_ = u, dy_.setZero(), started_ = true;
    const Vec3 y = step_(0, 0) * y_ + step_(0, 1) * dy_ + step_(0, 2) * u;
    dy_ = step_(1, 0) * y_ + step_(1, 1) * dy_ + step_(1, 2) * u;
    y_ = y;
    return y;
  }

 private:
  bool active_ = false, started_ = false;
  Eigen::Matrix<double, 2, 3> step_ = Eigen::Matrix<double, 2, 3>::Zero();
  Vec3 y_ = Vec3::Zero(), dy_ = Vec3::Zero();
};

}  // namespace omniflight::simulation
