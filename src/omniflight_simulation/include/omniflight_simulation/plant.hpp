// The plant: rigid body, rotors with first-order speed, and the effects of a model file.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_physics/actuators.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_physics/neighbour_track.hpp"
#include "omniflight_simulation/thrust_map.hpp"
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
  std::vector<physics::NeighbourTrack> neighbours;  ///< who else flies here; at most kMaxNeighbours count
};

/// What acts on the body besides the model's effects, for instance a gust that a test sends.
class Disturbance {
 public:
  virtual ~Disturbance() = default;
  virtual void add_wrench(const physics::Situation& situation, physics::Wrench& out) const = 0;
};

/// One vehicle in its world. After construction nothing is allocated; the same inputs give the same bits.
class Plant {
 public:
  /// Refuses a vehicle or model that is not physical (mass, inertia about the centre of mass), a value
  /// outside the bounds of its parameter, effects that contradict each other or would silently do nothing (a
  /// neighbour's downwash without a neighbour, an overhead rope that does not reach the start), a start that
  /// is not finite and steps that do not resolve the motor lag.
  static Result<Plant> create(const vehicle::Vehicle& vehicle, const physics::Model& model,
                              const PlantConfig& config);

  /// Rotor speed commands [rad/s, signed] and tilt command [rad] from now on; kept within the rotor limits.
  /// A command that is not finite is refused (false) and the last one stays.
  bool set_command(std::span<const double> rotor_speed, double alpha);

  /// Faults of a rotor: healthy again, without power (its speed decays with its lag), or stuck at a speed
  /// [rad/s]. They act at once, whatever delay the commands have.
  void heal_rotor(std::size_t i) { set_fault(i, Fault::none, 0.0); }
  void cut_rotor(std::size_t i) { set_fault(i, Fault::cut, 0.0); }
  void seize_rotor(std::size_t i, double speed) { set_fault(i, Fault::seized, speed); }
  /// Acts from now on, at every stage of the integrator; null = none. Must outlive its use.
  void set_disturbance(const Disturbance* disturbance) {
    if (disturbance_ != disturbance) (void)answers();  // of the present state, before anything changes
    disturbance_ = disturbance;
  }

  /// One step of config.step. While held, the body stays where it is and only the rotors turn (the vehicle
  /// hangs on its rope or stands on its stand). Fails when the integration leaves every reasonable range, and
  /// names the state with its value.
  Status step(bool held = false);

