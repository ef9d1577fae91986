// The memory of eight vehicles side by side, and what is common to all of them. Every array ends in [kLanes],
// so that a vector of any width up to eight reads neighbours.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "omniflight_physics/effect.hpp"
#include "omniflight_simulation/plant.hpp"

namespace omniflight::simulation::lanes {

inline constexpr int kLanes = 8;
inline constexpr int kRotors = vehicle::kMaxRotors;
using Lane = double[kLanes];

/// How many rotors turn both ways.
enum class Reverse { none, some, all };

/// What is the same for all vehicles of a batch.
struct Common {
  struct Rotor {
    Vec3 constant, cosine, sine;  ///< thrust axis at tilt a: constant + cosine cos(a) + sine sin(a)
    Vec3 p;                       ///< m
    double square[6] = {};        ///< m^2, |p|^2 I - p p^T: xx yy zz xy xz yz
    double thrust_coefficient = 0, spin = 1, drag_ratio = 0, radius = 0;
    bool bidirectional = false;
  };
  int rotors = 0;
  Rotor rotor[kRotors];
  double step = 0.001, gravity = 0, air_density = 0, floor_z = 0;
  double tilt_rate = 0;
  // groups of effects that some vehicle of the batch has; where a vehicle has them not they are nothing
  // exactly, to the bit: they add zeros
  bool ideal_motors = false, products = false;
  Reverse reverse = Reverse::none;
  bool world_force = false, drag = false, wind = false, cable = false, blades = false, flapping = false,
       ground = false, rotor_momentum = false;
};

struct alignas(64) Block {
  // state
  Lane p[3], v[3], q[4], w[3];  ///< m, m/s (world), quaternion x y z w, rad/s (body)
  Lane lost;                    ///< 0 or 1
  Lane alpha, alpha_command, mapped_alpha;
  Lane end_wrench[6];  ///< N, Nm, of the rotors at the end of the last step
  // motors: half a step and a step later the speed is speed + share * (command - speed), exactly
  Lane share_middle[kRotors], share_end[kRotors];
  Lane speed[kRotors];   ///< rad/s
  Lane target[kRotors];  ///< rad/s, as commanded
  // wrench per squared speed, and unit thrust axis, at mapped_alpha
  Lane map[kRotors][6], axis[kRotors][3], moment[kRotors][3];  ///< moment: p x axis
  /// By rotor drag and axial inflow, a symmetric 6x6 matrix: at one end of a step, in its middle, at its
  /// other end. Ends take turns.
  Lane damping[3][21];
  Lane command[kRotors];  ///< rad/s, as it reaches the motor in this step; only when it `relays`
  Lane inverse_tau[kRotors];
  Lane share_of_way;   ///< share_middle / share_end of the first rotor
  Lane bend[kRotors];  ///< the same of this rotor, less that of the first
  // the same map by tilt a, without efficiency: [0] + [1] cos(a) + [2] sin(a)
  Lane map_by_tilt[3][kRotors][6];
  // mass properties
  Lane mass, weight_mass, inverse_mass;  ///< kg nominal; kg with payload; 1/kg
  Lane inertia[6], inverse_inertia[6];   ///< xx yy zz xy xz yz about the body origin
  Lane inertia_gap[3];                   ///< zz - yy, xx - zz, yy - xx
  Lane com[3];                           ///< m
  Lane inverse_generalised[36];          ///< of the 6x6 mass matrix, only when coupled
  // effects
  Lane thrust_gain, thrust_gain_per_alpha, payload;
  Lane pull[3], stiffness, anchor[2], area, wind[2], wind_area;
  Lane cable_density, cable_start, cable_length;
  Lane drag_in_plane, drag_axial, flapping, ground_strength, rotor_inertia;
  // answers of the last evaluation
  Lane specific_force[3], angular_acceleration[3];
  bool ideal[kRotors][kLanes];  ///< a motor without lag
  /// The centre of mass is off the origin: translation and rotation are solved together. All vehicles of a
  /// block agree in this, because the other way rounds differently.
  bool coupled = false;
  bool lags_differ = false;  ///< between rotors: else those of the first stand for all
  int damping_begins = 0;    ///< which of `damping` is of the beginning: 0 or 2
  bool relays = false;       ///< `command` is looked at; else it is the target
  bool any_lost = false;     ///< a vehicle is lost
  bool end_known = false;    ///< end_wrench is there, and nothing has changed since
  bool answered = false;     ///< specific_force and angular_acceleration are of the present state
  int used = 0;              ///< vehicles
};

/// Makes a block ready that has all its vehicles: places that nobody uses hold a copy of the first, so that
/// no lane computes with what is no number.
void close(const Common& common, Block& block);

/// True when lanes know the effect (effects on sensors are none of the plant's business).
bool knows(const physics::Effect& effect);
/// True when a lane can hold two of it.
bool adds_up(const physics::Effect& effect);
/// True when it moves the centre of mass off the origin, so that its vehicle needs a block that is `coupled`.
bool moves_the_mass(const physics::Effect& effect);
/// Fills a vehicle's place. The model's effects are all known.
void put_vehicle(const vehicle::Vehicle& vehicle, const physics::Model& model, const PlantConfig& config,
                 const physics::Actuation& actuation, Common& common, Block& block, int lane);

/// Drive trains of a block's vehicles that have more to them than a lag; null for the others.
struct Trains {
  std::unique_ptr<physics::Actuators> of[kLanes];
  bool any = false;
};

/// Integrates a block; with no steps it answers the accelerations at the present state instead. Dispatches to
/// the best instructions.
void run(const Common& common, Block& block, const Trains& trains, int steps, bool held);
std::string instruction_set();

}  // namespace omniflight::simulation::lanes
