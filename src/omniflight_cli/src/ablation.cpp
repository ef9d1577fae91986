#include "ablation.hpp"

namespace omniflight::cli {
namespace {

struct Ablation {
  const char *id, *text;
};
constexpr Ablation kAblations[] = {
    {"no-tolerance", "the vehicle file is exact"},
    {"no-law-error", "laws of the library are exact"},
    {"no-temperature", "likelihoods count as they are"},
    {"late-pose", "the pose is 20 ms later than it says"},
    {"wrong-inertia", "the vehicle file has 10 % too much inertia"},
    {"commands-only", "rotor speeds are not recorded"},
};
constexpr double kLateBy = 0.020;  ///< s
constexpr double kHeavy = 1.1;

}  // namespace

const std::vector<std::string>& ablations() {
  static const std::vector<std::string> ids = [] {
    std::vector<std::string> out;
    for (const Ablation& a : kAblations) out.emplace_back(a.id);
    return out;
  }();
  return ids;
}

std::string ablations_help() {
  std::string out;
  for (const Ablation& a : kAblations) out += std::string(out.empty() ? "" : "\n") + a.id + ": " + a.text;
  return out;
}

void ablate_input(const std::string& id, std::vector<recording::Recording>& recordings,
                  vehicle::Vehicle& vehicle) {
  if (id == "wrong-inertia") vehicle.inertia *= kHeavy;
  for (recording::Recording& r : recordings) {
    if (id == "commands-only") r.signals.erase("rotor_speed");
    if (id != "late-pose") continue;
    for (const char* name : {"position", "attitude", "velocity"})
      if (const auto s = r.signals.find(name); s != r.signals.end())
        for (double& t : s->second.t_s) t += kLateBy;
  }
}

void ablate_options(const std::string& id, diagnosis::Options& options) {
  if (id == "no-law-error") options.law_error = 0;
  if (id == "no-temperature") options.temperature = options.told_temperature = 1;
  if (id != "no-tolerance") return;
  auto& t = options.tolerance;
  for (double* sigma : {&t.thrust_scale, &t.accelerometer_lateral, &t.accelerometer_vertical, &t.world_force,
                        &t.torque_trim, &t.rotor_clock, &t.air_density, &t.inertia, &t.center_of_mass,
                        &t.rotor_scale, &t.rotor_axis, &t.rotor_place, &t.drag_torque, &t.imu_position})
    *sigma *= 1e-3;
}

}  // namespace omniflight::cli
