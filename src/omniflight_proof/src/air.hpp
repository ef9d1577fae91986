// Air around the vehicle: wind with a profile and gusts, slipstreams as jets, rotors by blade elements.
#pragma once

#include <optional>
#include <vector>

#include "motors.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_proof/world.hpp"

namespace omniflight::proof {

/// Wind velocity over height and time.
class WindField {
 public:
  WindField(const std::optional<Wind>& wind, double floor_z, std::uint64_t seed);
  void step(double t, double h);
  Vec3 at(const Vec3& p_W) const;  ///< m/s

 private:
  std::optional<Wind> wind_;
  double floor_z_;
  Random rng_;
  Vec3 shaped_ = Vec3::Zero(), gust_ = Vec3::Zero();
};

/// Slipstream of one rotor: from momentum theory near the disc, a turbulent jet far from it.
struct Jet {
  Vec3 p = Vec3::Zero(), along = -Vec3::UnitZ();  ///< centre of the disc; unit, the way the air goes
  double induced = 0;                             ///< m/s at the disc
  double radius = 0;                              ///< m
  double spread = 0.06;
  /// Velocity [m/s] that it adds at a point; nothing upstream.
  Vec3 at(const Vec3& point) const;
  /// Mean over a disc, by points on two rings and the centre.
  Vec3 over_disc(const Vec3& center, const Vec3& normal, double disc_radius) const;
};

struct RotorLoad {
  double thrust = 0;             ///< N along the axis, signed
  double torque = 0;             ///< N m on the body along the axis, signed as the thrust, without spin sign
  Vec3 in_plane = Vec3::Zero();  ///< N, same axes as the velocity given
  Vec3 hub_moment = Vec3::Zero();  ///< N m
};

/// Blade-element momentum theory of one rotor whose static thrust and torque are known.
class BladeModel {
 public:
  BladeModel(const Blades& blades, double air_density, double radius);
  /// still: load in still air [thrust along axis]; axis: unit thrust axis; v_air_rel: velocity of the hub
  /// against the air [m/s]; image: share of induced velocity that a floor or ceiling takes away.
  RotorLoad load(double speed, double still_thrust, double still_torque, const Vec3& axis,
                 const Vec3& v_air_rel, double image, double h);

 private:
  Blades blades_;
  double density_, radius_;
  double induced_ = -1;  ///< lagged inflow ratio, < 0: none yet
};

}  // namespace omniflight::proof
