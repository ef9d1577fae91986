#include "omniflight_planning/mission.hpp"

#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"

namespace omniflight::planning {
namespace {

namespace fs = std::filesystem;
constexpr double kFarthest = 1000.0;  // m

/// attitude: {rpy_deg: [r, p, y]}, {quaternion: [w, x, y, z]} or {heading_deg: y}; `otherwise` when the key
/// is absent.
Quat read_attitude(files::YamlReader& item, const Quat& otherwise, std::optional<double>& heading) {
  auto attitude = item.optional_child("attitude");
  if (!attitude) return otherwise;
  heading.reset();
  if (attitude->has("rpy_deg") + attitude->has("quaternion") + attitude->has("heading_deg") != 1) {
    attitude->error(
        "an attitude needs one of rpy_deg, quaternion and heading_deg",
        "Write attitude: {rpy_deg: [roll, pitch, yaw]}, {quaternion: [w, x, y, z]} or {heading_deg: yaw}");
    return otherwise;
  }
  if (attitude->has("heading_deg")) {
    heading = to_radians(attitude->number("heading_deg", files::between(-360.0, 360.0, "deg")));
    return from_roll_pitch_yaw(Vec3(0, 0, *heading));
  }
  if (attitude->has("rpy_deg")) {
    const Vec3 rpy = attitude->vec3("rpy_deg", files::between(-360.0, 360.0, "deg"));
    return from_roll_pitch_yaw(Vec3(to_radians(rpy.x()), to_radians(rpy.y()), to_radians(rpy.z())));
  }
  const auto q = attitude->numbers("quaternion", 4, files::between(-1.0 - 1e-6, 1.0 + 1e-6));
  if (q.size() != 4) return otherwise;
  const Quat out(q[0], q[1], q[2], q[3]);
  if (std::abs(out.norm() - 1.0) > 1e-3) {
    attitude->error_at("quaternion", "the quaternion (w, x, y, z) has norm " + std::to_string(out.norm()),
                       "Give a unit quaternion");
    return otherwise;
  }
  return out.normalized();
}

Waypoint read_waypoint(files::YamlReader item, const Waypoint* previous, std::size_t number) {
  Waypoint w;
  w.where = item.where();
  w.name = item.string("name", previous ? "waypoint " + std::to_string(number) : "start");
  const auto place = files::between(-kFarthest, kFarthest, "m");
  if (previous && item.has("by")) {
    if (item.has("position")) item.error("a waypoint has either position or by (relative to the one before)");
    w.pose.p_WB = previous->pose.p_WB + item.vec3("by", place);
  } else if (previous && !item.has("position")) {
    w.pose.p_WB = previous->pose.p_WB;
    if (!item.has("attitude") && !item.has("hold_s") && !item.has("alpha_deg"))
      item.error("the waypoint changes nothing", "Give it a position, by, attitude, alpha_deg or hold_s");
  } else {
    w.pose.p_WB = item.vec3("position", place);
  }
  if (previous) w.heading = previous->heading;
  w.pose.q_WB = read_attitude(item, previous ? previous->pose.q_WB : Quat::Identity(), w.heading);
  w.hold_s = item.number("hold_s", files::between(0.0, 600.0, "s"), 0.0);
  if (previous) {
    w.stop = item.choice<bool>("mode", {{"must_stop", true}, {"via", false}}, true);
    if (!w.stop && w.hold_s > 0.0)
      item.error_at("hold_s", "a via point cannot be held", "Use mode: must_stop");
    if (item.has("alpha_deg"))
      w.alpha = to_radians(item.number("alpha_deg", files::between(-180.0, 180.0, "deg")));
    if (!w.stop && w.alpha)
      item.error_at("alpha_deg", "a via point has no tilt of its own",
                    "Use mode: must_stop, or give the tilt to the stop after it with tilt: in_flight");
    w.tilt_in_flight = item.choice<bool>("tilt", {{"at_rest", false}, {"in_flight", true}}, false);
    if (w.tilt_in_flight && !w.alpha)
      item.error_at("tilt", "the tilt has nowhere to move to", "Give alpha_deg beside it");
  }
  return w;
}

void read_limits(files::YamlReader root, MotionLimits& limits) {
  auto group = root.optional_child("limits");
  if (!group) return;
  limits.speed = group->number("speed_mps", files::between(1e-3, 50.0, "m/s"), limits.speed);
  limits.acceleration =
      group->number("acceleration_mps2", files::between(1e-3, 100.0, "m/s2"), limits.acceleration);
  limits.rate =
      to_radians(group->number("rate_dps", files::between(0.1, 2000.0, "deg/s"), to_degrees(limits.rate)));
  limits.angular_acceleration =
      to_radians(group->number("angular_acceleration_dps2", files::between(0.1, 1e5, "deg/s2"),
                               to_degrees(limits.angular_acceleration)));
  limits.lean =
      to_radians(group->number("lean_deg", files::between(0.1, 85.0, "deg"), to_degrees(limits.lean)));
  limits.rotor_headroom = group->number("rotor_headroom", files::between(0.0, 0.95), limits.rotor_headroom);
}

void read_tracking(files::YamlReader& root, Mission& m) {
  auto group = root.optional_child("tracking");
  if (!group) return;
  if (group->has("position_m"))
    m.tracking_position = group->number("position_m", files::between(1e-3, 5, "m"));
  if (group->has("attitude_deg"))
    m.tracking_attitude = to_radians(group->number("attitude_deg", files::between(0.1, 180, "deg")));
  m.tracking_in_margin = group->boolean("in_margin", false);
  if (group->has("gust_N") != group->has("compliance_m_per_N"))
    group->error("a gust needs both gust_N and compliance_m_per_N", "Write both, or none");
  if (group->has("gust_N") && group->has("compliance_m_per_N"))
    m.gust = Gust{.force = group->number("gust_N", files::between(0, 1e3, "N")),
                  .compliance = group->number("compliance_m_per_N", files::between(0, 10, "m/N"))};
}

std::optional<Tether> read_tether(files::YamlReader& root) {
  auto group = root.optional_child("tether");
  if (!group) return {};
  Tether t;
  t.anchor_W = group->vec3("anchor", files::between(-kFarthest, kFarthest, "m"));
  t.attachment_B = group->vec3("attachment", files::between(-10, 10, "m"), Vec3::Zero());
  t.length = group->number("length_m", files::between(1e-2, kFarthest, "m"));
  t.linear_mass = group->number("mass_kg_per_m", files::between(0, 10, "kg/m"), 0.0);
  if (group->has("cone_axis") != group->has("cone_deg"))
    group->error("a cone needs both cone_axis and cone_deg", "Write both, or none");
  if (group->has("cone_axis") && group->has("cone_deg")) {
    const Vec3 axis = group->vec3("cone_axis", files::between(-10, 10));
    if (axis.norm() < 1e-3) group->error_at("cone_axis", "has no direction", "Give an axis of the body");
    t.cone_axis_B = axis.normalized();
    t.cone = to_radians(group->number("cone_deg", files::between(1, 180, "deg")));
  }
  if (group->has("twist_deg"))
    t.twist = to_radians(group->number("twist_deg", files::between(1, 1e5, "deg")));
  return t;
}

std::optional<Payload> read_payload(files::YamlReader& root) {
  auto group = root.optional_child("payload");
  if (!group) return {};
  return Payload{.mass = group->number("mass_kg", files::between(1e-6, 1e3, "kg")),
                 .p_B = group->vec3("position", files::between(-10, 10, "m"), Vec3::Zero())};
}

void read_zones(files::YamlReader& root, Zones& zones) {
  constexpr std::size_t kMostZones = 100;
  zones.unknown = root.choice<UnknownSpace>(
      "unknown", {{"occupied", UnknownSpace::occupied}, {"free", UnknownSpace::free}}, zones.unknown);
  for (auto& item : root.children("keep_out", 0, kMostZones)) zones.keep_out.push_back(read_primitive(item));
  auto box = root.optional_child("keep_in");
  if (!box) return;
  const auto place = files::between(-kFarthest, kFarthest, "m");
  zones.keep_in = {box->vec3("min", place), box->vec3("max", place)};
  if (root.ok() && ((*zones.keep_in)[1] - (*zones.keep_in)[0]).minCoeff() <= 0.0)
    box->error("the box from min to max has no inside", "Give lower corner and upper corner [m]");
}

/// That the box to be kept in holds every waypoint.
void check_keep_in(files::YamlReader& root, const Mission& m) {
  if (!m.zones.keep_in) return;
  const auto& [low, high] = *m.zones.keep_in;
  for (const Waypoint& w : m.waypoints)
    if ((w.pose.p_WB - low).minCoeff() < 0.0 || (high - w.pose.p_WB).minCoeff() < 0.0)
      root.error_at("keep_in", "the box does not hold '" + w.name + "'", "Move it, or widen the box");
}

/// A path beside the mission, an absolute one, or a name under configs/test_beds.
Result<fs::path> find_test_bed(const std::string& value, const fs::path& mission, const std::string& where) {
  std::vector<fs::path> folders{mission.parent_path() / "../test_beds"};
  if (const auto configs = files::config_dir()) folders.push_back(*configs / "test_beds");
  std::vector<fs::path> places{mission.parent_path() / value};
  constexpr const char* kKinds[] = {".bt", ".ot", ".stl", ".obj", ".ply", ".dae"};
  for (const fs::path& folder : folders)
    for (const char* kind : kKinds) places.push_back(folder / (value + kind));
  if (places[0].extension() == ".yaml") {  // the description beside a map
    const fs::path described = places[0];
    places.clear();
    for (const char* kind : kKinds) places.push_back(fs::path(described).replace_extension(kind));
  }
  for (const fs::path& place : places) {
    std::error_code ignored;
    if (fs::is_regular_file(place, ignored)) return fs::weakly_canonical(place, ignored);
  }
  return bad_input("there is no test bed map " + files::shown(value), where,
                   "Give a .bt or .ot file, a mesh (.stl, .obj, .ply, .dae) or a name under "
                   "configs/test_beds; omniflight_make_test_bed makes a map from a YAML or a mesh");
}

Result<fs::path> find_mission(const std::string& spec) {
  std::error_code ignored;
  if (fs::is_regular_file(spec, ignored)) return fs::path(spec);
  const auto configs = files::config_dir();
  if (configs && fs::is_regular_file(*configs / "missions" / (spec + ".yaml"), ignored))
    return *configs / "missions" / (spec + ".yaml");
  std::string known;
  if (configs)
    for (const auto& entry : fs::directory_iterator(*configs / "missions", ignored))
      known += (known.empty() ? "" : ", ") + entry.path().stem().string();
  return bad_input("there is no mission " + files::shown(spec), "",
                   "Give a path or one of: " + (known.empty() ? std::string("(none found)") : known));
}

}  // namespace

Result<Mission> load_mission(const std::string& spec) {
  const auto path = find_mission(spec);
  if (!path) return Failure(path.error());
  auto root = files::YamlReader::load(*path);
  if (!root) return Failure(root.error());
  Mission m;
  m.file = path->string();
  if (const std::string schema = root->string("schema"); root->ok() && schema != "omniflight.mission/1")
    root->error_at("schema", "schema is " + files::shown(schema), "Write omniflight.mission/1");
  m.name = root->string("name");
  root->string("notes", "");
  m.vehicle = root->string("vehicle");
  const std::string test_bed = root->string("test_bed");
  if (root->string("alpha_deg") != "search")
    m.alpha = to_radians(root->number("alpha_deg", files::between(-180.0, 180.0, "deg")));
  m.clearance = root->number("clearance_m", files::between(0.0, 5.0, "m"), m.clearance);
  m.seed = static_cast<std::uint64_t>(root->integer("seed", 0, 1'000'000'000, 1));
  m.budget_s = 1e-3 * root->number("budget_ms", files::between(1.0, 600e3, "ms"), 1e3 * m.budget_s);
  m.anytime = root->choice<bool>("search", {{"first", false}, {"anytime", true}}, false);
  read_limits(*root, m.limits);
  m.timing =
      root->choice<Timing>("timing", {{"minimum_jerk", Timing::minimum_jerk}, {"shortest", Timing::shortest}},
                           Timing::minimum_jerk);
  m.objective = root->choice<Objective>(
      "objective",
      {{"time", Objective::time}, {"energy", Objective::energy}, {"clearance", Objective::clearance}},
      Objective::time);
  read_tracking(*root, m);
  read_zones(*root, m.zones);
  m.tether = read_tether(*root);
  m.payload = read_payload(*root);
  m.waypoints.push_back(read_waypoint(root->child("start"), nullptr, 0));
  for (auto& item : root->children("waypoints", 1, 1000)) {
    const Waypoint previous = m.waypoints.back();
    m.waypoints.push_back(read_waypoint(item, &previous, m.waypoints.size()));
  }
  if (root->ok() && !m.waypoints.back().stop)
    root->error("the last waypoint is a via point", "End with mode: must_stop");
  if (root->ok()) check_keep_in(*root, m);
  if (auto ok = root->finish(); !ok) return Failure(ok.error());
  const auto map = find_test_bed(test_bed, fs::absolute(*path), m.file + ": test_bed");
  if (!map) return Failure(map.error());
  m.test_bed = *map;
  auto yaml = m.test_bed;
  yaml.replace_extension(".yaml");
  std::error_code ignored;
  // a mission beside its map may have the map's name
  if (fs::is_regular_file(yaml, ignored) && !fs::equivalent(yaml, *path, ignored)) m.description = yaml;
  auto hash = files::sha256_file(*path);
  if (!hash) return Failure(hash.error());
  m.sha256 = *hash;
  return m;
}

}  // namespace omniflight::planning
