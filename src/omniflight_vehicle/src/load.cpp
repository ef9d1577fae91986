#include <algorithm>
#include <cmath>

#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"
#include "omniflight_vehicle/vehicle.hpp"
#include "urdf.hpp"

namespace omniflight::vehicle {
namespace {

namespace fs = std::filesystem;
using files::YamlReader;

Mat3 inertia_from(const std::vector<double>& v) {  // xx yy zz xy xz yz
  Mat3 m;
  m << v[0], v[3], v[4], v[3], v[1], v[5], v[4], v[5], v[2];
  return m;
}

Rotor read_rotor(YamlReader yaml) {
  Rotor r;
  r.p_BR = yaml.vec3("position", files::between(-5, 5, "m"));
  r.axis_B = yaml.vec3("axis", files::any_number(), Vec3::UnitZ());
  if (r.axis_B.norm() > 0) r.axis_B.normalize();
  if (yaml.has("tilt_axis")) {
    r.tilts = true;
    r.tilt_axis_B = yaml.vec3("tilt_axis", files::any_number());
    if (r.tilt_axis_B.norm() > 0) r.tilt_axis_B.normalize();
  } else {
    yaml.ignore("tilt_axis");
  }
  r.spin = static_cast<int>(yaml.integer("spin", -1, 1));
  r.thrust_coefficient = yaml.number("thrust_coefficient", files::positive("N/(rad/s)^2"));
  r.drag_ratio = yaml.number("drag_ratio", files::non_negative("m"));
  r.bidirectional = yaml.boolean("bidirectional", false);
  r.min_thrust = yaml.number("min_thrust", files::non_negative("N"), 0.0);
  r.max_thrust = yaml.number("max_thrust", files::positive("N"));
  r.radius = yaml.number("radius", files::non_negative("m"), 0.0);
  r.time_constant = yaml.number("time_constant", files::between(0, 2, "s"), 0.0);
  r.board = static_cast<int>(yaml.integer("board", 0, 15, 0));
  return r;
}

Tilt read_tilt(YamlReader yaml) {
  Tilt t;
  t.min = to_radians(yaml.number("min_deg", files::between(-180, 180, "deg"), 0.0));
  t.max = to_radians(yaml.number("max_deg", files::between(-180, 180, "deg"), 0.0));
  t.rate = to_radians(yaml.number("rate_deg_s", files::non_negative("deg/s"), 0.0));
  t.time_constant = yaml.number("time_constant_s", files::between(0, kMaxTiltTimeConstant, "s"), 0.0);
  t.backlash =
      to_radians(yaml.number("backlash_deg", files::between(0, to_degrees(kMaxTiltBacklash), "deg"), 0.0));
  t.kind = yaml.choice<TiltKind>(
      "kind", {{"none", TiltKind::none}, {"common", TiltKind::common}, {"individual", TiltKind::individual}});
  return t;
}

/// Keys of `tolerance`, and the kinds of numbers they belong to.
constexpr std::pair<const char*, const char*> kTolerances[] = {
    {"thrust_scale", "thrust_scale"},     {"torque_trim", "torque_trim"}, {"inertia", "inertia"},
    {"center_of_mass", "center_of_mass"}, {"rotor_scale", "rotor_scale"}, {"rotor_axis_rad", "rotor_axis"},
    {"rotor_place", "rotor_place"},       {"drag_torque", "drag_torque"}, {"imu_position", "imu_position"}};

/// "name" or "name@variant" or a path -> path and variant.
Result<std::pair<fs::path, std::string>> locate(const std::string& spec) {
  const auto at = spec.rfind('@');
  const std::string base = at == std::string::npos ? spec : spec.substr(0, at);
  const std::string variant = at == std::string::npos ? "" : spec.substr(at + 1);
  if (std::error_code ec; fs::is_regular_file(base, ec)) return std::pair{fs::path(base), variant};
  if (base.find('/') != std::string::npos)
    return bad_input("there is no such vehicle file", base,
                     "Give a name of `omniflight vehicles` or a path to a YAML");
  const auto configs = files::config_dir();
  if (!configs) return Failure(configs.error());
  const fs::path path = *configs / "vehicles" / base / (base + ".yaml");
  if (std::error_code ec; fs::is_regular_file(path, ec)) return std::pair{path, variant};
  const std::string near = files::nearest_word(base, vehicle_names());
  return bad_input(
      "unknown vehicle '" + base + "'", "vehicle",
      near.empty() ? "`omniflight vehicles` lists the known ones" : "Did you mean '" + near + "'?");
}

}  // namespace

std::vector<std::string> vehicle_names() {
  std::vector<std::string> names;
  const auto configs = files::config_dir();
  if (!configs) return names;
  std::error_code ec;
  for (const auto& entry : fs::directory_iterator(*configs / "vehicles", ec)) {
    const std::string name = entry.path().filename().string();
    if (fs::is_regular_file(entry.path() / (name + ".yaml"), ec)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

Result<Vehicle> load_vehicle(const std::string& spec, const std::vector<std::string>& overrides) {
  const auto place = locate(spec);
  if (!place) return Failure(place.error());
  const auto& [path, variant] = *place;
  auto text = files::read_file(path, files::kMegabyte);
  if (!text) return Failure(text.error());
  auto yaml = YamlReader::parse(*text, path.string());
  if (!yaml) return Failure(yaml.error());

  for (const std::string& item : overrides) {
    const auto equals = item.find('=');
    if (equals == std::string::npos || equals == 0)
      return bad_input("'" + item + "' is not field=value", "--set", "For instance --set mass=0.0397");
    const std::string field = item.substr(0, equals), value = item.substr(equals + 1);
    // rotors.FIELD means every rotor
    if (field.rfind("rotors.", 0) == 0) {
      const std::size_t count = yaml->children("rotors", 1, kMaxRotors).size();
      for (std::size_t i = 0; i < count; ++i)
        if (auto ok = yaml->override_value("rotors[" + std::to_string(i) + "]." + field.substr(7), value);
            !ok)
          return Failure(ok.error());
    } else if (auto ok = yaml->override_value(field, value); !ok) {
      return Failure(ok.error());
    }
  }

  Vehicle v;
  v.file = path.string();
  if (yaml->string("schema") != "omniflight.vehicle/1")
    yaml->error_at("schema", "is not omniflight.vehicle/1", "Convert the file to this schema");
  v.name = yaml->string("name");

  std::string urdf_text;
  if (const std::string urdf = yaml->string("urdf", ""); !urdf.empty()) {
    const fs::path urdf_path = path.parent_path() / urdf;
    auto content = files::read_file(urdf_path, files::kMegabyte);
    if (!content) return Failure(content.error());
    urdf_text = *content;
    auto body = read_urdf(urdf_text, urdf_path.string());
    if (!body) return Failure(body.error());
    v.mass = body->mass;
    v.inertia = body->inertia;
    v.center_of_mass = body->center_of_mass;
    v.collision = body->collision;
  }
  const bool urdf = !urdf_text.empty();
  if (yaml->has("mass") || !urdf) v.mass = yaml->number("mass", files::positive("kg"));
  if (yaml->has("inertia") || !urdf) {
    const auto j = yaml->numbers("inertia", 6, files::any_number("kg m2"));
    if (j.size() == 6) v.inertia = inertia_from(j);
  }
  if (yaml->has("center_of_mass"))
    v.center_of_mass = yaml->vec3("center_of_mass", files::between(-2, 2, "m"));
  for (YamlReader rotor : yaml->children("rotors", 1, kMaxRotors)) v.rotors.push_back(read_rotor(rotor));
  if (auto tilt = yaml->optional_child("tilt")) v.tilt = read_tilt(*tilt);
  if (auto sources = yaml->optional_child("provenance"))
    for (const std::string& key : sources->keys()) {
      if (key == "missing") {
        std::string all;
        for (const auto& s : sources->strings(key, false)) all += (all.empty() ? "" : "; ") + s;
        v.provenance[key] = all;
      } else {
        v.provenance[key] = sources->string(key, "");
      }
    }
  if (auto tolerance = yaml->optional_child("tolerance"))
    for (const auto& [key, kind] : kTolerances)
      if (tolerance->has(key)) v.tolerance[kind] = tolerance->number(key, files::between(0, 1, "1 or rad"));
  // Variants change mass (kg) and nothing else; inertia scales with it unless it is given.
  if (auto variants = yaml->optional_child("variants")) {
    bool found = variant.empty();
    for (const std::string& key : variants->keys()) {
      YamlReader item = variants->child(key);
      const double mass = item.number("mass", files::positive("kg"));
      v.variants.push_back({key, mass, item.string("why", "")});
      if (key != variant) continue;
      found = true;
      v.inertia *= mass / v.mass;
      v.mass = mass;
      v.name += "@" + variant;
    }
    if (!found) {
      const std::string near = files::nearest_word(variant, variants->keys());
      yaml->error_at("variants", "has no '" + variant + "'",
                     near.empty() ? "" : "Did you mean '" + near + "'?");
    }
  } else if (!variant.empty()) {
    yaml->error("has no variants, so no '" + variant + "'", "Leave '@" + variant + "' out");
  }
  if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  std::string hashed = *text + urdf_text + variant;
  for (const auto& o : overrides) hashed += "\n" + o;
  v.sha256 = files::sha256_hex(hashed);
  if (auto ok = validate(v); !ok) return Failure(ok.error());
  return v;
}

}  // namespace omniflight::vehicle
