#include "tilt_look_ahead.hpp"

namespace omniflight::cli {
namespace {

/// The weights of the flight, as the allocator will read them.
allocation::AllocatorConfig weights_of(const Setup& s) {
  const auto text = [&](const char* key) {
    const auto found = s.weights.find(key);
    return found == s.weights.end() ? std::string() : found->second;
  };
  auto out = text("weights") == "case_a" ? allocation::AllocatorConfig::case_a()
                                         : allocation::AllocatorConfig::case_b();
  for (const auto& [key, value] :
       {std::pair{"w_input", &out.w_input}, {"w_linear", &out.w_linear}, {"w_angular", &out.w_angular}})
    if (const std::string given = text(key); !given.empty()) *value = std::stod(given);  // printed by us
  return out;
}

}  // namespace

Status find_schedule(const FlightOptions& o, Setup& s) {
  if (o.tilt_mode != "lookahead") return {};
  const auto refuse = [](const std::string& why, const char* next) {
    return bad_input(why, "--tilt lookahead", next);
  };
  if (!o.lockstep())
    return refuse("moves the tilt of the rotors, which the boards of the " + o.plant + " plant cannot",
                  "Give --plant simulator or mujoco");
  if (o.parameters.contains("allocator.alpha_deg"))
    return refuse("and -p allocator.alpha_deg contradict each other", "Leave one out");
  if (s.plan.certificate.leans)
    return refuse("the vehicle leans into the motion of this plan, which was made for one tilt",
                  "Plan at a tilt at which it commands its attitude (alpha_deg of the mission)");
  const auto motion = [&](double t) { return s.plan.trajectory.sample(t); };
  allocation::LookAheadConfig config;
  config.weights = weights_of(s);
  config.reserve = o.tilt_reserve;
  auto found = allocation::look_ahead(s.vehicle, motion, s.plan.trajectory.duration(), config);
  if (!found) return Failure(found.error());
  s.schedule = std::move(*found);
  return {};
}

}  // namespace omniflight::cli
