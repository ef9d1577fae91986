#include "omniflight_planning/payload.hpp"

namespace omniflight::planning {
namespace {

Mat3 point_inertia(double mass, const Vec3& p) {
  return mass * (p.squaredNorm() * Mat3::Identity() - p * p.transpose());
}

}  // namespace

vehicle::Vehicle carrying(const vehicle::Vehicle& vehicle, const Payload& payload) {
  vehicle::Vehicle out = vehicle;
  if (payload.mass <= 0.0) return out;
  out.mass += payload.mass;
  out.center_of_mass = (vehicle.mass * vehicle.center_of_mass + payload.mass * payload.p_B) / out.mass;
  out.inertia += point_inertia(vehicle.mass, vehicle.center_of_mass - out.center_of_mass) +
                 point_inertia(payload.mass, payload.p_B - out.center_of_mass);
  return out;
}

}  // namespace omniflight::planning
