#include <cmath>

#include "omniflight_files/files.hpp"
#include "omniflight_planning/plan.hpp"
#include "text.hpp"

namespace omniflight::planning {

Status check_match(const Certificate& c, const Mission& mission, const vehicle::Vehicle& vehicle) {
  std::string differs;
  const auto add = [&](const std::string& what) { differs += (differs.empty() ? "" : "; ") + what; };
  if (c.mission_sha256 != mission.sha256)
    add(c.mission == mission.name ? "the mission " + mission.file + " has changed since"
                                  : "it is a plan of the mission " + files::shown(c.mission) + ", not of " +
                                        files::shown(mission.name));
  if (std::abs(vehicle.mass - c.vehicle_mass) > 1e-9)
    add(text("its vehicle %s has %.4g kg, the one that shall fly, %s, %.4g kg",
             files::shown(c.vehicle).c_str(), c.vehicle_mass, files::shown(vehicle.name).c_str(),
             vehicle.mass));
  else if (c.vehicle_sha256 != vehicle.sha256)
    add(c.vehicle == vehicle.name
            ? "the vehicle " + files::shown(vehicle.name) + " differs (its file or --set)"
            : "its vehicle is " + files::shown(c.vehicle) + ", not " + files::shown(vehicle.name));
  if (c.from) add("it begins in flight, and this flight begins at rest");
  const auto map = files::sha256_file(mission.test_bed);
  if (!map) return Failure(map.error());
  if (c.map_sha256 != *map) add("its map is not the one of the test bed " + mission.test_bed.string());
  if (differs.empty()) return {};
  return bad_input(
      "is not the plan of this flight: " + differs, "--plan",
      "Plan again with the same --vehicle and --set (omniflight plan MISSION), or leave --plan out");
}

std::string explain(const Result<Plan>& plan) {
  if (!plan) return "There is no plan. " + plan.error().text() + ".\n";
  const Certificate& c = plan->certificate;
  std::string out =
      text("Mission '%s' with '%s' (%.3f kg), alpha %.1f deg%s, %.2f s, seed %llu: %s.\n", c.mission.c_str(),
           c.vehicle.c_str(), c.vehicle_mass, to_degrees(c.alpha), c.alpha_searched ? " (searched)" : "",
           c.duration, static_cast<unsigned long long>(c.seed), c.verdict.c_str());
  if (c.alpha_highest > c.alpha_lowest)
    out += text("The tilt moves between %.1f and %.1f deg, %s, at up to %.1f deg/s.\n",
                to_degrees(c.alpha_lowest), to_degrees(c.alpha_highest),
                c.tilts_in_flight ? "in flight" : "at rest", to_degrees(c.peak_tilt_rate));
  if (c.from)
    out += text(
        "It begins in flight at (%.2f, %.2f, %.2f) m with %.2f m/s, comes to rest, and goes on from there.\n",
        c.from->reference.p_WB.x(), c.from->reference.p_WB.y(), c.from->reference.p_WB.z(),
        c.from->reference.v_WB_W.norm());
  out += text("It keeps at least %.3f m from every occupied voxel (least on the knots %.3f m at %.2f s).\n",
              c.clearance_asked, c.min_clearance, c.min_clearance_at);
  if (c.tube.in_margin)
    out +=
        text("It does so also when it is off its reference by %.3f m and %.1f deg: a margin of %.3f m%s.\n",
             c.tube.position, to_degrees(c.tube.attitude), c.tube_margin,
             c.tube.file.empty() ? "" : (", measured in " + c.tube.file).c_str());
  out += text("At most %.2f m/s, %.2f m/s2, %.1f deg/s; the rotors need %.0f %% of their range at %.2f s.\n",
              c.peak.speed, c.peak.acceleration, to_degrees(c.peak.rate), 100.0 * c.peak.rotor_load,
              c.peak.rotor_load_at);
  if (c.peak.thrust_rate.rotor > 0)
    out += text("Rotor %d needs %.0f %% of the rate of thrust that its lag allows, at %.2f s.\n",
                c.peak.thrust_rate.rotor, 100.0 * c.peak.thrust_rate.share, c.peak.thrust_rate_at);
  if (c.tether)
    out += text(
        "The tether of %.2f m is used to %.2f m and twisted by %.1f deg at most; the rotors can carry "
        "all of its %.3f kg.\n",
        c.tether->length, c.tether->longest, to_degrees(c.tether->twist), c.tether->mass);
  if (c.payload) out += text("The rotors carry a payload of %.3f kg beside the vehicle.\n", c.payload->mass);
  if (c.leans)
    out +=
        text("The attitude follows from the acceleration: it leans by at most %.1f deg, %.1f are allowed.\n",
             to_degrees(c.peak.lean), to_degrees(c.limits.lean));
  if (!c.reason.empty()) out += "Note: " + c.reason + "\n";
  return out;
}

}  // namespace omniflight::planning
