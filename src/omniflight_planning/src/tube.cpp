#include "omniflight_planning/tube.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "omniflight_files/files.hpp"
#include "omniflight_planning/mission.hpp"

namespace omniflight::planning {
namespace {

using TubeJson = nlohmann::json;
constexpr double kMostPosition = 5.0;   // m
constexpr double kMostAttitude = 90.0;  // deg
constexpr const char* kFlyFirst = "Give flight.json of omniflight fly, or compare.json of omniflight compare";

/// The larger of what was measured and what was true, where both are told; not finite where one is no number.
double worst(const TubeJson& metrics, const char* key) {
  double out = 0.0;
  bool any = false;
  for (const char* whose : {"measured", "true"}) {
    const auto part = metrics.find(whose);
    if (part == metrics.end()) continue;
    if (!part->is_object()) return NAN;
    const auto value = part->find(key);
    if (value == part->end() || !value->is_number() || !(value->get<double>() >= 0.0)) return NAN;
    out = std::max(out, value->get<double>());
    any = true;
  }
  return any ? out : NAN;
}

}  // namespace

Tube tube_of(const Mission& mission, const vehicle::Vehicle& vehicle) {
  constexpr double kLeast = 0.02;  // m, what laboratory motion capture and control leave of any reference
  const double room = std::max(mission.clearance, kLeast);
  Tube out;
  out.position = mission.tracking_position.value_or(room);
  out.attitude =
      mission.tracking_attitude.value_or(std::min(kPi, room / std::max(kLeast, vehicle.bounding_radius())));
  out.in_margin = mission.tracking_in_margin || mission.gust;
  if (mission.gust) out.position += mission.gust->way();
  return out;
}

Result<Tube> read_tube(const std::filesystem::path& path) {
  const std::string file = path.string();
  const auto bytes = files::read_file(path, 64 * files::kMegabyte);
  if (!bytes) return Failure(bytes.error());
  const TubeJson json = TubeJson::parse(*bytes, nullptr, false);
  const auto refuse = [&](const std::string& why) { return bad_input(why, file, kFlyFirst); };
  if (json.is_discarded() || !json.is_object()) return refuse("is no JSON object");
  const auto text_of = [&](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  const std::string schema = text_of("schema");
  TubeJson metrics = TubeJson::object();
  if (schema == "omniflight.flight/1") {
    const auto complete = json.find("complete");
    if (complete == json.end() || !complete->is_boolean() || !complete->get<bool>())
      return refuse("is of a flight that ended early, which tells no largest error");
    metrics = json.value("metrics", metrics);
  } else if (schema == "omniflight.compare/1") {
    const TubeJson both = json.value("tracking", metrics);
    if (both.is_object()) metrics = both.value("real", metrics);
  } else {
    return refuse("its schema is " + files::shown(schema) +
                  ", not omniflight.flight/1 or omniflight.compare/1");
  }
  if (!metrics.is_object()) return refuse("its metrics are no object");
  const double position = worst(metrics, "worst_position_m"), degrees = worst(metrics, "worst_attitude_deg");
  if (!(position <= kMostPosition)) return refuse("tells no largest position error from 0 to 5 m");
  if (!(degrees <= kMostAttitude)) return refuse("tells no largest attitude error from 0 to 90 deg");
  std::error_code ignored;
  Tube out;
  out.position = position;
  out.attitude = to_radians(degrees);
  out.in_margin = true;
  out.file = std::filesystem::weakly_canonical(path, ignored).string();
  out.sha256 = files::sha256_hex(*bytes);
  return out;
}

Result<Tube> tube_for(const Mission& mission, const vehicle::Vehicle& vehicle,
                      const std::filesystem::path& file) {
  if (!file.empty()) {
    auto measured = read_tube(file);
    if (measured && mission.gust) measured->position += mission.gust->way();
    return measured;
  }
  Tube out = tube_of(mission, vehicle);
  if (out.in_margin && !(mission.tracking_position && mission.tracking_attitude))
    return bad_input("a margin for tracking errors needs tracking.position_m and tracking.attitude_deg",
                     mission.file, "Write both, or plan with --tube flight.json of a flight");
  return out;
}

}  // namespace omniflight::planning
