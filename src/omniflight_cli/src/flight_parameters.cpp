// The parameter files of a flight: for its components, and what a diagnosis may be told of it.
#include <fmt/format.h>

#include "control_choice.hpp"
#include "flight_setup.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_physics/situation.hpp"

namespace omniflight::cli {
namespace {

std::string join(const std::vector<std::string>& items) {
  std::string out;
  for (const auto& i : items) out += (out.empty() ? "" : ";") + i;
  return out;
}

std::string quoted(const std::string& text) { return nlohmann::json(text).dump(); }

/// A value of the recorder's metadata, whose list knows ';' and '=' only.
std::string plain(std::string text) {
  for (char& c : text)
    if (c == ';' || c == '=' || static_cast<unsigned char>(c) < 0x20) c = '_';
  return text;
}

}  // namespace

std::string parameters(const FlightOptions& o, const Setup& s) {
  const std::string vehicle = o.vehicle.empty() ? s.mission.vehicle : o.vehicle;
  const auto& knot = s.plan.trajectory.knots().front().reference;
  const Vec3 rpy = roll_pitch_yaw(knot.q_WB) * (180.0 / kPi);
  const double alpha = to_degrees(s.schedule ? s.schedule->at(0) : s.plan.certificate.alpha);
  std::map<std::string, std::map<std::string, std::string>> p;
  const auto common = [&](const std::string& component) {
    p[component]["vehicle"] = quoted(vehicle);
    p[component]["vehicle_set"] = quoted(join(o.set));
  };
  p["recorder"] = {
      {"file", quoted((s.out / kRecording).string())},
      {"overwrite", "true"},
      {"record_truth", o.plant == "hardware" ? "false" : "true"},
      {"metadata", quoted(fmt::format("vehicle={};plant={};mission={};seed={};synthetic={};map_sha256={};"
                                      "vehicle_sha256={};mission_sha256={};inputs_sha256={}",
                                      plain(vehicle), o.plant, plain(s.plan.certificate.mission), o.seed,
                                      o.plant == "hardware" ? "no" : "yes", s.plan.certificate.map_sha256,
                                      s.plan.certificate.vehicle_sha256, s.plan.certificate.mission_sha256,
                                      s.fingerprint))},
      {"attachments", quoted((s.out / "plan" / "certificate.json").string())}};
  p["planner"] = {{"plan", quoted((s.out / "plan").string())},
                  {"replans", quoted((s.out / kReplans).string())},
                  {"fixed_tilt", o.lockstep() ? "false" : "true"},
                  {"latest_end_s", fmt::format("{:.17g}", s.plan.trajectory.duration() + o.stay_s)}};
  common("allocator");
  p["allocator"]["alpha_deg"] = fmt::format("{:.17g}", alpha);
  p["allocator"].insert(s.weights.begin(), s.weights.end());
  p["allocator"]["tilt_mode"] = s.schedule ? "fixed" : o.tilt_mode;
  if (s.schedule) p["allocator"]["tilt_schedule"] = quoted((s.out / kTiltSchedule).string());
  if (o.monitor) {
    common("monitor");
    p["monitor"]["summary_file"] = quoted((s.out / "monitor.json").string());
    p["monitor"]["imu_position_m"] = in_brackets(s.sensing.imu_position);
  }
  p["controller"] = control_parameters(o, s);
  common("controller");
  p["controller"]["map"] = quoted(std::filesystem::absolute(s.mission.test_bed).string());
  p["controller"]["ground_z_m"] = fmt::format("{:.17g}", s.ground_z);
  p["controller"]["settle_s"] = fmt::format("{}", kSettle);
  if (s.fence) {
    p["controller"]["fence_min_m"] = in_brackets(s.fence->first);
    p["controller"]["fence_max_m"] = in_brackets(s.fence->second);
  }
  const auto plant = [&](const std::string& component) {
    common(component);
    auto& q = p[component];
    if (o.plant == "mujoco")
      q["world"] = quoted(s.world);
    else
      q["model"] = quoted(s.effects);
    if (!s.neighbours.empty()) q["neighbours"] = quoted(join(s.neighbours));
    q["sensors"] = quoted(s.sensors);
    q["seed"] = std::to_string(o.seed);
    q["hold_s"] = fmt::format("{}", kHold);
    q["duration_s"] = fmt::format("{:.17g}", s.duration);
    q["initial_position_m"] =
        fmt::format("[{:.17g}, {:.17g}, {:.17g}]", knot.p_WB.x(), knot.p_WB.y(), knot.p_WB.z());
    q["initial_rpy_deg"] = fmt::format("[{:.17g}, {:.17g}, {:.17g}]", rpy.x(), rpy.y(), rpy.z());
    q["initial_alpha_deg"] = fmt::format("{:.17g}", alpha);
  };
  if (o.lockstep()) {
    const std::string master = plant_component(o);
    plant(master);
    if (!s.faults.empty()) p[master]["faults_file"] = quoted(s.faults);
    p[master]["rate"] = o.realtime ? "realtime" : "max";
    p[master]["recorder_window_ticks"] = "200";
  } else {
    const std::string links = (s.out / "boards").string();
    if (o.plant == "emulator") {
      plant("emulator");
      p["emulator"]["link_directory"] = quoted(links);
      if (!s.natnet.empty()) p["emulator"]["mocap_topic"] = quoted(components::topics::emulated_mocap);
      p["emulator"]["epoch_monotonic_ns"] = std::to_string(s.epoch_ns);
      // no rotor turns: a machine that stands still as a whole may do so for longer than hardware may wait
      p["gateway"]["stale_after_s"] = "1.0";
      p["gateway"]["board_silence_s"] = "1.5";
      p["gateway"]["board_stall_s"] = "1.5";
      p["controller"]["mocap_timeout_s"] = "1.5";
      p["controller"]["imu_timeout_s"] = "1.0";
      p["controller"]["missed_share"] = "1.0";
    }
    if (!s.natnet.empty())
      for (const char* name : {"natnet", "natnet_emulator"})
        p[name] = {{"config", quoted(s.natnet)}, {"epoch_monotonic_ns", std::to_string(s.epoch_ns)}};
    if (o.plant == "hardware") p.erase("natnet_emulator");
    p["gateway"]["plan"] = quoted((s.out / "plan").string());
    p["gateway"][o.plant == "hardware" ? "operator_arms" : "most_missed_share"] =
        o.plant == "hardware" ? "true" : "1.0";
    common("gateway");
    auto& g = p["gateway"];
    g["devices"] = quoted(o.plant == "emulator" ? links + "/board0;" + links + "/board1;" + links + "/board2"
                                                : o.devices);
    g["summary_file"] = quoted((s.out / kPeriods).string());
    g["epoch_monotonic_ns"] = std::to_string(s.epoch_ns);
    g["hold_s"] = "2.0";
    g["flight_s"] = fmt::format("{:.17g}", kSettle + s.plan.trajectory.duration() + s.after);
    g["alpha_deg"] = fmt::format("{:.17g}", alpha);
  }
  for (const auto& [key, value] : o.parameters) {
    const auto dot = key.find('.');
    if (dot != std::string::npos) p[key.substr(0, dot)][key.substr(dot + 1)] = value;
    if (key == "allocator.alpha_deg") p["allocator"].try_emplace("follow_plan", "false");
  }
  std::string yaml = "# Parameters of this flight, on top of configs/components/default.yaml.\n";
  for (const auto& [component, values] : p) {
    yaml += component + ":\n  ros__parameters:\n";
    for (const auto& [key, value] : values) yaml += "    " + key + ": " + value + "\n";
  }
  return yaml;
}

Result<std::string> told(const FlightOptions& o, const Setup& s) {
  auto gains = told_gains(o, s);
  if (!gains) return gains;
  std::string known, air;
  if (o.plant != "hardware") {
    air = fmt::format("environment: {{air_density_kgpm3: {:.10g}}}\n", physics::Environment{}.air_density);
    const simulation::SensorConfig& sensors = s.sensing;
    const auto most = [](const Vec3& v) { return v.cwiseAbs().maxCoeff(); };
    std::string accelerometer;
    for (const auto& [key, value] : {std::pair{"bias_mps2", most(sensors.accelerometer_bias)},
                                     {"scale", most(sensors.accelerometer_scale)},
                                     {"misalignment_rad", most(sensors.accelerometer_misalignment)}})
      if (value > 0)
        accelerometer += fmt::format("{}{}: {:.10g}", accelerometer.empty() ? "" : ", ", key, value);
    if (!accelerometer.empty()) known += "  accelerometer: {" + accelerometer + "}  # at most\n";
    if (const double bias = most(sensors.gyro_bias); bias > 0)
      known += fmt::format("  gyro: {{bias_radps: {:.10g}}}  # at most\n", bias);
    if (!sensors.imu_position.isZero())
      known += "  imu: {position_m: " + in_brackets(sensors.imu_position) + "}  # in the body\n";
  }
  return "# What is known beside the recording of this flight; omniflight diagnose reads it by itself.\n" +
         (known.empty() ? "" : "sensors:\n" + known) + air +
         (gains->empty() ? "" : "controller: " + *gains + "\n");
}

}  // namespace omniflight::cli
