// The plant: rigid body, rotors with first-order speed, and the effects of a model file.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_physics/actuators.hpp"
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
  std::uint64_t seed = 1;      ///< of the effects that are random: the same seed gives the same bits
};

/// One vehicle in its world. After construction nothing is allocated; the same inputs give the same bits.
class Plant {
 public:
  /// Refuses a vehicle or model that is not physical, a value outside the bounds of its parameter, and steps
  /// that do not resolve the motor lag.
  static Result<Plant> create(const vehicle::Vehicle& vehicle, const physics::Model& model,
                              const PlantConfig& config);

  /// Rotor speed commands [rad/s, signed] and tilt command [rad] from now on; kept within the rotor limits.
  /// A command that is not finite is refused (false) and the last one stays.
  bool set_command(std::span<const double> rotor_speed, double alpha);

  /// One step of config.step. While held, the body stays where it is and only the rotors turn (the vehicle
  /// hangs on its rope or stands on its stand). Fails when the integration leaves every reasonable range, and
  /// names the state with its value.
  Status step(bool held = false);

  double time() const { return time_; }  ///< s
  const RigidState& body() const { return body_; }
  std::span<const double> rotor_speed() const { return {speed_.data(), count()}; }  ///< rad/s, signed
  double alpha() const { return actuators_.alpha(); }                               ///< rad
  /// Specific force [m/s^2, body] that an ideal accelerometer at the body origin reads.
  Vec3 specific_force() const { return specific_force_; }
  const Vec3& angular_acceleration() const { return angular_acceleration_; }  ///< rad/s^2, body
  /// Wrench of all effects [N, Nm, body], with their inertia taken at the present acceleration.
  const Vec6& effect_wrench() const { return effect_wrench_; }
  /// Mechanical power of the rotors: sum of drag torque times speed, and what effects add to it [W].
  double mechanical_power() const;
  /// Power [W] that the effects take from the motion of the body.
  double power_taken() const {
    return -effect_wrench_.head<3>().dot(situation_.v_WB_B) - effect_wrench_.tail<3>().dot(body_.w_WB_B);
  }
  /// What the effects look at, with the accelerations of the present instant.
  const physics::Situation& situation() const { return situation_; }
  /// Rotors and tilt servo: voltage, energy, the alterations in force.
  const physics::Actuators& actuators() const { return actuators_; }
  /// Memory of an effect of the model by id (physics::MemorySize); empty when it has none.
  std::span<const double> memory(const std::string& id) const;
  const vehicle::Vehicle& vehicle() const { return vehicle_; }
  const PlantConfig& config() const { return config_; }

 private:
  Plant(const vehicle::Vehicle& vehicle, const physics::Model& model, const PlantConfig& config,
        physics::Actuators actuators);
  using Speeds = std::array<double, vehicle::kMaxRotors>;
  struct Derivative {
    Vec3 v_W, a_W, dw_B;
    Vec3 w_B;
    Eigen::Vector4d q_WB;
    Speeds speed;
  };
  /// An effect that acts while flying, and where its memory lies.
  struct Acting {
    const physics::Effect* effect;
    std::vector<double> theta;
    std::size_t at;  ///< first number of its memory
    physics::MemorySize size;
  };
  std::size_t count() const { return vehicle_.rotors.size(); }
  void evaluate(const RigidState& body, const double* speed, const double* memory, double t, bool held,
                Derivative& out, double* memory_rate);
  void solve_motion(const physics::Wrench& effects, Derivative& out);
  void refresh(bool held);
  void euler_step(bool held);
  void runge_kutta_step(bool held);
  Status check() const;

  vehicle::Vehicle vehicle_;
  PlantConfig config_;
  physics::Actuators actuators_;
  std::vector<Acting> effects_;
  Mat3 inverse_inertia_;
  RigidState body_;
  Speeds speed_{}, command_{};
  double alpha_command_ = 0, time_ = 0;
  Vec3 specific_force_ = Vec3::Zero(), angular_acceleration_ = Vec3::Zero();
  Vec6 effect_wrench_ = Vec6::Zero();
  physics::Situation situation_;
  std::vector<double> memory_, stage_memory_, memory_sum_, memory_rate_;
  std::vector<Random> random_;  ///< a stream for each acting effect
  std::uint64_t steps_ = 0;
};

}  // namespace omniflight::simulation
