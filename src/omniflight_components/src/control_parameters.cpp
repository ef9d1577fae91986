#include "control_parameters.hpp"

#include "conversions.hpp"
#include "omniflight_components/tilt_schedule_file.hpp"

namespace omniflight::components {

LawParameters read_law_parameters(bus::Parameters& p) {
  LawParameters out;
  control::LawConfig& law = out.config;
  control::ControllerConfig& c = law.gains;
  const auto gain = [&](const char* key, const Vec3& otherwise) {
    const auto v = p.numbers(key, std::vector<double>{otherwise.x(), otherwise.y(), otherwise.z()}, 3);
    return v.size() == 3 ? Vec3(v[0], v[1], v[2]) : otherwise;
  };
  c.kp = gain("kp", c.kp);
  c.kv = gain("kv", c.kv);
  c.ki = gain("ki", c.ki);
  c.kR = gain("kR", c.kR);
  c.kw = gain("kw", c.kw);
  c.kI = gain("kI", c.kI);
  c.max_acceleration = p.number("max_acceleration_mps2", c.max_acceleration, 0, 1000);
  c.max_angular_acceleration =
      p.number("max_angular_acceleration_radps2", c.max_angular_acceleration, 0, 10000);
  c.max_integral_acceleration =
      p.number("max_integral_acceleration_mps2", c.max_integral_acceleration, 0, 1000);
  c.max_integral_angular_acceleration =
      p.number("max_integral_angular_acceleration_radps2", c.max_integral_angular_acceleration, 0, 10000);
  c.feed_forward = p.flag("feed_forward", c.feed_forward);
  out.anti_windup = p.flag("anti_windup", true);
  c.unachieved_tolerance = p.number("unachieved_tolerance_mps2", c.unachieved_tolerance, 0, 1000);
  c.unachieved_angular_tolerance =
      p.number("unachieved_angular_tolerance_radps2", c.unachieved_angular_tolerance, 0, 10000);
  out.name = p.text("law", "full_pose");
  law.thrust_axis_B = gain("thrust_axis", law.thrust_axis_B);
  law.max_lean = to_radians(p.number("max_lean_deg", to_degrees(law.max_lean), 1, 89));
  law.max_correction_speed = p.number("max_correction_speed_mps", law.max_correction_speed, 0.01, 100);
  law.max_correction_rate = p.number("max_correction_rate_radps", law.max_correction_rate, 0.01, 100);
  law.disturbance_bandwidth = p.number("disturbance_bandwidth_radps", law.disturbance_bandwidth, 0.1, 500);
  law.actuator_time_constant = p.number("actuator_time_constant_s", law.actuator_time_constant, 0, 2);
  return out;
}

Result<std::unique_ptr<control::Law>> make_law(const LawParameters& parameters) {
  auto made = control::make_law(parameters.name, parameters.config);
  if (made && parameters.name == "incremental" && !parameters.anti_windup)
    return bad_input("the law incremental has to know what was achieved of its last demand",
                     "controller.anti_windup", "Give true, or take another law");
  return made;
}

Result<AllocatorParameters> read_allocator_parameters(bus::Parameters& p) {
  AllocatorParameters out;
  const std::string vehicle_name = p.text("vehicle", {});
  const std::string overrides = p.text("vehicle_set", "");
  const std::string weights = p.text("weights", "case_a");
  const std::string mode = p.text("tilt_mode", "fixed");
  const double alpha_deg = p.number("alpha_deg", 30.0, -180, 180);
  out.follow_plan = p.flag("follow_plan", true);  // false: stays at alpha_deg whatever the plan says
  allocation::AllocatorConfig& config = out.config;
  config =
      weights == "case_a" ? allocation::AllocatorConfig::case_a() : allocation::AllocatorConfig::case_b();
  if (weights != "case_a" && weights != "case_b" && weights != "dynamic")
    return bad_input("'" + weights + "' is neither case_a nor case_b nor dynamic", "allocator.weights");
  if (mode != "fixed" && mode != "search")
    return bad_input("'" + mode + "' is neither fixed nor search", "allocator.tilt_mode");
  config.w_input = p.number("w_input", config.w_input, 0, 1e6);
  config.w_rate = p.number("w_rate", config.w_rate, 0, 1e6);
  config.w_linear = p.number("w_linear", config.w_linear, 1e-12, 1e12);
  config.w_angular = p.number("w_angular", config.w_angular, 1e-12, 1e12);
  config.tilt_step = to_radians(p.number("tilt_step_deg", to_degrees(config.tilt_step), 0, 10));
  config.tilt_candidates = static_cast<int>(p.number("tilt_candidates", config.tilt_candidates, 1, 8));
  config.mass = p.number("mass_kg", 0.0, 0, 1000);
  config.keep_min_thrust = p.flag("keep_min_thrust", false);
  const std::string schedule = p.text("tilt_schedule", "");
  out.drop_lost = p.flag("drop_lost_rotors", true);
  out.joints_hz = p.number("joints_hz", 50.0, 0, 1000);
  auto& dynamic = config.dynamic_weights;  // eq. 5.3, on top of case_b under the name `dynamic`
  dynamic.enabled = p.flag("dynamic_weights", weights == "dynamic");
  dynamic.threshold = p.number("dynamic_threshold_m", dynamic.threshold, 1e-6, 10);
  dynamic.growth = p.number("dynamic_growth", dynamic.growth, 1, 10);
  dynamic.shrink = p.number("dynamic_shrink", dynamic.shrink, 1e-3, 1);
  dynamic.floor = p.number("dynamic_floor", dynamic.floor, 1e-15, 1e6);
  dynamic.ceiling = p.number("dynamic_ceiling", dynamic.ceiling, 1e-15, 1e6);
  config.tilt_mode = mode == "search" ? allocation::TiltMode::search : allocation::TiltMode::fixed;
  config.initial_tilt = to_radians(alpha_deg);
  if (auto ok = p.finish(); !ok) return Failure(ok.error());
  auto vehicle = vehicle::load_vehicle(vehicle_name, split(overrides));
  if (!vehicle) return Failure(vehicle.error());
  out.vehicle = std::move(*vehicle);
  if (out.vehicle.tilt.kind == vehicle::TiltKind::none) {
    config.tilt_mode = allocation::TiltMode::fixed;
    config.initial_tilt = 0.0;
  }
  if (!schedule.empty()) {
    auto read = read_tilt_schedule(schedule, out.vehicle.tilt);
    if (!read) return Failure(read.error());
    out.schedule.emplace(std::move(*read));
    config.tilt_mode = allocation::TiltMode::fixed;
    config.initial_tilt = out.schedule->at(0);
  }
  return out;
}

}  // namespace omniflight::components
