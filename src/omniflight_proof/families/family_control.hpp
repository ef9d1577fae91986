// The controllers of the families, written for the proof alone: none shares code with the project's
// controller or allocator.
#pragma once

#include <memory>
#include <span>

#include "family_vehicle.hpp"

namespace omniflight::proof {

/// Per axis. Position error to acceleration (kp 1/s^2, kv 1/s, ki 1/s^3), attitude error to angular
/// acceleration (kR 1/s^2, kw 1/s, kI 1/s^3).
struct Gains {
  Vec3 kp = Vec3::Constant(5), kv = Vec3::Constant(3.6), ki = Vec3::Constant(1.5);
  Vec3 kR = Vec3::Constant(100), kw = Vec3::Constant(20), kI = Vec3::Constant(20);
};

enum class ControllerKind {
  geometric,  ///< PID on position and on SO(3), feed-forward
  cascade,    ///< P position, PI velocity, P attitude, PI rate, each inside the next
  indi,       ///< increments on filtered accelerometer, gyro and rotor speeds (Smeur 2016)
  sliding     ///< saturated sliding surfaces with a boundary layer
};

struct ControllerSetup {
  ControllerKind kind = ControllerKind::geometric;
  Gains gains;
  bool feedforward = true;      ///< of the reference acceleration
  double filter_hz = 15;        ///< of indi
  double allocation_mass = -1;  ///< kg that it multiplies accelerations by; < 0: of the vehicle file
  double yaw_cut = 1;           ///< share of the yaw acceleration that is asked for
  double integral_limit = 3;    ///< m/s^2 and rad/s^2 of the integral terms
};

struct ControlInput {
  Reference reference;
  RigidState state;
  Vec3 specific_force_B = Vec3::Zero();
  std::span<const double> rotor_speed;  ///< rad/s
  double alpha = 0;                     ///< rad
  double dt = 0.002;                    ///< s
};

struct ControlOutput {
  vehicle::RotorVector thrust;       ///< N
  Vec6 demand = Vec6::Zero();        ///< m/s^2 world, rad/s^2 body
  Vec6 achieved = Vec6::Zero();      ///< the same, of the thrusts that are within limits
  Quat attitude = Quat::Identity();  ///< that the attitude loop follows
};

class FamilyController {
 public:
  FamilyController(const FamilyVehicle& vehicle, const ControllerSetup& setup);
  void reset();
  /// Acceleration and angular acceleration that it asks for, and the rotor thrusts.
  ControlOutput update(const ControlInput& in);

 private:
  /// Second-order low pass (Butterworth), bilinear.
  struct Filter {
    double b0 = 1, b1 = 0, b2 = 0, a1 = 0, a2 = 0;
    Vec3 x1 = Vec3::Zero(), x2 = Vec3::Zero(), y1 = Vec3::Zero(), y2 = Vec3::Zero();
    bool begun = false;
    void design(double cut_off, double dt);
    Vec3 operator()(const Vec3& x);
  };
  Vec3 acceleration(const ControlInput& in);
  Quat wanted_attitude(const ControlInput& in, const Vec3& specific_W) const;
  Vec3 angular_acceleration(const ControlInput& in, const Quat& wanted, const Vec3& rate,
                            const Vec3& rate_change);
  Vec6 wrench(const ControlInput& in, const Vec3& a, const Vec3& dw);
  vehicle::RotorVector allocate(const Vec6& wrench, double alpha) const;

  FamilyVehicle vehicle_;
  ControllerSetup setup_;
  double mass_;
  Vec3 position_integral_ = Vec3::Zero(), attitude_integral_ = Vec3::Zero();
  Filter force_, gyro_, rotor_force_, rotor_torque_;
  Vec3 last_gyro_ = Vec3::Zero(), filtered_force_ = Vec3::Zero(), gyro_rate_ = Vec3::Zero();
  Vec6 filtered_wrench_ = Vec6::Zero();
  bool filters_ready_ = false;
};

/// Gains that fly this vehicle well, varied from case to case.
Gains draw_gains(const FamilyVehicle& vehicle, BoxRandom& random);

}  // namespace omniflight::proof
