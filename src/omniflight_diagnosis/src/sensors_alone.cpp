#include "sensors_alone.hpp"

#include <algorithm>

#include "conditioning/analysis_scope.hpp"
#include "conditioning/sensor_faults.hpp"
#include "experiment_design/without_rotor_speeds.hpp"
#include "numerics/text.hpp"
#include "omniflight_physics/effect_ids.hpp"
#include "report/intake.hpp"
#include "report/other_stages.hpp"
#include "sensor_checks/findings.hpp"
#include "sensor_checks/inverse_dynamics.hpp"
#include "sensor_checks/merge_recordings.hpp"
#include "sensor_checks/redundancy_check.hpp"
#include "sensor_checks/sensor_health.hpp"

namespace omniflight::diagnosis {
namespace {

/// "noise of acc 0.051 m/s2, gyro 0.005 rad/s; clocks: gyro 4.0 ms before attitude".
std::string state_of(const Intake& in) {
  std::string noise, lost, clocks, rest;
  for (const SensorFact& f : in.sensors) {
    if (f.quantity == "white noise, RMS")
      noise += (noise.empty() ? "Noise: " : ", ") +
               format("%s %.2g %s", f.signal.c_str(), f.value, f.unit.c_str());
    if (f.quantity == "share of time in gaps" && f.value > 0.001)
      lost +=
          (lost.empty() ? "Lost in gaps: " : ", ") + format("%s %.1f %%", f.signal.c_str(), 100 * f.value);
    if (f.quantity.rfind("magnitude at rest", 0) == 0)
      rest = format(" At rest the accelerometer reads %.3f m/s2.", f.value);
    if (f.quantity.rfind("tracking error", 0) == 0 && f.quantity.find("RMS") != std::string::npos)
      rest += format(" The tracking error %c is %.3g m RMS.", f.quantity[15], f.value);
  }
  for (const Alignment& a : in.alignment)
    clocks += format(" %s comes %.1f ms (+-%.1f) after %s.", a.late.c_str(), 1e3 * a.lag_s, 1e3 * a.lag_se,
                     a.early.c_str());
  return (noise.empty() ? "" : noise + ".") + (lost.empty() ? "" : " " + lost + ".") + rest + clocks;
}

}  // namespace

std::string missing_reason(const recording::Recording& r) {
  switch (scope_of(r)) {
    case AnalysisScope::sensors:
      return "no rotor speed, rotor command or duty cycle was recorded";
    case AnalysisScope::motors:
      return "attitude or force was not recorded";
    case AnalysisScope::wrench:
      break;
  }
  return "";
}

Diagnosis judge_sensors_of(const recording::Recording& r, const vehicle::Vehicle& vehicle, const Options& o) {
  Diagnosis d;
  Flight none;
  none.alignment = align_signals(r);
  d.intake = describe(r, none);
  d.inputs.push_back(input_of(r));
  add_faults(find_sensor_faults(r), {}, d);
  add_sensor_health(r, o, d, d.inputs[0].excluded);
  if (auto errors = judge_kinematics(r, o)) {
    for (Kinematics::Part& part : errors->parts)  // only forces tell which of the two is off the origin
      if (part.effect == physics::effect_id::imu_lever_arm)
        part.as_well.emplace_back(physics::effect_id::mocap_offset);
    add_kinematics(*errors, d);
  }
  judge_sizes(vehicle, o, d.findings);
  if (const auto needed = inverse_dynamics(r, vehicle, o))
    for (SensorFact& f : facts_of(*needed)) d.intake.sensors.push_back(std::move(f));
  return d;
}

Diagnosis diagnose_sensors(std::span<const recording::Recording> flown, const vehicle::Vehicle& vehicle,
                           const Options& o, const std::string& why) {
  Diagnosis d;
  d.verdict = Verdict::unusable;
  std::string states;
  for (const recording::Recording& r : flown) {
    Diagnosis one = judge_sensors_of(r, vehicle, o);
    Diagnosis agreement;
    agreement.findings = one.findings;
    check_redundancy(r, vehicle, o, agreement);
    judge_sizes(vehicle, o, agreement.findings);
    for (std::size_t k = one.findings.size(); k < agreement.findings.size(); ++k)
      one.findings.push_back(agreement.findings[k]);
    one.mismatch.insert(one.mismatch.end(), agreement.mismatch.begin(), agreement.mismatch.end());
    merge_recording(one, r.file, d);
    d.inputs.push_back(one.inputs[0]);
    if (flown.size() > 1) states += " " + r.file + ":";
    if (const std::string state = state_of(one.intake); !state.empty()) states += " " + state;
    if (const auto needed = inverse_dynamics(r, vehicle, o)) states += " " + in_words(*needed, vehicle);
    if (scope_of(r) == AnalysisScope::sensors) add_detectability_with_rotor_speeds(r, vehicle, o, one.intake);
    states += detectability_in_words(one.intake);
    if (&r == &flown.front())
      d.intake = std::move(one.intake);
    else
      d.further.push_back(std::move(one.intake));
  }
  d.summary = "The physics cannot be judged: " + why + ". The sensors were, by themselves";
  d.summary += d.findings.empty() ? ": no fault is seen." : ":";
  for (const Finding& f : d.findings) d.summary += " " + f.sentence;
  d.summary += states;
  if (!d.intake.missing.empty()) {
    d.summary += " What is missing costs:";
    for (const MissingSignal& m : d.intake.missing) d.summary += " " + m.signal + " - " + m.costs + ".";
    d.summary += " Record '" + d.intake.missing.front().signal + "' first.";
  }
  d.summary += " Nothing was fitted.";
  return d;
}

}  // namespace omniflight::diagnosis
