// Reads omniflight.faults/1.
#include "omniflight_simulation/faults.hpp"

namespace omniflight::simulation {
namespace {

using files::between;

constexpr double kLongest = 36000;  // s

std::size_t read_rotor(files::YamlReader& item, int rotor_count) {
  return static_cast<std::size_t>(item.integer("rotor", 1, rotor_count, 1) - 1);
}

Fault read_fault(files::YamlReader item, int rotor_count) {
  Fault f;
  f.kind = item.choice<FaultKind>("kind", {{"rotor_loss", FaultKind::rotor_loss},
                                           {"stuck_rotor", FaultKind::stuck_rotor},
                                           {"sensor_freeze", FaultKind::sensor_freeze},
                                           {"sensor_loss", FaultKind::sensor_loss},
                                           {"gust", FaultKind::gust},
                                           {"rope_snag", FaultKind::rope_snag}});
  f.at = item.number("at_s", between(0, kLongest, "s"));
  const files::Bounds lasting{.min = 0, .max = kLongest, .unit = "s", .open_min = true};
  const bool on_rotor = f.kind == FaultKind::rotor_loss || f.kind == FaultKind::stuck_rotor;
  if (!on_rotor || item.has("for_s")) f.duration = item.number("for_s", lasting);
  if (on_rotor) {
    if (!item.has("rotor")) item.error_at("rotor", "is missing", "Name a rotor, counted from 1");
    f.rotor = read_rotor(item, rotor_count);
  }
  switch (f.kind) {
    case FaultKind::rotor_loss:
      break;
    case FaultKind::stuck_rotor:
      if (item.has("speed_radps")) f.speed = item.number("speed_radps", between(-1e4, 1e4, "rad/s"));
      break;
    case FaultKind::sensor_freeze:
    case FaultKind::sensor_loss:
      f.sensor = item.choice<FaultySensor>("sensor", {{"imu", FaultySensor::imu},
                                                      {"mocap", FaultySensor::mocap},
                                                      {"rotor_speed", FaultySensor::rotor_speed},
                                                      {"battery", FaultySensor::battery}});
      break;
    case FaultKind::gust:
      f.force_W = item.vec3("force_N", between(-1000, 1000, "N"), Vec3::Zero());
      f.torque_B = item.vec3("torque_Nm", between(-100, 100, "Nm"), Vec3::Zero());
      if (f.force_W.isZero() && f.torque_B.isZero())
        item.error_at("force_N", "a gust without force or torque does nothing", "Give force_N or torque_Nm");
      break;
    case FaultKind::rope_snag:
      f.point_B = item.vec3("point_m", between(-2, 2, "m"), Vec3::Zero());
      f.slack = item.number("slack_m", between(0, 20, "m"), 0.0);
      f.stiffness = item.number("stiffness_N_per_m", between(1, 1e4, "N/m"), 200.0);
      f.damping = item.number("damping_Ns_per_m", between(0, 1e3, "N s/m"), 2.0);
      break;
  }
  return f;
}

/// Faults of the same thing may not overlap: which one would act?
std::string what_breaks(const Fault& f) {
  switch (f.kind) {
    case FaultKind::rotor_loss:
    case FaultKind::stuck_rotor:
      return "rotor " + std::to_string(f.rotor + 1);
    case FaultKind::sensor_freeze:
    case FaultKind::sensor_loss:
      return "sensor " + std::to_string(static_cast<int>(f.sensor));
    case FaultKind::rope_snag:
      return "rope";
    case FaultKind::gust:
      break;  // gusts add up
  }
  return {};
}

}  // namespace

std::string to_string(FaultKind kind) {
  static const char* const names[] = {"rotor_loss",  "stuck_rotor", "sensor_freeze",
                                      "sensor_loss", "gust",        "rope_snag"};
  return names[static_cast<int>(kind)];
}

Result<std::vector<Fault>> read_faults(files::YamlReader yaml, int rotor_count) {
  if (yaml.string("schema") != "omniflight.faults/1") yaml.error_at("schema", "is not omniflight.faults/1");
  yaml.ignore("comment");
  std::vector<Fault> faults;
  for (files::YamlReader item : yaml.children("faults", 0, 1000)) {
    faults.push_back(read_fault(item, rotor_count));
    const Fault& now = faults.back();
    for (std::size_t k = 0; k + 1 < faults.size(); ++k) {
      const Fault& other = faults[k];
      const std::string thing = what_breaks(now);
      if (thing.empty() || thing != what_breaks(other)) continue;
      if (now.at < other.at + other.duration && other.at < now.at + now.duration)
        item.error_at("at_s",
                      to_string(now.kind) + " overlaps the " + to_string(other.kind) + " of the same " +
                          thing.substr(0, thing.find(' ')) + " that begins at " + std::to_string(other.at) +
                          " s",
                      "Let one end (for_s) before the other begins");
    }
  }
  if (auto ok = yaml.finish(); !ok) return Failure(ok.error());
  return faults;
}

Result<std::vector<Fault>> load_faults(const std::string& path, int rotor_count) {
  auto yaml = files::YamlReader::load(path);
  if (!yaml) return Failure(yaml.error());
  return read_faults(*yaml, rotor_count);
}

}  // namespace omniflight::simulation
