#include "ablation.hpp"

#include <optional>

namespace omniflight::cli {
namespace {

using diagnosis::Assumption;

struct Ablation {
  const char *id, *text;
  std::optional<Assumption> without = {};  ///< what the method leaves out
};
constexpr Ablation kAblations[] = {
    {"no-tolerance", "the vehicle file is exact"},
    {"no-law-error", "laws of the library are exact", Assumption::law_error},
    {"no-resolution", "every nat of evidence counts, however wrong laws are", Assumption::resolution},
    {"no-initial-states", "loads begin at rest", Assumption::initial_states},
    {"no-load-starts", "loads are fitted from the best point of their grid alone", Assumption::load_starts},
    {"no-instruments", "regressors are taken as they were measured", Assumption::instruments},
    {"no-horizons", "the shortest prediction horizon, untested", Assumption::horizons},
    {"no-tolerance-factors", "vehicles are measured as well as is assumed", Assumption::tolerance_factors},
    {"no-told-totals", "what is told of the whole vehicle does not bind its parts", Assumption::told_totals},
    {"no-told-noise", "turbulence and sensors' noise of any size", Assumption::told_noise},
    {"no-spectrum-correction", "noise spectra without smooth corrections", Assumption::spectrum_correction},
    {"no-occurrence", "all effects are equally likely beforehand", Assumption::occurrence},
    {"no-unknown-physics", "nothing beside the library", Assumption::unknown_physics},
    {"no-velocity-observer", "the velocity of poses is their derivative", Assumption::velocity_observer},
    {"no-late-thrust", "thrust follows speeds at once", Assumption::late_thrust},
    {"no-heavy-tails", "errors of drives and of lone samples are Gaussian", Assumption::heavy_tails},
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
  for (const Ablation& a : kAblations)
    if (id == a.id && a.without) options.without.insert(*a.without);
  if (id == "no-temperature") options.temperature = options.told_temperature = 1;
  if (id != "no-tolerance") return;
  auto& t = options.tolerance;
  for (double* sigma : {&t.thrust_scale, &t.accelerometer_lateral, &t.accelerometer_vertical, &t.world_force,
                        &t.torque_trim, &t.rotor_clock, &t.air_density, &t.inertia, &t.center_of_mass,
                        &t.rotor_scale, &t.rotor_axis, &t.rotor_place, &t.drag_torque, &t.imu_position})
    *sigma *= 1e-3;
}

}  // namespace omniflight::cli
