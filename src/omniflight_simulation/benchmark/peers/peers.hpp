// The peers of the benchmark: rigid-body engines from Debian. Each gets the body of the vehicle and eight
// constant forces a step - no motors, no aerodynamics: they do less than the plant does.
#pragma once

#include "../ratio.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::benchmarks {

inline constexpr double kStep = 0.001;  ///< s
inline constexpr int kLinks = 20;
inline constexpr double kCableLength = 1.0;  ///< m
inline constexpr double kCableMass = 0.1;    ///< kg

/// One force of the eight [N, body axes] that together carry the vehicle, at the hub of a rotor [m, body].
struct Push {
  Vec3 p_B, force_B;
};
std::vector<Push> hover_pushes(const vehicle::Vehicle& vehicle, double carried_mass);

enum class MujocoIntegrator { euler, rk4 };
/// How the eight forces enter, and what else runs.
enum class MujocoOptions {
  rotors,    ///< eight motors at sites, as MuJoCo's own models of multirotors have them
  ordinary,  ///< summed by hand into one external wrench, the cheapest way in
  bare       ///< the same; contacts, constraints and sensors switched off
};
// An engine that was absent at build time answers with the reason.
Contender ode_free_body(const vehicle::Vehicle& vehicle, bool quick);
Contender ode_chain(const vehicle::Vehicle& vehicle, bool quick);
Contender bullet_free_body(const vehicle::Vehicle& vehicle);
Contender bullet_chain(const vehicle::Vehicle& vehicle);
Contender mujoco_free_body(const vehicle::Vehicle& vehicle, MujocoIntegrator integrator,
                           MujocoOptions options);
Contender mujoco_chain(const vehicle::Vehicle& vehicle, MujocoIntegrator integrator);

}  // namespace omniflight::benchmarks
