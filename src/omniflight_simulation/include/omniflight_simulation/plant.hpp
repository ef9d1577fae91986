// The plant: rigid body, rotors with first-order speed, and the effects of a model file.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::simulation {

enum class Integrator { rk4, semi_implicit_euler };

struct PlantConfig {
  double step = 0.001;  ///< s
  Integrator integrator = Integrator::rk4;
  physics::Environment environment;
  RigidState initial;          ///< at rest or moving
  double initial_alpha = 0.0;  ///< rad
};

/// One vehicle in its world. After construction nothing is allocated; the same inputs give the same bits.
class Plant {
 public:
  /// Refuses a vehicle or model that is not physical, and steps that do not resolve the motor lag.
  static Result<Plant> create(const vehicle::Vehicle& vehicle, const physics::Model& model,
                              const PlantConfig& config);

  /// Rotor speed commands [rad/s, signed] and tilt command [rad] from now on; kept within the rotor limits.
  /// A command that is not finite is refused (false) and the last one stays.
  bool set_command(std::span<const double> rotor_speed, double alpha);

  /// One step of config.step. While held, the body stays where it is and only the rotors turn (the vehicle
  /// hangs on its rope or stands on its stand). Fails when the integration leaves every reasonable range.
  Status step(bool held = false);

  double time() const { return time_; }  ///< s
  const RigidState& body() const { return body_; }
  std::span<const double> rotor_speed() const { return {speed_.data(), count()}; }  ///< rad/s, signed
  double alpha() const { return alpha_; }                                           ///< rad
  /// Specific force [m/s^2, body] that an ideal accelerometer at the body origin reads.
  Vec3 specific_force() const { return specific_force_; }
  const Vec3& angular_acceleration() const { return angular_acceleration_; }  ///< rad/s^2, body
  /// Wrench of all effects [N, Nm, body], with their inertia taken at the present acceleration.
  const Vec6& effect_wrench() const { return effect_wrench_; }
  /// Mechanical power of the rotors: sum of drag torque times speed [W].
  double mechanical_power() const;
  const vehicle::Vehicle& vehicle() const { return vehicle_; }
  const PlantConfig& config() const { return config_; }

 private:
  Plant(const vehicle::Vehicle& vehicle, const physics::Model& model, const PlantConfig& config);
  struct Derivative {
    Vec3 v_W, a_W, dw_B;
    Vec3 w_B;
    std::array<double, vehicle::kMaxRotors> speed;
  };
  std::size_t count() const { return vehicle_.rotors.size(); }
  void evaluate(const RigidState& body, const double* speed, Derivative& out, bool held);
  void refresh(bool held);

  vehicle::Vehicle vehicle_;
  std::vector<physics::ActiveEffect> effects_;
  PlantConfig config_;
  physics::Actuation actuation_;
  RigidState body_;
  std::array<double, vehicle::kMaxRotors> speed_{}, target_{}, rotor_acceleration_{};
  double alpha_ = 0, alpha_command_ = 0, time_ = 0;
  Vec3 specific_force_ = Vec3::Zero(), angular_acceleration_ = Vec3::Zero();
  Vec6 effect_wrench_ = Vec6::Zero();
  physics::Situation situation_;
  std::vector<std::array<double, vehicle::kMaxRotors>> history_;  ///< commands of past steps, a ring
  std::vector<std::size_t> delay_steps_;
  std::size_t steps_ = 0;
};

}  // namespace omniflight::simulation
