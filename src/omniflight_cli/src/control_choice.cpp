#include "control_choice.hpp"

#include <fmt/format.h>

#include "omniflight_control/law.hpp"
#include "omniflight_control/leaning_gains.hpp"
#include "omniflight_files/yaml.hpp"

namespace omniflight::cli {
namespace {

constexpr std::pair<const char*, const char*> kGains[] = {{"kp", "1/s2"}, {"kv", "1/s"}, {"ki", "1/s3"},
                                                          {"kR", "1/s2"}, {"kw", "1/s"}, {"kI", "1/s3"}};

std::string law_of(const FlightOptions& o, const Setup& s) {
  if (const auto own = o.parameters.find("controller.law"); own != o.parameters.end()) return own->second;
  if (!o.controller.empty()) return o.controller;
  return s.plan.certificate.leans ? "thrust_vector" : "full_pose";
}

}  // namespace

std::string in_brackets(const Vec3& v) {
  return fmt::format("[{:.10g}, {:.10g}, {:.10g}]", v.x(), v.y(), v.z());
}

std::map<std::string, std::string> control_parameters(const FlightOptions& o, const Setup& s) {
  std::map<std::string, std::string> p;
  const std::string law = law_of(o, s);
  p["law"] = law;
  double slowest = 0;
  for (const vehicle::Rotor& rotor : s.vehicle.rotors) slowest = std::max(slowest, rotor.time_constant);
  p["actuator_time_constant_s"] = fmt::format("{:.10g}", slowest);
  p["disturbance_bandwidth_radps"] =
      fmt::format("{:.10g}", std::min(15.0, control::kLagShare / std::max(1e-3, slowest)));
  if (!s.plan.certificate.leans) return p;
  p["thrust_axis"] = fmt::format("[{:.17g}, {:.17g}, {:.17g}]", s.plan.certificate.thrust_axis_B.x(),
                                 s.plan.certificate.thrust_axis_B.y(), s.plan.certificate.thrust_axis_B.z());
  // room for corrections on top of what the plan leans
  p["max_lean_deg"] =
      fmt::format("{:.10g}", std::min(80.0, to_degrees(s.plan.certificate.limits.lean) + 10.0));
  const control::ControllerConfig gains = control::leaning_gains(slowest, law != "cascaded");
  p["kp"] = in_brackets(gains.kp);
  p["kv"] = in_brackets(gains.kv);
  p["ki"] = in_brackets(gains.ki);
  p["kR"] = in_brackets(gains.kR);
  p["kw"] = in_brackets(gains.kw);
  return p;
}

Status check_law(const FlightOptions& o, const Setup& s) {
  control::LawConfig config;
  if (s.plan.certificate.leans) config.thrust_axis_B = s.plan.certificate.thrust_axis_B;
  const auto law = control::make_law(law_of(o, s), config);
  if (law) return {};
  Error error = law.error();
  error.where = "--controller";
  return Failure(error);
}

namespace {

/// The gains that fly: of the configuration, of the law's choice, of the operator, the later before the
/// earlier.
Result<std::map<std::string, Vec3>> flown_gains(const FlightOptions& o, const Setup& s) {
  auto defaults = files::YamlReader::load(s.defaults);
  if (!defaults) return Failure(defaults.error());
  auto usual = defaults->child("controller").child("ros__parameters");
  const auto chosen = control_parameters(o, s);
  std::map<std::string, Vec3> gain;
  for (const auto& [name, unit] : kGains) {
    const auto bounds = files::between(0, 1e5, unit);
    gain[name] = usual.vec3(name, bounds);
    const auto own = o.parameters.find(std::string("controller.") + name);
    const auto ours = chosen.find(name);
    if (own == o.parameters.end() && ours == chosen.end()) continue;
    auto yaml = files::YamlReader::parse(
        std::string(name) + ": " + (own != o.parameters.end() ? own->second : ours->second), "--param");
    if (!yaml) return Failure(yaml.error());
    gain[name] = yaml->vec3(name, bounds);
    if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  }
  return gain;
}

}  // namespace

Status check_weights(const FlightOptions& o, const Setup& s) {
  // below it trajectory quarter_pitch is lost with dynamic weights and flown with case_b, on the nominal
  // model
  constexpr double kLeast = 25.0;  // 1/s^2
  const auto weights = s.weights.find("weights");
  if (weights == s.weights.end() || weights->second != "dynamic") return {};
  const auto gain = flown_gains(o, s);
  if (!gain) return Failure(gain.error());
  const double kp = gain->at("kp").minCoeff();
  if (kp >= kLeast) return {};
  return bad_input(fmt::format("dynamic weights (eq. 5.3) need position gains of {:g} 1/s2 or more, this "
                               "flight has {:g}: with softer ones "
                               "the error passes their threshold when the tilt can no longer follow, and a "
                               "quick pitch is lost that "
                               "case_b flies",
                               kLeast, kp),
                   "--weights dynamic",
                   "Give -p controller.kp='[50, 50, 50]' -p controller.kv='[10, 10, 10]', or case_a");
}

Result<std::string> told_gains(const FlightOptions& o, const Setup& s) {
  const std::string law = law_of(o, s);
  // an integral of the velocity error is none of the position error: the estimate is corrected in between
  if (law == "incremental" || law == "cascaded") return std::string();
  auto gain = flown_gains(o, s);
  if (!gain) return Failure(gain.error());
  std::string out;
  for (const auto& [name, unit] : kGains)
    out += fmt::format("{}{}: {}", out.empty() ? "" : ", ", name, in_brackets((*gain)[name]));
  return "{" + out + "}";
}

}  // namespace omniflight::cli
