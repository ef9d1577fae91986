#include "family_vehicle.hpp"

#include <fmt/format.h>

namespace omniflight::proof {
namespace {

using vehicle::Rotor;
using vehicle::Vehicle;

/// Rotors on a regular polygon, alternately turning; inward tilt about the arm by +-cant.
std::vector<Rotor> ring(int count, double arm, double first_angle, double cant, const Rotor& like) {
  std::vector<Rotor> out;
  for (int i = 0; i < count; ++i) {
    Rotor r = like;
    const double angle = first_angle + 2 * kPi * i / count;
    const Vec3 outward(std::cos(angle), std::sin(angle), 0);
    r.p_BR = arm * outward;
    r.spin = i % 2 == 0 ? 1 : -1;
    r.axis_B = exp_rotation((i % 2 == 0 ? cant : -cant) * outward) * Vec3::UnitZ();
    out.push_back(r);
  }
  return out;
}

Mat3 diagonal(double xx, double yy, double zz) { return Vec3(xx, yy, zz).asDiagonal(); }

/// Thrust coefficient for which hovering takes this rotor speed [rad/s].
double coefficient(double mass, int rotors, double hover_speed) {
  return mass * kGravity / rotors / (hover_speed * hover_speed);
}

struct Build {
  double mass, arm, hover_speed, thrust_to_weight, drag_ratio, radius, time_constant, cant;
  int rotors;
  double first_angle;
  Vec3 inertia;  ///< of mass * arm^2
};

Vehicle build(const std::string& name, const Build& b) {
  Vehicle v;
  v.name = name;
  v.mass = b.mass;
  const Vec3 j = b.mass * b.arm * b.arm * b.inertia;
  v.inertia = diagonal(j.x(), j.y(), j.z());
  Rotor like;
  like.thrust_coefficient = coefficient(b.mass, b.rotors, b.hover_speed) / std::cos(b.cant);
  like.max_thrust = b.thrust_to_weight * b.mass * kGravity / b.rotors;
  like.min_thrust = 0.02 * like.max_thrust;
  like.drag_ratio = b.drag_ratio;
  like.radius = b.radius;
  like.time_constant = b.time_constant;
  v.rotors = ring(b.rotors, b.arm, b.first_angle, b.cant, like);
  for (std::size_t i = 0; i < v.rotors.size(); ++i)
    v.rotors[i].board = static_cast<int>(2 * i / v.rotors.size());
  return v;
}

/// OmniMorph: eight reversible rotors on the corners of a cube, tilted together about cube edges.
Vehicle omnimorph(double mass, double time_constant) {
  Vehicle v;
  v.name = "omnimorph";
  v.mass = mass;
  v.inertia = diagonal(0.0215, 0.0215, 0.0295) * (mass / 1.315);
  constexpr double h = 0.125;
  const Vec3 corner[4] = {{h, h, h}, {-h, h, h}, {h, -h, h}, {-h, -h, h}};
  const Vec3 about[4] = {{0, -1, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}};
  for (int i = 0; i < 8; ++i) {
    Rotor r;
    r.p_BR = corner[i % 4];
    if (i > 3) r.p_BR.z() = -h;
    r.tilts = true;
    r.tilt_axis_B = i > 3 ? Vec3(-about[i % 4]) : about[i % 4];
    r.spin = i > 3 ? -1 : 1;
    r.thrust_coefficient = 4.76e-6;
    r.drag_ratio = 0.0165;
    r.bidirectional = true;
    r.min_thrust = 0.15;
    r.max_thrust = 6.25;
    r.radius = 0.1016;
    r.time_constant = time_constant;
    r.board = i > 3 ? 1 : 0;
    v.rotors.push_back(r);
  }
  v.tilt = {vehicle::TiltKind::common, 0, to_radians(60), to_radians(30)};
  return v;
}

}  // namespace

double FamilyVehicle::arm() const {
  double out = 0;
  for (const Rotor& r : nominal.rotors) out = std::max(out, r.p_BR.norm());
  return out;
}

Result<FamilyVehicle> draw_vehicle(const Coordinates& where, BoxRandom& random) {
  FamilyVehicle f;
  const double heavier = random.between(0.92, 1.08), slower = random.between(0.85, 1.15);
  const double spread = random.between(0.9, 1.1);
  if (where.vehicle == "quadrotor_37g") {
    f.nominal = build(where.vehicle, {0.037 * heavier, 0.046, 1560, 3.6, 0.006, 0.0231, 0.034 * slower, 0, 4,
                                      -kPi / 4, spread * Vec3(0.32, 0.36, 0.62)});
    f.reach = 0.7, f.speed = 0.9, f.acceleration = 1.8;
  } else if (where.vehicle == "quadrotor_1200g") {
    f.nominal = build(where.vehicle, {1.2 * heavier, 0.17, 545, 2.5, 0.0155, 0.127, 0.030 * slower, 0, 4,
                                      -kPi / 4, spread * Vec3(0.30, 0.33, 0.55)});
    f.reach = 1.6, f.speed = 2.2, f.acceleration = 2.5;
  } else if (where.vehicle == "hexarotor") {
    f.nominal = build(where.vehicle, {2.5 * heavier, 0.275, 470, 2.2, 0.0165, 0.1397, 0.040 * slower, 0, 6,
                                      kPi / 6, spread * Vec3(0.26, 0.27, 0.47)});
    f.reach = 1.8, f.speed = 2.0, f.acceleration = 2.2;
  } else if (where.vehicle == "hexarotor_tilted") {
    f.nominal = build(where.vehicle,
                      {2.2 * heavier, 0.25, 500, 2.4, 0.016, 0.127, 0.030 * slower,
                       to_radians(random.between(22, 32)), 6, kPi / 6, spread * Vec3(0.25, 0.26, 0.45)});
    f.reach = 1.2, f.speed = 0.9, f.acceleration = 0.7, f.lean = to_radians(5);
    f.fully_actuated = true;
  } else if (where.vehicle == kUnseenVehicle) {
    f.nominal = build(where.vehicle, {3.4 * heavier, 0.32, 430, 2.1, 0.017, 0.1524, 0.045 * slower, 0, 8,
                                      kPi / 8, spread * Vec3(0.27, 0.28, 0.49)});
    f.reach = 2.0, f.speed = 2.2, f.acceleration = 2.0;
  } else {
    f.nominal = omnimorph(1.315 * heavier, 0.015 * slower);
    f.reach = 0.6, f.speed = 0.6, f.acceleration = 0.8, f.lean = to_radians(reverses(where) ? 70 : 15);
    f.fully_actuated = true;
    f.servo_lag = random.between(0.02, 0.12);
    f.servo_backlash = to_radians(random.between(0.1, 0.8));
  }
  if (auto ok = vehicle::validate(f.nominal); !ok) return Failure(ok.error());
  return f;
}

std::string vehicle_yaml(const FamilyVehicle& f, bool servo_told) {
  const Vehicle& v = f.nominal;
  const auto vec = [](const Vec3& x) { return fmt::format("[{:.9g}, {:.9g}, {:.9g}]", x.x(), x.y(), x.z()); };
  const Mat3& J = v.inertia;
  std::string out = fmt::format(
      "schema: omniflight.vehicle/1\nname: {}\nmass: {:.9g}\ninertia: [{:.9g}, {:.9g}, {:.9g}, {:.9g}, "
      "{:.9g}, "
      "{:.9g}]\ncenter_of_mass: {}\nrotors:\n",
      v.name, v.mass, J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2), vec(v.center_of_mass));
  for (const Rotor& r : v.rotors)
    out += fmt::format(
        "  - {{position: {}, axis: {}, tilt_axis: {}, spin: {}, thrust_coefficient: {:.9g}, drag_ratio: "
        "{:.9g}, "
        "bidirectional: {}, min_thrust: {:.9g}, max_thrust: {:.9g}, radius: {:.9g}, time_constant: {:.9g}, "
        "board: "
        "{}}}\n",
        vec(r.p_BR), vec(r.axis_B), r.tilts ? vec(r.tilt_axis_B) : "null", r.spin > 0 ? "+1" : "-1",
        r.thrust_coefficient, r.drag_ratio, r.bidirectional ? "true" : "false", r.min_thrust, r.max_thrust,
        r.radius, r.time_constant, r.board);
  if (v.tilt.kind == vehicle::TiltKind::none) return out + "tilt: {kind: none}\n";
  out += fmt::format("tilt: {{kind: common, min_deg: {:.9g}, max_deg: {:.9g}, rate_deg_s: {:.9g}",
                     to_degrees(v.tilt.min), to_degrees(v.tilt.max), to_degrees(v.tilt.rate));
  if (servo_told)
    out += fmt::format(", time_constant_s: {:.4g}, backlash_deg: {:.4g}", f.servo_lag,
                       to_degrees(f.servo_backlash));
  return out + "}\n";
}

}  // namespace omniflight::proof
