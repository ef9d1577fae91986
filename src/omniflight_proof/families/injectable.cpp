// What can be injected into a real flight: forces along body z and torques, by laws and otherwise.
#include <cmath>

#include "injection.hpp"

namespace omniflight::proof {
namespace {

using Eigen::Vector4d;
using Parameters = std::vector<TrueParameter>;

double weight(const RealFlight& f) { return f.vehicle().mass * kGravity; }
double arm(const RealFlight& f) { return f.vehicle().rotors[0].p_BR.norm(); }
double height(const RealFlight& f, std::size_t i) { return f.position(i).z() - f.floor(); }
Vector4d along_z(double force) { return {force, 0, 0, 0}; }
Vector4d torque(const Vec3& t) { return {0, t.x(), t.y(), t.z()}; }
double yaw(const RealFlight& f, std::size_t i) {
  const Mat3 R = f.R(i);
  return std::atan2(R(1, 0), R(0, 0));
}
/// Force along z and torques of a share of one rotor.
Vector4d of_rotor(const RealFlight& f, std::size_t i, int k, double share) {
  const vehicle::Rotor& r = f.vehicle().rotors[static_cast<std::size_t>(k)];
  const Vec3 T = share * f.thrust(i)[k] * r.axis_B;
  Vector4d w = torque(r.p_BR.cross(T) + r.spin * r.drag_ratio * T);
  w[0] = T.z();
  return w;
}

/// What a rotor of (1 - a) lacks at the speed at which it gives its old thrust, over that thrust.
double weaker(double a) { return -a / (1 - a); }

void loads(std::vector<Injectable>& out) {
  out.push_back({.id = "payload_mass",
                 .realisation = "more weight and inertia",
                 .typical = 0.05,
                 .largest = 0.25,
                 .wrench = [](const RealFlight& f, std::size_t i, double a,
                              const Shape&) { return along_z(-a * f.vehicle().mass * f.force(i).z()); },
                 .parameters =
                     [](const RealFlight& f, double a, const Shape&) {
                       return Parameters{{"mass", a * f.vehicle().mass, a * f.vehicle().mass}};
                     }});
  out.push_back({.id = "hung_cable",
                 .realisation = "weight that grows with the height",
                 .typical = 0.05,
                 .largest = 0.25,
                 .wrench = [](const RealFlight& f, std::size_t i, double a,
                              const Shape&) { return along_z(-a * weight(f) * height(f, i) * f.R(i)(2, 2)); },
                 .parameters =
                     [](const RealFlight& f, double a, const Shape&) {
                       return Parameters{{"linear_density", a * f.vehicle().mass, a * f.vehicle().mass}};
                     }});
  out.push_back({.id = "ground_effect",
                 .realisation = "lift near the floor",
                 .smallest = 0.02,
                 .typical = 1,
                 .largest = 8,
                 .wrench = [](const RealFlight& f, std::size_t i, double a, const Shape&) {
                   const double r = f.vehicle().rotors[0].radius, h = std::max(0.5 * r, height(f, i) + r);
                   return along_z(a * f.thrust(i).sum() * std::pow(r / (4 * h), 2));
                 }});
  out.push_back({.id = "com_offset",
                 .realisation = "the mass elsewhere",
                 .typical = 0.02,
                 .largest = 0.2,
                 .wrench =
                     [](const RealFlight& f, std::size_t i, double a, const Shape& k) {
                       return torque(-f.vehicle().mass * a * arm(f) * k.direction(0, true).cross(f.force(i)));
                     },
                 .parameters =
                     [](const RealFlight& f, double a, const Shape& k) {
                       const Vec3 c = a * arm(f) * k.direction(0, true);
                       return Parameters{{"x", c.x(), c.norm()}, {"y", c.y(), c.norm()}};
                     }});
  out.push_back({.id = "inertia_error",
                 .realisation = "larger moments of inertia",
                 .typical = 0.3,
                 .largest = 2,
                 .wrench = [](const RealFlight& f, std::size_t i, double a, const Shape&) {
                   const Mat3 J = a * f.vehicle().inertia;
                   return torque(-(J * f.turning(i) + f.rate(i).cross(J * f.rate(i))));
                 }});
  out.push_back({.id = "cable_torsion",
                 .realisation = "a lead that is twisted",
                 .typical = 0.01,
                 .largest = 0.1,
                 .wrench = [](const RealFlight& f, std::size_t i, double a, const Shape& k) {
                   const double turned = std::remainder(yaw(f, i) - k.between(0, -0.8, 0.8), 2 * kPi);
                   return torque(-a * weight(f) * arm(f) * turned * f.R(i).transpose() * Vec3::UnitZ());
                 }});
}

void rotors(std::vector<Injectable>& out) {
  out.push_back({.id = "thrust_scale",
                 .realisation = "all propellers weaker",
                 .typical = 0.05,
                 .largest = 0.25,
                 .wrench = [](const RealFlight& f, std::size_t i, double a, const Shape&) {
                   Vector4d sum = Vector4d::Zero();
                   for (int k = 0; k < f.vehicle().rotor_count(); ++k) sum += of_rotor(f, i, k, weaker(a));
                   return sum;
                 }});
  out.push_back({.id = "rotor_thrust_scale",
                 .realisation = "one propeller weaker",
                 .typical = 0.05,
                 .largest = 0.4,
                 .wrench = [](const RealFlight& f, std::size_t i, double a, const Shape& k) {
                   return of_rotor(f, i, k.whole(0, 0, f.vehicle().rotor_count() - 1), weaker(a));
                 }});
  out.push_back({.id = "rotor_thrust_scale",
                 .realisation = "one propeller that is worse the faster it turns",
                 .law = false,
                 .typical = 0.05,
                 .largest = 0.4,
                 .wrench = [](const RealFlight& f, std::size_t i, double a, const Shape& k) {
                   const int which = k.whole(0, 0, f.vehicle().rotor_count() - 1);
                   const double mean = weight(f) / f.vehicle().rotor_count();
                   return of_rotor(f, i, which, -a * std::clamp(f.thrust(i)[which] / mean, 0.0, 2.0));
                 }});
  out.push_back({.id = "drag_torque_scale",
                 .realisation = "propellers of another drag",
                 .typical = 0.2,
                 .largest = 0.8,
                 .wrench = [](const RealFlight& f, std::size_t i, double a, const Shape& k) {
                   double sum = 0;
                   for (int r = 0; r < f.vehicle().rotor_count(); ++r) {
                     const auto& rotor = f.vehicle().rotors[static_cast<std::size_t>(r)];
                     sum += rotor.spin * rotor.drag_ratio * f.thrust(i)[r];
                   }
                   return torque(a * k.sign(0) * sum * Vec3::UnitZ());
                 }});
}

void unknown(std::vector<Injectable>& out) {
  out.push_back({.id = "unknown",
                 .realisation = "force that pulsates",
                 .law = false,
                 .typical = 0.03,
                 .largest = 0.2,
                 .wrench =
                     [](const RealFlight& f, std::size_t i, double a, const Shape& k) {
                       return along_z(a * weight(f) * std::sin(2 * kPi * k.between(0, 0.6, 2.5) * f.time(i)));
                     },
                 .variables = {"time"}});
  out.push_back({.id = "unknown",
                 .realisation = "torque that pulls the nose to a direction",
                 .law = false,
                 .typical = 0.01,
                 .largest = 0.1,
                 .wrench =
                     [](const RealFlight& f, std::size_t i, double a, const Shape& k) {
                       return torque(a * weight(f) * arm(f) *
                                     Vec3::UnitX().cross(Vec3(f.R(i).transpose() * k.direction(0, true))));
                     },
                 .variables = {"attitude"}});
  out.push_back({.id = "unknown",
                 .realisation = "lift in one place of the room",
                 .law = false,
                 .unseen = true,
                 .typical = 0.05,
                 .largest = 0.25,
                 .wrench =
                     [](const RealFlight& f, std::size_t i, double a, const Shape& k) {
                       const Vec3 off =
                           f.position(i) - f.position(static_cast<std::size_t>(
                                               k.between(0, 0.3, 0.7) * static_cast<double>(f.size() - 1)));
                       return along_z(a * weight(f) * std::exp(-0.5 * off.squaredNorm() / 0.04));
                     },
                 .variables = {"position", "height"}});
}

}  // namespace

const std::vector<Injectable>& injectables() {
  static const std::vector<Injectable> all = [] {
    std::vector<Injectable> out;
    loads(out);
    rotors(out);
    unknown(out);
    return out;
  }();
  return all;
}

}  // namespace omniflight::proof
