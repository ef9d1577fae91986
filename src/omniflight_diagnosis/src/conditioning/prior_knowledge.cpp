#include "omniflight_diagnosis/prior_knowledge.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>

#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"

namespace omniflight::diagnosis {
namespace {

using files::YamlReader;

struct Known {
  const char* place;
  double min, max;
  const char* unit;
  bool alone = true;  ///< one number may stand for all axes
};
constexpr Known kKnown[] = {
    {"sensors.accelerometer.noise_rms_mps2", 0, 100, "m/s2"},
    {"sensors.accelerometer.bias_mps2", -50, 50, "m/s2"},
    {"sensors.accelerometer.scale", 0, 0.5, "1"},
    {"sensors.accelerometer.misalignment_rad", 0, 0.5, "rad"},
    {"sensors.imu.position_m", -10, 10, "m", false},
    {"sensors.gyro.noise_rms_radps", 0, 100, "rad/s"},
    {"sensors.gyro.bias_radps", -10, 10, "rad/s"},
    {"sensors.gyro.low_pass_hz", 0, 1e5, "Hz"},
    {"sensors.mocap.position_noise_m", 0, 1, "m"},
    {"sensors.mocap.attitude_noise_rad", 0, 1, "rad"},
    {"sensors.mocap.stamp_jitter_s", 0, 1, "s"},
    {"sensors.rotor_speed.tick_us", 0, 1e6, "us"},
    {"sensors.rotor_speed.jitter", 0, 1e3, "1"},
    {"ambient.turbulence_force_rms_N", 0, 1e3, "N"},
    {"ambient.turbulence_torque_rms_Nm", 0, 1e3, "Nm"},
    {"ambient.correlation_time_s", 0, 1e4, "s"},
    {"controller.kp", 0, 1e5, "1/s2"},
    {"controller.kv", 0, 1e5, "1/s"},
    {"controller.ki", 0, 1e5, "1/s3"},
    {"controller.kR", 0, 1e6, "1/s2"},
    {"controller.kw", 0, 1e6, "1/s"},
    {"controller.kI", 0, 1e6, "1/s3"},
    {"controller.allocation_mass_kg", 0, 1e4, "kg"},
    {"tolerance.thrust_scale", 0, 1, "1"},
    {"tolerance.world_force", 0, 1, "1"},
    {"tolerance.torque_trim", 0, 1, "1"},
    {"tolerance.rotor_clock_s", 0, 0.1, "s"},
    {"tolerance.pose_clock_s", 0, 0.1, "s"},
    {"tolerance.inertia", 0, 1, "1"},
    {"tolerance.center_of_mass", 0, 1, "1"},
    {"tolerance.rotor_scale", 0, 1, "1"},
    {"tolerance.rotor_axis_rad", 0, 1, "rad"},
    {"tolerance.rotor_place", 0, 1, "1"},
    {"tolerance.drag_torque", 0, 1, "1"},
    {"tolerance.imu_position", 0, 1, "1"},
    {"environment.floor_z_m", -1e4, 1e4, "m"},
    {"environment.air_density_kgpm3", 0.01, 10, "kg/m3"},
};

/// Tolerances of the vehicle's numbers, and the kind of calibration that each belongs to.
struct ToldTolerance {
  const char *place, *kind;
  double Tolerance::*number;
};
constexpr ToldTolerance kTolerances[] = {
    {"tolerance.thrust_scale", "thrust_scale", &Tolerance::thrust_scale},
    {"tolerance.world_force", "world_force", &Tolerance::world_force},
    {"tolerance.torque_trim", "torque_trim", &Tolerance::torque_trim},
    {"tolerance.inertia", "inertia", &Tolerance::inertia},
    {"tolerance.center_of_mass", "center_of_mass", &Tolerance::center_of_mass},
    {"tolerance.rotor_scale", "rotor_scale", &Tolerance::rotor_scale},
    {"tolerance.rotor_axis_rad", "rotor_axis", &Tolerance::rotor_axis},
    {"tolerance.rotor_place", "rotor_place", &Tolerance::rotor_place},
    {"tolerance.drag_torque", "drag_torque", &Tolerance::drag_torque},
    {"tolerance.imu_position", "imu_position", &Tolerance::imu_position}};

/// A reader of the map at `path`; anew for every question, since a reader keeps its first error.
YamlReader map_at(const YamlReader& document, const std::vector<std::string>& path) {
  YamlReader at = document;
  for (const std::string& key : path) at = at.child(key);
  return at;
}

using Document = std::function<YamlReader()>;

Status walk(const Document& document, const std::vector<std::string>& path, PriorKnowledge& told) {
  for (const std::string& key : map_at(document(), path).keys()) {
    std::string place;
    for (const std::string& above : path) place += above + ".";
    place += key;
    if (place == "schema") continue;
    if (place == "neighbours") {
      YamlReader map = map_at(document(), path);
      for (const std::string& name : map.strings(key)) {
        const std::filesystem::path p(name);
        told.neighbours.push_back(
            (p.is_absolute() ? p : std::filesystem::path(told.file).parent_path() / p).string());
      }
      if (!map.ok()) return map.status();
      continue;
    }
    const auto known =
        std::find_if(std::begin(kKnown), std::end(kKnown), [&](const Known& k) { return place == k.place; });
    const bool rate = path.size() == 1 && path[0] == "rates_hz";
    if (known != std::end(kKnown) || rate) {
      const files::Bounds b =
          rate ? files::between(0, 1e6, "Hz") : files::between(known->min, known->max, known->unit);
      YamlReader one = map_at(document(), path), three = map_at(document(), path);
      const double value = one.number(key, b);
      const std::vector<double> values = three.numbers(key, 3, b);
      if (one.ok() && (rate || known->alone))
        told.numbers[place] = {value};
      else if (three.ok())
        told.numbers[place] = values;
      else
        return one.ok() ? three.status() : one.status();
      continue;
    }
    YamlReader map = map_at(document(), path);
    const auto inside = map.optional_child(key);
    if (map.ok() && inside && inside->is_map()) {
      std::vector<std::string> deeper = path;
      deeper.push_back(key);
      if (auto ok = walk(document, deeper, told); !ok) return ok;
    } else {
      told.ignored.push_back(place);
    }
  }
  return {};
}

double largest(const std::vector<double>& v) {
  double m = 0;
  for (double x : v) m = std::max(m, std::abs(x));
  return m;
}

}  // namespace

Result<PriorKnowledge> load_prior_knowledge(const std::string& path) {
  const auto text = files::read_file(path, files::kMegabyte);
  if (!text) return Failure(text.error());
  if (auto yaml = YamlReader::parse(*text, path); !yaml) return Failure(yaml.error());
  PriorKnowledge told;
  told.file = path;
  const Document document = [&] { return *YamlReader::parse(*text, path); };
  if (!document().is_map()) return bad_input("is no map of keys and values", path);
  if (auto ok = walk(document, {}, told); !ok) return Failure(ok.error());
  return told;
}

std::string prior_knowledge_beside(const std::string& recording) {
  std::error_code ec;
  for (const std::filesystem::path& p : {std::filesystem::path(recording + ".told.yaml"),
                                         std::filesystem::path(recording).parent_path() / "told.yaml"})
    if (std::filesystem::is_regular_file(p, ec)) return p.string();
  return {};
}

double& Tolerance::value(const std::string& kind) {
  for (const ToldTolerance& t : kTolerances)
    if (kind == t.kind) return this->*t.number;
  throw std::out_of_range("no tolerance of " + kind);
}

void apply(const PriorKnowledge& told, Options& o) {
  const auto get = [&](const char* place) -> const std::vector<double>* {
    const auto found = told.numbers.find(place);
    return found == told.numbers.end() ? nullptr : &found->second;
  };
  const auto three = [](const std::vector<double>& v) {
    return v.size() == 3 ? Vec3(v[0], v[1], v[2]) : Vec3::Constant(v[0]);
  };
  if (const auto* v = get("environment.floor_z_m")) o.environment.floor_z = (*v)[0], o.floor_told = true;
  if (const auto* v = get("environment.air_density_kgpm3")) {
    o.environment.air_density = (*v)[0];
    o.tolerance.air_density = 0;
  }
  // a bias that is told is the size up to which one is no finding
  if (const auto* v = get("sensors.accelerometer.bias_mps2")) {
    const double b = std::max(0.001, largest(*v));
    o.tolerance.accelerometer_lateral = b;
    o.tolerance.accelerometer_vertical = std::min(b, 0.1);
    o.tolerance.told.insert("acceleration_bias");
  }
  if (const auto* v = get("sensors.accelerometer.scale")) o.tolerance.accelerometer_scale = largest(*v);
  if (const auto* v = get("sensors.accelerometer.misalignment_rad"))
    o.tolerance.accelerometer_misalignment = largest(*v);
  if (const auto* v = get("sensors.imu.position_m")) o.imu_position = three(*v);
  if (const auto* v = get("sensors.gyro.bias_radps")) o.tolerance.gyro_bias = std::max(1e-4, largest(*v));
  for (const ToldTolerance& t : kTolerances)
    if (const auto* v = get(t.place)) {
      o.tolerance.*t.number = std::max(kLeastTolerance, (*v)[0]);
      o.tolerance.told.insert(t.kind);
    }
  if (const auto* v = get("tolerance.rotor_clock_s")) o.tolerance.rotor_clock = (*v)[0];
  if (const auto* v = get("tolerance.pose_clock_s")) o.tolerance.pose_clock = (*v)[0];
  for (const auto& [place, number] : {std::pair{"ambient.turbulence_force_rms_N", &o.noise.force},
                                      {"ambient.turbulence_torque_rms_Nm", &o.noise.torque},
                                      {"ambient.correlation_time_s", &o.noise.correlation_time},
                                      {"sensors.accelerometer.noise_rms_mps2", &o.noise.accelerometer},
                                      {"sensors.gyro.noise_rms_radps", &o.noise.gyro},
                                      {"sensors.mocap.position_noise_m", &o.noise.position},
                                      {"sensors.mocap.attitude_noise_rad", &o.noise.attitude}})
    if (const auto* v = get(place)) *number = largest(*v);
  ToldController& c = o.controller;
  for (const auto& [place, gain] : {std::pair{"controller.kp", &c.kp},
                                    {"controller.kv", &c.kv},
                                    {"controller.ki", &c.ki},
                                    {"controller.kR", &c.kR},
                                    {"controller.kw", &c.kw},
                                    {"controller.kI", &c.kI}})
    if (const auto* v = get(place)) *gain = three(*v), o.has_controller = true;
}

}  // namespace omniflight::diagnosis
