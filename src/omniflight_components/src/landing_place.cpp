#include "landing_place.hpp"

#include <fmt/format.h>

#include <cmath>

#include "conversions.hpp"

namespace omniflight::components {

Result<std::optional<MapBelow>> read_map_below(bus::Parameters& p) {
  const std::string map = p.text("map", ""), name = p.text("vehicle", "");
  const std::string overrides = p.text("vehicle_set", "");
  if (map.empty()) return std::optional<MapBelow>();
  if (name.empty())
    return bad_input("a map says where a descent ends only for a vehicle", "controller.vehicle",
                     "Give its name or file, or no controller.map");
  auto surface = planning::SurfaceBelow::load(map);
  if (!surface) return Failure(surface.error());
  auto vehicle = vehicle::load_vehicle(name, split(overrides));
  if (!vehicle) return Failure(vehicle.error());
  return std::optional(MapBelow{std::move(*surface), std::move(*vehicle)});
}

void LandingPlace::begin(const RigidState& estimate, double alpha) {
  if (below_) spheres_ = planning::cover_with_spheres(below_->vehicle, std::isfinite(alpha) ? alpha : 0.0);
  look(estimate);
}

void LandingPlace::look(const RigidState& estimate) {
  if (below_) contact_ = below_->surface.landing({estimate.p_WB, estimate.q_WB}, spheres_);
}

bool LandingPlace::landed(const Vec3& p_WB) const {
  return p_WB.z() <= config_.ground_z + config_.touchdown ||
         (contact_ && p_WB.z() <= contact_->p_z + config_.contact);
}

double LandingPlace::lowest() const { return on_map() ? contact_->p_z : config_.ground_z; }

std::string LandingPlace::words() const {
  if (!on_map()) return fmt::format("ends at the ground of the test bed, {:.2f} m", config_.ground_z);
  return fmt::format("ends on what the map has at {:.2f} m, the body origin at {:.2f} m", contact_->surface_z,
                     contact_->p_z);
}

}  // namespace omniflight::components
