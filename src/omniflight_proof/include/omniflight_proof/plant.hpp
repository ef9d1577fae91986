// One vehicle in the proof's world, stepped by MuJoCo. Same calls as the simulator's plant, no code in
// common.
#pragma once

#include <memory>
#include <span>

#include "omniflight_core/result.hpp"
#include "omniflight_proof/world.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::proof {

struct PlantOptions {
  double step = 0.001;       ///< s, of step(); a whole multiple of World::timestep
  RigidState initial;        ///< where it starts
  double initial_alpha = 0;  ///< rad
  std::uint64_t seed = 1;    ///< of gusts and turbulence
};

/// MuJoCo integrates; motors, aerodynamics, winds and springs are this library's own. Plants are independent
/// of each other and may run in different threads. The same calls give the same bits.
///
///   auto world = proof::load_world("cable.yaml");
///   auto plant = proof::MujocoPlant::create(vehicle, *world, {.initial = start, .initial_alpha = alpha});
///   proof::SensorSuite sensors(config, world->sensors, 0.001, seed);
///   proof::SensorFrame frame;
///   for (...) { sensors.sample(*plant, frame); plant->set_command(speeds, alpha); plant->step(held); }
class MujocoPlant {
 public:
  /// Builds the model and lets ropes and loads come to rest with the body held at the start. Refuses
  /// (bad_input, with field and unit) an invalid vehicle or world, a mass or inertia that is not left
  /// positive, a rope that cannot reach, a start with the load below the floor.
  static Result<MujocoPlant> create(const vehicle::Vehicle& vehicle, const World& world,
                                    const PlantOptions& options);
  MujocoPlant(MujocoPlant&&) noexcept;
  MujocoPlant& operator=(MujocoPlant&&) noexcept;
  ~MujocoPlant();

  /// Rotor speed commands [rad/s, signed] and tilt [rad] from now on. False (and nothing changes) when a
  /// number is not finite or the count is wrong.
  bool set_command(std::span<const double> rotor_speed, double alpha);
  /// One step of options.step. While held, the body stays where hold_at() or the start put it; rotors turn
  /// and ropes swing. Fails (incomplete) when the integration leaves |p| <= 1000 m, |w| <= 1000 rad/s.
  Status step(bool held = false);
  /// Moves the held body as on a rail: pose and velocity it has at the end of the next held step.
  void hold_at(const RigidState& state);
  /// Back to the start, with another seed for gusts and turbulence.
  void reset(std::uint64_t seed);

  double time() const;                          ///< s
  const RigidState& body() const;               ///< true state of the body origin
  std::span<const double> rotor_speed() const;  ///< rad/s, signed, true
  double alpha() const;                         ///< rad, as the tilt servo reports it
  double true_alpha() const;                    ///< rad, of the rotor axes
  Vec3 acceleration() const;                    ///< m/s^2, of the body origin, world
  Vec3 angular_acceleration() const;            ///< rad/s^2, body
  Vec3 specific_force() const;  ///< m/s^2, body: what an ideal accelerometer at the origin reads
  /// What the motion needs beyond the nominal vehicle with these rotor speeds [N, N m, body, about its
  /// origin].
  Vec6 unmodelled_wrench() const;
  double mechanical_power() const;  ///< W, rotor torque times speed by the nominal coefficients
  /// Battery voltage and current [V, A] when the world has a battery; {0, 0} otherwise.
  std::pair<double, double> battery() const;
  Vec3 wind_W() const;  ///< m/s at the body origin
  /// Force that the hung cable exerts on the vehicle [N, world]; zero without one.
  Vec3 cable_force_W() const;
  /// Joints of the hung cable from the attachment to the free end [m, world]; empty without one.
  std::vector<Vec3> cable_shape() const;

  const vehicle::Vehicle& vehicle() const;
  const World& world() const;
  const PlantOptions& options() const;
  /// The MuJoCo model as XML text, for looking at it elsewhere.
  const std::string& mjcf() const;

 private:
  struct Impl;
  explicit MujocoPlant(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace omniflight::proof
