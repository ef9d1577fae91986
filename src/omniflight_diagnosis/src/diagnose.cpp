// The way from recordings to a diagnosis, step by step.
#include <algorithm>

#include "conditioning/analysis_scope.hpp"
#include "conditioning/imu_place.hpp"
#include "conditioning/input_validation.hpp"
#include "conditioning/pointers.hpp"
#include "conditioning/reference_motion.hpp"
#include "conditioning/repair.hpp"
#include "drive/drive_inference.hpp"
#include "experiment_design/next_flight.hpp"
#include "numerics/text.hpp"
#include "report/answer.hpp"
#include "report/intake.hpp"
#include "report/other_stages.hpp"
#include "search/floor_height.hpp"
#include "search/offered_effects.hpp"
#include "search/single_rotor.hpp"
#include "sensor_checks/allocation_check.hpp"
#include "sensor_checks/control_replay.hpp"
#include "sensor_checks/findings.hpp"
#include "sensor_checks/lever_arm.hpp"
#include "sensor_checks/merge_recordings.hpp"
#include "sensor_checks/motor_balance.hpp"
#include "sensor_checks/redundancy_check.hpp"
#include "sensors_alone.hpp"
#include "validation/held_out.hpp"
#include "validation/improvement.hpp"
#include "validation/rollout.hpp"

