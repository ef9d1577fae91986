#include "omniflight_vehicle/vehicle.hpp"

#include <Eigen/Eigenvalues>
#include <sstream>
#include <utility>

namespace omniflight::vehicle {

Vec3 Vehicle::rotor_axis(int i, double alpha) const {
  const Rotor& rotor = rotors[static_cast<std::size_t>(i)];
  if (!rotor.tilts) return rotor.axis_B;
  // Rodrigues, without a quaternion: this runs in hot loops
  const double c = std::cos(alpha), s = std::sin(alpha);
  const Vec3& k = rotor.tilt_axis_B;
  return c * rotor.axis_B + s * k.cross(rotor.axis_B) + (1.0 - c) * k.dot(rotor.axis_B) * k;
}

AllocationMatrix Vehicle::allocation_matrix(double alpha) const {
  AllocationMatrix m(6, rotor_count());
  for (int i = 0; i < rotor_count(); ++i) {
    const Rotor& rotor = rotors[static_cast<std::size_t>(i)];
    const Vec3 n = rotor_axis(i, alpha);
    m.col(i) << n, rotor.p_BR.cross(n) + rotor.spin * rotor.drag_ratio * n;
  }
  return m;
}

RotorVector Vehicle::lower_thrusts() const {
  RotorVector u(rotor_count());
  for (int i = 0; i < rotor_count(); ++i) u[i] = rotors[static_cast<std::size_t>(i)].lower_thrust();
  return u;
}

RotorVector Vehicle::upper_thrusts() const {
  RotorVector u(rotor_count());
  for (int i = 0; i < rotor_count(); ++i) u[i] = rotors[static_cast<std::size_t>(i)].max_thrust;
  return u;
}

double Vehicle::bounding_radius() const {
  double r = 0.0;
  for (const Rotor& rotor : rotors) r = std::max(r, rotor.p_BR.norm() + rotor.radius);
  for (const CollisionShape& shape : collision) {
    double reach = shape.size.x();
    if (shape.kind == CollisionShape::Kind::cylinder)
      reach = std::hypot(shape.size.x(), 0.5 * shape.size.y());
    if (shape.kind == CollisionShape::Kind::box) reach = 0.5 * shape.size.norm();
    r = std::max(r, shape.p_BS.norm() + reach);
  }
  return r;
}

namespace {

/// Field of the tilt and why it is refused; both empty when it may be.
std::pair<std::string, std::string> fault_of(const Tilt& t) {
  const auto number = [](double value) {
    std::ostringstream text;
    text << value;
    return text.str();
  };
  if (!(t.min <= t.max)) return {"tilt", "min_deg exceeds max_deg"};
  const double play = to_degrees(t.backlash), most = to_degrees(kMaxTiltBacklash);
  if (!(t.time_constant >= 0 && t.time_constant <= kMaxTiltTimeConstant))
    return {"tilt.time_constant_s", "is " + number(t.time_constant) + " s, must be at least 0 and at most " +
                                        number(kMaxTiltTimeConstant) + " s"};
  if (!(t.backlash >= 0 && t.backlash <= kMaxTiltBacklash))
    return {"tilt.backlash_deg",
            "is " + number(play) + " deg, must be at least 0 and at most " + number(most) + " deg"};
  if (t.kind == TiltKind::none) {
    if (t.time_constant > 0)
      return {"tilt.time_constant_s",
              "is " + number(t.time_constant) + " s, but no rotor tilts (tilt.kind is none)"};
    if (t.backlash > 0)
      return {"tilt.backlash_deg", "is " + number(play) + " deg, but no rotor tilts (tilt.kind is none)"};
  } else if (t.backlash > 0 && t.backlash >= t.max - t.min) {
    return {"tilt.backlash_deg", "is " + number(play) + " deg, must be less than the range of the tilt, " +
                                     number(to_degrees(t.max - t.min)) + " deg"};
  }
  return {};
}

}  // namespace

Status validate(const Vehicle& v) {
  const auto refuse = [&](const std::string& field, const std::string& why) {
    return bad_input(why, v.file.empty() ? field : v.file + ": " + field, "Correct the field and load again");
  };
  if (!(v.mass > 0) || !std::isfinite(v.mass))
    return refuse("mass", "is " + std::to_string(v.mass) + " kg, must be finite and above 0 kg");
  if (!v.inertia.allFinite() || v.inertia.isZero())
    return refuse("inertia", "is missing or not finite (kg m2)");
  const Vec3 e = Eigen::SelfAdjointEigenSolver<Mat3>(v.inertia).eigenvalues();
  const auto number = [](double value) {
    std::ostringstream text;
    text << value;
    return text.str() + " kg m2";
  };
  if (e[0] <= 0)
    return refuse("inertia", "is not positive definite: its smallest principal moment is " + number(e[0]) +
                                 ", must be above 0 kg m2");
  if (e[0] + e[1] < e[2] * (1.0 - 1e-9))
    return refuse("inertia", "violates the triangle inequality: its largest principal moment is " +
                                 number(e[2]) + ", at most the sum of the other two, " + number(e[0] + e[1]));
  if (!v.center_of_mass.allFinite()) return refuse("center_of_mass", "is not finite (m)");
  if (v.rotors.empty()) return refuse("rotors", "there is none");
  if (v.rotor_count() > kMaxRotors)
    return refuse("rotors", "more than " + std::to_string(kMaxRotors) + " are not supported");
  for (int i = 0; i < v.rotor_count(); ++i) {
    const Rotor& r = v.rotors[static_cast<std::size_t>(i)];
    const std::string field = "rotors[" + std::to_string(i) + "].";
    if (!r.p_BR.allFinite()) return refuse(field + "position", "is not finite (m)");
    if (std::abs(r.axis_B.norm() - 1) > 1e-6) return refuse(field + "axis", "has no direction");
    if (r.tilts && std::abs(r.tilt_axis_B.norm() - 1) > 1e-6)
      return refuse(field + "tilt_axis", "has no direction");
    if (r.spin != 1 && r.spin != -1) return refuse(field + "spin", "must be +1 or -1");
    if (!(r.thrust_coefficient > 0))
      return refuse(field + "thrust_coefficient", "must be positive, N/(rad/s)^2");
    if (!(r.drag_ratio >= 0)) return refuse(field + "drag_ratio", "must not be negative, m");
    if (!(r.max_thrust > 0)) return refuse(field + "max_thrust", "must be positive, N");
    if (!(r.min_thrust >= 0 && r.min_thrust < r.max_thrust))
      return refuse(field + "min_thrust", "must lie in [0, max_thrust), N");
    if (!(r.radius >= 0)) return refuse(field + "radius", "must not be negative, m");
    if (!(r.time_constant >= 0)) return refuse(field + "time_constant", "must not be negative, s");
  }
  if (const auto [field, why] = fault_of(v.tilt); !why.empty()) return refuse(field, why);
  return {};
}

}  // namespace omniflight::vehicle