  double time() const { return time_; }  ///< s
  const RigidState& body() const { return body_; }
  std::span<const double> rotor_speed() const { return {speed_.data(), count()}; }  ///< rad/s, signed
  double alpha() const { return actuators_.alpha(); }                               ///< rad
  /// Specific force [m/s^2, body] that an ideal accelerometer at the body origin reads.
  Vec3 specific_force() const { return answers().specific_force; }
  const Vec3& angular_acceleration() const { return answers().angular_acceleration; }  ///< rad/s^2, body
  /// Wrench of all effects [N, Nm, body], with their inertia taken at the present acceleration.
  const Vec6& effect_wrench() const { return answers().effect_wrench; }
  /// Mechanical power of the rotors: sum of drag torque times speed, and what effects add to it [W].
  double mechanical_power() const;
  /// Power [W] that the effects take from the motion of the body.
  double power_taken() const {
    const Vec6& w = effect_wrench();
    return -w.head<3>().dot(situation().v_WB_B) - w.tail<3>().dot(body_.w_WB_B);
  }
  /// What the effects look at, with the accelerations of the present instant.
  const physics::Situation& situation() const {
    (void)answers();
    return situation_;
  }
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
  struct Rate {
    Vec3 a_W, dw_B;
    Eigen::Vector4d q_WB;
  };
  /// An attitude, from a quaternion that need not have unit length.
  struct Frame {
    Mat3 scaled;            ///< R_WB times the squared length
    double inverse_square;  ///< one over it
  };
  /// The rotors at one instant.
  struct Rotors {
    Speeds speed, rate;  ///< rad/s, rad/s^2
    Vec6 wrench;         ///< N, Nm, body: the nominal law, and with it the effects that are mapped
  };
  /// An effect that acts while flying, and where its memory lies.
  struct Acting {
    const physics::Effect* effect;
    std::vector<double> theta;
    std::size_t at;  ///< first number of its memory
    physics::MemorySize size;
    bool on_wrench;
    bool mapped;  ///< map_ has its wrench
  };
  /// Calls f with the index of every continuous number of the memories.
  template <class Function>
  void over_continuous(const Function& f) const {
    if (memory_.empty()) return;
    for (const Acting& e : effects_)
      for (std::size_t j = e.at; j < e.at + static_cast<std::size_t>(e.size.continuous); ++j) f(j);
  }
  enum class Fault { none, cut, seized };
  std::size_t count() const { return count_; }
  void set_fault(std::size_t i, Fault fault, double speed) {
    (void)answers();
    fault_[i] = fault;
    seized_at_[i] = speed;
    faulty_ = std::any_of(fault_.begin(), fault_.end(), [](Fault f) { return f != Fault::none; });
  }
  void apply_rotor_faults();
  /// What the last evaluation found beside the derivative.
  struct Answers {
    Vec3 specific_force = Vec3::Zero(), angular_acceleration = Vec3::Zero();
    Vec6 effect_wrench = Vec6::Zero();
  };
  /// Of the present state; evaluated when somebody asks for them.
  const Answers& answers() const;
  /// Brings map_ to the present tilt.
  void map_rotors() const;
  Speeds speed_rates(const double* speed) const;
  Vec6 rotor_wrench(const double* speed) const;  ///< by map_
  /// The rotors at the beginning, in the middle and at the end of the step.
  void spin(Rotors (&nodes)[3]);
  /// Shows the effects the rotors, and then a body. `speeds`: somebody looks at more than where they are.
  void look_at(const Rotors& rotors, bool speeds) const;
  Frame look(const RigidState& body, double t) const;
  /// Fills the derivative of the body and, unless null, the rates of the memories. Somebody has looked at the
  /// rotors, when there is more than these and gravity.
  void evaluate(const RigidState& body, const Rotors& rotors, const double* memory, double t, bool held,
                Rate& out, double* memory_rate) const;
  /// Wrench of the effects and the disturbance; `all`: the mapped ones, too.
  void sum_effects(const double* memory, bool all) const;
  /// Equations of motion under a force and torque beside the weight, with mass that moves along.
  void solve_motion(const Frame& frame, const Vec3& w, const Vec3& force, const Vec3& torque, double mass,
                    double lifted_mass, Rate& out) const;
  /// The same with every kind of inertia, for the wrench of the effects and that of the rotors.
  void solve_general_motion(const Vec6& rotors, const physics::Wrench& effects, Rate& out) const;
  void solve_motion(const Frame& frame, const Vec6& rotors, Rate& out) const;
  void euler_step(bool held);
  void runge_kutta_step(bool held);
  template <bool kBare>
  void move_body(const Rotors (&nodes)[3], bool held);
  Status check() const;
  Status beyond_range() const;  ///< says what check() found

  vehicle::Vehicle vehicle_;
  std::size_t count_;  ///< of rotors
  PlantConfig config_;
  physics::Actuators actuators_;
  std::vector<Acting> effects_;
  Mat3 inverse_inertia_;
  double inverse_mass_;
  bool centred_;                  ///< the centre of mass is the body origin
  bool bare_ = true;              ///< no effect acts but those that are mapped
  bool ideal_motor_ = false;      ///< a rotor has no lag
  bool looks_at_speeds_ = false;  ///< an effect that is not mapped does
  bool faulty_ = false;           ///< a rotor is
  RigidState body_;
  Speeds speed_{}, command_{}, highest_{}, lowest_{};  ///< rad/s; the last two of a command
  double alpha_command_ = 0, time_ = 0;
  // what follows from the state; changes when it is asked for
  mutable Answers answers_;
  mutable bool answered_ = false;
  bool held_ = true;
  mutable physics::Situation situation_;
  mutable double prepared_alpha_ = std::numeric_limits<double>::quiet_NaN();  ///< rad, of situation_
  ThrustMap thrust_map_;
  mutable double mapped_alpha_ = std::numeric_limits<double>::quiet_NaN();  ///< rad, of the next
  mutable ThrustMap::Columns map_;
  Vec6 end_wrench_ = Vec6::Zero();  ///< of the rotors at the end of the last step
  bool end_known_ = false;          ///< and nothing has changed since
  mutable physics::Wrench wrench_;  ///< of the effects, in evaluate()
  std::vector<double> memory_, stage_memory_, memory_sum_, memory_rate_;
  std::vector<Random> random_;  ///< a stream for each acting effect
  std::uint64_t steps_ = 0;
  std::array<Fault, vehicle::kMaxRotors> fault_{};
  Speeds seized_at_{};
  const Disturbance* disturbance_ = nullptr;
};

}  // namespace omniflight::simulation