namespace omniflight::diagnosis {
namespace {

/// The sensors of a recording that is not fitted.
void add_other(const Diagnosis& one, Diagnosis& d) {
  merge_recording(one, one.inputs[0].file, d);
  for (const Finding& f : one.findings) d.summary += " In " + one.inputs[0].file + ": " + f.sentence;
  if (d.verdict == Verdict::nothing_missing && !d.findings.empty()) d.verdict = Verdict::explained;
  d.inputs.push_back(one.inputs[0]);
  d.further.push_back(one.intake);
}

/// No recording carries a wrench: the balance of the motors where they were recorded, and the sensors.
Result<Diagnosis> without_a_wrench(std::span<const recording::Recording> fit, const vehicle::Vehicle& vehicle,
                                   const Options& o) {
  std::vector<recording::Recording> motors;
  for (const recording::Recording& r : fit)
    if (scope_of(r) == AnalysisScope::motors) motors.push_back(r);
  if (motors.empty()) return diagnose_sensors(fit, vehicle, o, missing_reason(fit[0]));
  const auto yardstick = balance_yardstick(vehicle, o);
  if (!yardstick) return Failure(yardstick.error());
  auto d = diagnose_balance(motors, vehicle, *yardstick);
  if (!d) {
    const bool others = std::any_of(fit.begin(), fit.end(), [](const recording::Recording& r) {
      return r.find("acc") || r.find("gyro") || r.find("position") || r.find("attitude");
    });
    if (!others) return d;
    return diagnose_sensors(fit, vehicle, o, missing_reason(motors[0]) + ", and " + d.error().message);
  }
  const std::vector<Input> steady = d->inputs;
  d->inputs.clear();
  auto next = steady.begin();
  for (const recording::Recording& r : fit) {
    Diagnosis one = judge_sensors_of(r, vehicle, o);
    if (scope_of(r) == AnalysisScope::motors)
      one.inputs[0].excluded = (next++)->excluded;
    else
      d->left_out.push_back("the motors of " + r.file + " (" + missing_reason(r) + ")");
    add_other(one, *d);
  }
  d->intake = d->further.front();
  d->further.erase(d->further.begin());
  return d;
}

/// Every flight's sensors against themselves and against each other.
void add_sensors(std::span<const Repaired> fitted, const std::vector<Flight>& flights,
                 const vehicle::Vehicle& vehicle, const Options& o, Diagnosis& d) {
  for (std::size_t k = 0; k < fitted.size(); ++k) {
    Diagnosis faults;
    add_faults(flights[k].faults, flights[k].excluded, faults);
    merge_recording(faults, fitted[k].recording.file, d);
  }
  const std::vector<Finding> named = d.findings;  // what these explain is not asked again
  for (std::size_t k = 0; k < fitted.size(); ++k) {
    Diagnosis one;
    one.findings = named;
    check_redundancy(fitted[k].recording, vehicle, o, one);
    one.findings.erase(one.findings.begin(),
                       one.findings.begin() + static_cast<std::ptrdiff_t>(named.size()));
    merge_recording(one, fitted[k].recording.file, d);
  }
}

/// Recordings of one reach, with what stands for them.
struct Chosen {
  std::vector<recording::Recording> fit, held_out;
  std::vector<Diagnosis> others;  ///< of those that carry none
  std::vector<std::string> left_out;
};

/// Beside flights that carry a wrench, those that do not are judged by their sensors only.
Chosen with_a_wrench(std::span<const recording::Recording> fit,
                     std::span<const recording::Recording> held_out, const vehicle::Vehicle& vehicle,
                     const Options& o) {
  Chosen c;
  for (std::size_t k = 0; k < fit.size(); ++k) {
    if (scope_of(fit[k]) == AnalysisScope::wrench) {
      c.fit.push_back(fit[k]);
      continue;
    }
    c.others.push_back(judge_sensors_of(at_origin(fit[k], o.imu_position), vehicle, o));
    c.left_out.push_back("the wrench in " + fit[k].file + " (" + missing_reason(fit[k]) + ")");
  }
  for (const recording::Recording& r : held_out)
    if (scope_of(r) == AnalysisScope::wrench)
      c.held_out.push_back(r);
    else
      c.left_out.push_back("the prediction of " + r.file + " (" + missing_reason(r) + ")");
  return c;
}

/// What the stages beside the wrench show: allocation, actuation, control, sensing.
void add_other_stages(std::span<const Repaired> fitted, const std::vector<Flight>& flights,
                      const vehicle::Vehicle& vehicle, const DriveInference& drives,
                      const std::vector<Diagnosis>& of_sensors, const Options& o, Diagnosis& d) {
  for (const Repaired& one : fitted) {
    Diagnosis allocation;
    allocation.mismatch = locate_allocation(one.recording);
    merge_recording(allocation, one.recording.file, d);
  }
  add_drives(drives, vehicle, o, d);
  if (o.has_controller) {
    std::vector<const recording::Recording*> flown;
    for (const Repaired& one : fitted) flown.push_back(&one.recording);
    add_controls(flown, o.controller, d, attitude_is_free(vehicle, flown));
  }
  add_sensors(fitted, flights, vehicle, o, d);
  for (std::size_t k = 0; k < fitted.size(); ++k) merge_recording(of_sensors[k], fitted[k].recording.file, d);
}

/// How the rotors follow their commands; a delay that all boards share is noted at the first flight.
/// `usable`: of the flights, those whose speeds can be believed.
DriveInference drives_of(std::span<const Repaired> fitted, const std::vector<const Flight*>& usable,
                         const vehicle::Vehicle& vehicle, const Options& o, std::vector<Flight>& flights) {
  std::vector<const recording::Recording*> recordings;
  std::vector<const Flight*> flown;
  for (const Flight* f : usable)
    if (!f->speed_from_command) {
      recordings.push_back(&fitted[static_cast<std::size_t>(f - flights.data())].recording);
      flown.push_back(f);
    }
  DriveInference out = infer_drives(recordings, flown, vehicle, o);
  if (const std::string note = on_shared_delay(out); !note.empty()) flights.front().notes.push_back(note);
  return out;
}

/// How well what the posterior names predicts what it was not fitted to.
void add_validation(const Inference& inference, const SetFit& named, const std::vector<const Flight*>& usable,
                    const std::vector<Flight>& flights, const std::vector<Flight>& unseen,
                    const vehicle::Vehicle& vehicle, const Options& o, Diagnosis& d) {
  d.fit.held_out = on_unseen_flights(inference, named, unseen, vehicle, o);
  if (unseen.empty() && flights.size() == 1)
    d.fit.held_out = on_thirds(inference, named, flights[0], vehicle, o);
  if (o.rollouts && !o.stopped())
    d.fit.rollout = rollouts(unseen.empty() ? usable : pointers_to(unseen), vehicle, d.model, o);
}

/// Effects that could not be asked for, and why, as decisions.
void add_not_asked(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle, const Options& o,
                   Diagnosis& d) {
  for (const physics::Effect* effect : physics::builtin_effects())
    if (const std::string why = why_not_offered(*effect, flights, vehicle, o); !why.empty())
      d.decisions.push_back({effect->info().id, "whether these recordings can show it", 0, 0,
                             "signals of the recordings, and options", "not asked: " + why});
}

/// Everything that the wrench of these flights tells.
void infer_the_wrench(const std::vector<const Flight*>& usable, const std::vector<Flight>& flights,
                      const std::vector<Flight>& unseen, const vehicle::Vehicle& vehicle, const Options& o,
                      Diagnosis& d) {
  const Inference inference =
      infer(usable, vehicle, by_rotor(offered_effects(usable, vehicle, o), vehicle), o);
  const SetFit named = named_set(inference, o);
  add_posterior(inference, named, usable, d);
  add_not_asked(usable, vehicle, o, d);
  add_validation(inference, named, usable, flights, unseen, vehicle, o, d);
  add_next_flight(inference, usable, vehicle, o, d);
}

}  // namespace

Result<Diagnosis> diagnose(std::span<const recording::Recording> fit,
                           std::span<const recording::Recording> held_out, const vehicle::Vehicle& vehicle,
                           const Options& o) {
  if (fit.empty()) return bad_input("no recording to diagnose", "", "Name at least one recording");
  if (auto valid = vehicle::validate(vehicle); !valid) return tl::unexpected(valid.error());
  const auto lacks = [](const recording::Recording& r) { return scope_of(r) != AnalysisScope::wrench; };
  if (!o.baseline.empty() &&
      std::any_of(fit.begin(), fit.end(), [](const auto& r) { return scope_of(r) != AnalysisScope::motors; }))
    return bad_input("a baseline is compared only where the motors, and nothing but them, can be judged",
                     fit.front().file,
                     "Diagnose both flights without --baseline and compare their parameters");
  // what is fitted or predicted is without copies, freezes and clipping
  std::vector<Repaired> fitted, predicted;
  for (const recording::Recording& r : fit) fitted.push_back(in_order(r, o));
  for (const recording::Recording& r : held_out) predicted.push_back(in_order(r, o));
  for (const auto* list : {&fitted, &predicted}) {
    for (const Repaired& r : *list) {
      auto against = validate_input(r.recording, vehicle, o);
      if (!against) return tl::unexpected(against.error());
      if (!against->empty()) return unusable(r.recording, *against);
    }
  }
  if (std::all_of(fit.begin(), fit.end(), lacks)) {
    std::vector<recording::Recording> ordered;
    for (const Repaired& r : fitted) ordered.push_back(r.recording);
    auto d = without_a_wrench(ordered, vehicle, o);
    for (const recording::Recording& r : held_out)
      if (d)
        d->left_out.push_back("the prediction of " + r.file + " (nothing was fitted that predicts a wrench)");
    return d;
  }
  if (std::any_of(fit.begin(), fit.end(), lacks) || std::any_of(held_out.begin(), held_out.end(), lacks)) {
    const Chosen c = with_a_wrench(fit, held_out, vehicle, o);
    auto d = diagnose(c.fit, c.held_out, vehicle, o);
    if (!d) return d;
    for (const Diagnosis& one : c.others) add_other(one, *d);
    for (const std::string& what : c.left_out) d->summary += " Left out: " + what + ".";
    d->left_out.insert(d->left_out.end(), c.left_out.begin(), c.left_out.end());
    return d;
  }
  Diagnosis d;
  std::vector<Flight> flights, unseen;
  std::vector<Diagnosis> of_sensors(fit.size());
  for (const auto* list : {&fitted, &predicted}) {
    for (const Repaired& one : *list) {
      const recording::Recording& r = one.recording;
      auto f = prepare_repaired(one, vehicle, o);
      if (!f) return tl::unexpected(f.error());
      if (auto errors = judge_kinematics(r, o)) {
        attribute_lever(*f, vehicle, o, *errors);
        compensate(*errors, *f);
        if (list == &fitted) add_kinematics(*errors, of_sensors[flights.size()]);
      }
      d.inputs.push_back({f->file, f->sha256, f->duration_s, f->signals, f->excluded});
      (list == &fitted ? flights : unseen).push_back(std::move(*f));
    }
  }
  if (const auto height = hub_height(flights, vehicle, o))
    for (auto* list : {&flights, &unseen})
      for (Flight& f : *list) set_floor_height(*height, f);
  const std::vector<const Flight*> usable = with_honest_speeds(flights);
  const DriveInference drives = drives_of(fitted, usable, vehicle, o, flights);
  d.intake = describe(fitted[0].recording, flights[0]);
  for (std::size_t k = 1; k < fit.size(); ++k) d.further.push_back(describe(fitted[k].recording, flights[k]));
  if (!usable.empty())
    infer_the_wrench(usable, flights, unseen, vehicle, o, d);
  else
    flights[0].notes.push_back(
        "With a stuck rotor speed the wrench cannot be judged; only the sensors were.");
  Diagnosis others;
  add_other_stages(fitted, flights, vehicle, drives, of_sensors, o, others);
  add_judged(others, vehicle, o, d);
  drop_what_a_sensor_explains(d);
  d.tracking_rms = tracking_rms_of(flights[0]);
  if (o.stopped()) mark_unfinished(d);
  d.summary = summarise(d, flights);
  return d;
}

}  // namespace omniflight::diagnosis
