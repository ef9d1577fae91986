// Many vehicles at once, one in each lane of the processor's vector unit: for campaigns and fits.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "omniflight_simulation/plant.hpp"

namespace omniflight::simulation {

/// Whether an effect id is integrated in lanes; effects on sensors are none of the plant's business and
/// count.
bool flies_in_lanes(const physics::Effect& effect);
/// The ids of the library that are integrated in lanes, in the order of the catalogue.
std::vector<std::string> lane_effects();
/// The instruction set the lanes run on here ("AVX3", "AVX2", "SSE4", ...), chosen when first used.
std::string lane_instruction_set();

struct BatchConfig {
  PlantConfig plant;                      ///< step, environment, initial state and tilt of every vehicle
  std::vector<RigidState> initial = {};   ///< one a vehicle instead of plant.initial; or empty
  std::vector<std::uint64_t> seeds = {};  ///< one a vehicle instead of plant.seed; or empty
  /// What becomes of a vehicle whose model has an effect that lanes do not know, or whose integrator they do
  /// not know: it flies as a Plant of its own beside the lanes, or the batch is refused naming the id.
  enum class Unsupported { plant, refuse } unsupported = Unsupported::plant;
};

/// The same vehicle many times, each with its own effects, state and commands. The results are those of Plant
/// to rounding (1e-12 relative over a second of tumbling), independent of the number of vehicles, and the
/// same bits on every processor. Nothing is allocated after construction.
class Batch {
 public:
  /// One vehicle per model. Refuses what Plant::create refuses, naming the vehicle's number.
  static Result<Batch> create(const vehicle::Vehicle& vehicle, std::span<const physics::Model> models,
                              const BatchConfig& config);
  Batch(Batch&&) noexcept;
  Batch& operator=(Batch&&) noexcept;
  ~Batch();

  std::size_t size() const;
  std::size_t in_lanes() const;  ///< how many fly in lanes; the others are Plants

  /// As Plant::set_command, for vehicle i.
  bool set_command(std::size_t i, std::span<const double> rotor_speed, double alpha);
  /// So many steps of config.plant.step with the present commands. A vehicle that leaves every reasonable
  /// range (|p| <= 1000 m, |w| <= 1000 rad/s) is lost: it stays where it was last within it, and the others
  /// fly on. Returns how many are not lost.
  std::size_t step(int steps = 1, bool held = false);

  /// Everything as it was after create(), for the next rollout of a fit.
  void reset();

  double time() const;  ///< s
  bool lost(std::size_t i) const;
  RigidState body(std::size_t i) const;
  double rotor_speed(std::size_t i, std::size_t rotor) const;  ///< rad/s, signed
  double alpha(std::size_t i) const;                           ///< rad
  /// Specific force [m/s^2, body] and angular acceleration [rad/s^2, body] after the last step.
  Vec3 specific_force(std::size_t i) const;
  Vec3 angular_acceleration(std::size_t i) const;

 private:
  struct Impl;
  explicit Batch(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace omniflight::simulation
