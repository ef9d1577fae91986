// For the tests of single effects: a vehicle, states of it, and an effect's wrench by id.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "omniflight_core/random.hpp"
#include "omniflight_physics/effect.hpp"

namespace omniflight::physics::testing {

/// Eight tilting rotors on the corners of a cube, upper four then lower four, rotor i above i+4: the geometry
/// of OmniMorph.
inline vehicle::Vehicle cube() {
  vehicle::Vehicle v;
  v.name = "cube";
  v.mass = 1.3;
  v.inertia = Vec3(0.012, 0.013, 0.014).asDiagonal();
  const Vec3 tilt_axes[] = {-Vec3::UnitY(), Vec3::UnitX(), -Vec3::UnitX(), Vec3::UnitY()};
  for (int i = 0; i < 8; ++i) {
    vehicle::Rotor r;
    r.p_BR = 0.125 * Vec3(i & 1 ? -1 : 1, i & 2 ? -1 : 1, i & 4 ? -1 : 1);
    r.tilts = true;
    r.tilt_axis_B = (i < 4 ? 1.0 : -1.0) * tilt_axes[i % 4];
    r.spin = i < 4 ? 1 : -1;
    r.thrust_coefficient = 4.76e-6;
    r.drag_ratio = 0.0165;
    r.bidirectional = true;
    r.max_thrust = 6.25;
    r.radius = 0.1016;
    r.board = i / 4;
    v.rotors.push_back(r);
  }
  return v;
}

inline Situation situation(const vehicle::Vehicle& vehicle, const RigidState& body, double alpha,
                           const std::vector<double>& speed) {
  Situation s;
  prepare(vehicle, body, alpha, speed, {}, {}, s);
  return s;
}

/// Hover upright with every rotor at one speed [rad/s].
inline Situation hover(double height, double alpha = 0.0, double speed = 2 * kPi * 120) {
  RigidState body;
  body.p_WB.z() = height;
  return situation(cube(), body, alpha, std::vector<double>(8, speed));
}

/// Three states, then the same three with the body turned by a large angle and moved: a formula that holds at
/// all six is right in every frame. Rotor 4 runs backwards in the third.
inline std::vector<Situation> six_states() {
  std::vector<Situation> out;
  for (const bool moved : {false, true})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      Random rng(seed);
      const auto vec = [&](double s) { return Vec3(s * rng.normal(), s * rng.normal(), s * rng.normal()); };
      RigidState body{Vec3(0, 0, 1.2) + vec(0.2), exp_rotation(vec(0.3)), vec(1.0), vec(1.5)};
      std::vector<double> speed(8);
      for (double& w : speed) w = 600 + 100 * rng.normal();
      if (seed == 3) speed[3] = -500;
      const Vec3 a = vec(2.0), dw = vec(5.0);
      if (moved) {
        body.q_WB = exp_rotation(Vec3(0.9, -1.3, 0.7)) * body.q_WB;
        body.p_WB += Vec3(0.3, -0.4, 0.25);
      }
      out.push_back(situation(cube(), body, 0.15 + 0.2 * static_cast<double>(seed), speed));
      out.back().a_WB_B = a;
      out.back().dw_WB_B = dw;
    }
  return out;
}

/// The wrench of effect `id` with the accelerations of the situation, force [N] then torque [Nm], body axes.
inline Vec6 wrench_of(const char* id, const Situation& s, const std::vector<double>& theta) {
  const Effect* e = find_effect(id);
  EXPECT_NE(e, nullptr) << id;
  EXPECT_EQ(static_cast<int>(theta.size()), e->parameter_count()) << id;
  Wrench w;
  e->add_wrench(s, theta.data(), w);
  return w.at(s);
}

/// Wrench with the accelerations of the situation, from a memory.
inline Vec6 remembered(const char* id, const Situation& s, const std::vector<double>& theta,
                       const std::vector<double>& memory) {
  const Effect* e = find_effect(id);
  EXPECT_EQ(static_cast<int>(memory.size()), e->memory_size().total());
  Wrench w;
  e->add_memory_wrench(s, theta.data(), memory.data(), w);
  return w.at(s);
}

/// Rate of the continuous part of a memory.
inline std::vector<double> rate_of(const char* id, const Situation& s, const std::vector<double>& theta,
                                   const std::vector<double>& memory) {
  const Effect* e = find_effect(id);
  EXPECT_EQ(static_cast<int>(memory.size()), e->memory_size().total());
  std::vector<double> rate(static_cast<std::size_t>(e->memory_size().continuous));
  e->state_rate(s, theta.data(), memory.data(), rate.data());
  return rate;
}

/// Parameter values at which the effect is nothing; shape parameters as given.
inline std::vector<double> neutral_of(const char* id) {
  std::vector<double> out;
  for (const Parameter& p : find_effect(id)->info().parameters) out.push_back(p.neutral);
  return out;
}

/// Force [N] at a hub and free torque [Nm] as a wrench about the body origin.
inline Vec6 at_hub(const RotorSituation& r, const Vec3& force_B, const Vec3& torque_B = Vec3::Zero()) {
  Vec6 w;
  w << force_B, r.p_BR.cross(force_B) + torque_B;
  return w;
}

/// Power [W] of a wrench on the moving body.
inline double power(const Situation& s, const Vec6& w) {
  return w.head<3>().dot(s.v_WB_B) + w.tail<3>().dot(s.body.w_WB_B);
}

/// The situation a short time [s] later, moving as it moves now.
inline Situation later(const Situation& s, double dt) {
  Situation out = s;
  out.body.p_WB += dt * s.body.v_WB_W;
  out.body.q_WB = s.body.q_WB * exp_rotation(dt * s.body.w_WB_B);
  out.R_WB = out.body.q_WB.toRotationMatrix();
  out.v_WB_B = out.R_WB.transpose() * out.body.v_WB_W;
  out.g_B = -out.environment.gravity * out.R_WB.row(2).transpose();
  return out;
}

}  // namespace omniflight::physics::testing
