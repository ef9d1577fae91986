#include "omniflight_diagnosis/told.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "omniflight_files/yaml.hpp"

namespace omniflight::diagnosis {
namespace {

using files::YamlReader;

struct Known {
  const char* place;
  double min, max;
  const char* unit;
};
constexpr Known kKnown[] = {
    {"sensors.accelerometer.noise_rms_mps2", 0, 100, "m/s2"},
    {"sensors.accelerometer.bias_mps2", -50, 50, "m/s2"},
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
    {"environment.floor_z_m", -1e4, 1e4, "m"},
    {"environment.air_density_kgpm3", 0.01, 10, "kg/m3"},
};

void walk(YamlReader map, const std::string& above, Told& told) {
  for (const std::string& key : map.keys()) {
    const std::string place = above.empty() ? key : above + "." + key;
    if (place == "schema") {
      map.ignore(key);
      continue;
    }
    if (place == "neighbours") {
      for (const std::string& path : map.strings(key)) {
        const std::filesystem::path p(path);
        told.neighbours.push_back(
            (p.is_absolute() ? p : std::filesystem::path(told.file).parent_path() / p).string());
      }
      continue;
    }
    const auto known =
        std::find_if(std::begin(kKnown), std::end(kKnown), [&](const Known& k) { return place == k.place; });
    const bool rate = above == "rates_hz";
    auto value = map.optional_child(key);
    if (!value) continue;
    if (value->is_map() && known == std::end(kKnown)) {
      walk(*value, place, told);
    } else if (known != std::end(kKnown) || rate) {
      const files::Bounds b =
          rate ? files::between(0, 1e6, "Hz") : files::between(known->min, known->max, known->unit);
      if (value->is_sequence())
        told.numbers[place] = value->as_numbers(3, b);
      else
        told.numbers[place] = {value->as_number(b)};
    } else {
      map.ignore(key);
      told.ignored.push_back(place);
    }
  }
}

double largest(const std::vector<double>& v) {
  double m = 0;
  for (double x : v) m = std::max(m, std::abs(x));
  return m;
}

}  // namespace

Result<Told> load_told(const std::string& path) {
  auto yaml = YamlReader::load(path);
  if (!yaml) return Failure(yaml.error());
  Told told;
  told.file = path;
  walk(*yaml, "", told);
  if (auto ok = yaml->status(); !ok) return Failure(ok.error());
  return told;
}

std::string told_beside(const std::string& recording) {
  std::error_code ec;
  for (const std::filesystem::path& p : {std::filesystem::path(recording + ".told.yaml"),
                                         std::filesystem::path(recording).parent_path() / "told.yaml"})
    if (std::filesystem::is_regular_file(p, ec)) return p.string();
  return {};
}

void apply(const Told& told, Options& o) {
  const auto get = [&](const char* place) -> const std::vector<double>* {
    const auto found = told.numbers.find(place);
    return found == told.numbers.end() ? nullptr : &found->second;
  };
  const auto three = [](const std::vector<double>& v) {
    return v.size() == 3 ? Vec3(v[0], v[1], v[2]) : Vec3::Constant(v[0]);
  };
  if (const auto* v = get("environment.floor_z_m")) o.environment.floor_z = (*v)[0], o.floor_told = true;
  if (const auto* v = get("environment.air_density_kgpm3")) o.environment.air_density = (*v)[0];
  // a bias that is told is the size up to which one is no finding
  if (const auto* v = get("sensors.accelerometer.bias_mps2")) {
    const double b = std::max(0.02, largest(*v));
    o.tolerance.accelerometer_lateral = b;
    o.tolerance.accelerometer_vertical = std::min(b, 0.1);
  }
  if (const auto* v = get("controller.kp")) {
    o.has_controller = true;
    o.controller.kp = three(*v);
    if (const auto* w = get("controller.kv")) o.controller.kv = three(*w);
    if (const auto* w = get("controller.ki")) o.controller.ki = three(*w);
  }
}

}  // namespace omniflight::diagnosis
