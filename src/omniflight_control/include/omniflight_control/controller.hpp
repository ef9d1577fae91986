// Geometric 6D tracking control: reference and state in, desired acceleration of the rigid body out.
#pragma once

#include "omniflight_core/frames.hpp"

namespace omniflight::control {

struct ControllerConfig {
  Vec3 kv = Vec3::Constant(6);    ///< 1/s, velocity error
  Vec3 kp = Vec3::Constant(12);   ///< 1/s^2, position error
  Vec3 ki = Vec3::Constant(2);    ///< 1/s^3, integral of the position error; zero makes it the PD law
  Vec3 kw = Vec3::Constant(20);   ///< 1/s, angular velocity error
  Vec3 kR = Vec3::Constant(100);  ///< 1/s^2, attitude error
  Vec3 kI = Vec3::Constant(20);   ///< 1/s^3, integral of the attitude error
  double max_integral_acceleration = 6.0;           ///< m/s^2, bound of the integral action a axis
  double max_integral_angular_acceleration = 15.0;  ///< rad/s^2
  double max_acceleration = 12.0;                   ///< m/s^2, saturation of the feedback (eq. 4.4)
  double max_angular_acceleration = 60.0;           ///< rad/s^2
  bool feed_forward = true;                         ///< add reference accelerations
  /// A demand that was missed by more than this stops the integrators that would ask for more of it.
  double unachieved_tolerance = 0.05;         ///< m/s^2 an axis
  double unachieved_angular_tolerance = 0.5;  ///< rad/s^2 an axis
};

/// What a law takes of reference and state, by each axis: far beyond every flight, and small enough that no
/// product of them overflows. Quaternions are of unit length to 1 %.
struct LawInputLimits {
  static constexpr double position = 1e5;              ///< m
  static constexpr double velocity = 1e3;              ///< m/s
  static constexpr double acceleration = 1e4;          ///< m/s^2, of the reference and unachieved
  static constexpr double rate = 1e3;                  ///< rad/s
  static constexpr double angular_acceleration = 1e5;  ///< rad/s^2, of the reference and unachieved
  static constexpr double shortest_dt = 1e-6, longest_dt = 10.0;  ///< s; 0 is taken too: nothing is learnt
};

/// Reference and state in, desired acceleration out. Implementations hold their integrators, are
/// deterministic and allocate nothing in update().
class Law {
 public:
  virtual ~Law() = default;
  /// Desired acceleration: m/s^2 in world axes, then rad/s^2 in body axes. dt [s] since the last call.
  /// unachieved: last demand minus what the allocator achieved of it, same layout. Input that no flight has
  /// (LawInputLimits, or not finite) is refused and counted: the last demand is repeated and nothing learnt.
  Vec6 update(const Reference& reference, const RigidState& state, double dt,
              const Vec6& unachieved = Vec6::Zero());
  /// Calls of update() that were refused.
  unsigned long refused() const { return refused_; }
  /// What the law has learnt of the steady part of its demand: m/s^2 world, rad/s^2 body.
  virtual Vec6 integral_action() const = 0;
  /// Forgets what it has learnt, and its last demand.
  void reset() {
    last_demand_.setZero();
    forget();
  }

 protected:
  Law() = default;
  Law(const Law&) = default;
  Law& operator=(const Law&) = default;

 private:
  /// update() with input within the limits; the answer is finite then.
  virtual Vec6 answer(const Reference& reference, const RigidState& state, double dt,
                      const Vec6& unachieved) = 0;
  virtual void forget() = 0;

  Vec6 last_demand_ = Vec6::Zero();
  unsigned long refused_ = 0;
};

/// PD of thesis eq. 4.1 with feed-forward; with integral gains the saturated PID of eq. 4.4. Anti-windup: the
/// integrators are bounded, and one stands still while its axis saturates or the allocator missed the last
/// demand on it, unless the error takes the demand back.
class Controller final : public Law {
 public:
  explicit Controller(const ControllerConfig& config) : config_(config) {}

  /// Integral action as acceleration: m/s^2 world, rad/s^2 body.
  Vec6 integral_action() const override;

 private:
  Vec6 answer(const Reference& reference, const RigidState& state, double dt,
              const Vec6& unachieved) override;
  void forget() override { integral_.setZero(); }

  ControllerConfig config_;
  Vec6 integral_ = Vec6::Zero();  ///< m s, then rad s
};

/// Attitude error 1/2 vee(R^T R_d - R_d^T R): restoring rotation vector in body axes for small errors.
Vec3 attitude_error(const Quat& q_WB, const Quat& q_WD);

}  // namespace omniflight::control
