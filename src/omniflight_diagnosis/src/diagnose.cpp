// The way from recordings to a diagnosis, step by step.
#include <algorithm>

#include "actuation.hpp"
#include "agreement.hpp"
#include "balance.hpp"
#include "bursts.hpp"
#include "control_replay.hpp"
#include "course.hpp"
#include "experiment_design/next_flight.hpp"
#include "findings.hpp"
#include "floor_height.hpp"
#include "improvement.hpp"
#include "imu_place.hpp"
#include "instrument_estimate.hpp"
#include "intake.hpp"
#include "lever.hpp"
#include "locate.hpp"
#include "missing.hpp"
#include "offered.hpp"
#include "propose.hpp"
#include "remainder.hpp"
#include "repair.hpp"
#include "report/answer.hpp"
#include "report/other_stages.hpp"
#include "rollout.hpp"
#include "sanity.hpp"
#include "sensors_alone.hpp"
#include "shooting.hpp"
#include "single_rotor.hpp"
#include "text.hpp"
#include "together.hpp"
#include "uncertainty.hpp"
#include "validation/held_out.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;

/// The sensors of a recording that is not fitted.
void add_other(const Diagnosis& one, Diagnosis& d) {
  add_recording(one, one.inputs[0].file, d);
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
    if (reach_of(r) == Reach::motors) motors.push_back(r);
  if (motors.empty()) return diagnose_sensors(fit, vehicle, o, hindrance(fit[0]));
  const auto yardstick = balance_yardstick(vehicle, o);
  if (!yardstick) return Failure(yardstick.error());
  auto d = diagnose_balance(motors, vehicle, *yardstick);
  if (!d) {
    const bool others = std::any_of(fit.begin(), fit.end(), [](const recording::Recording& r) {
      return r.find("acc") || r.find("gyro") || r.find("position") || r.find("attitude");
    });
    if (!others) return d;
    return diagnose_sensors(fit, vehicle, o, hindrance(motors[0]) + ", and " + d.error().message);
  }
  const std::vector<Input> steady = d->inputs;
  d->inputs.clear();
  auto next = steady.begin();
  for (const recording::Recording& r : fit) {
    Diagnosis one = judge_sensors_of(r, vehicle, o);
    if (reach_of(r) == Reach::motors)
      one.inputs[0].excluded = (next++)->excluded;
    else
      d->left_out.push_back("the motors of " + r.file + " (" + hindrance(r) + ")");
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
    add_recording(faults, fitted[k].recording.file, d);
  }
  const std::vector<Finding> named = d.findings;  // what these explain is not asked again
  for (std::size_t k = 0; k < fitted.size(); ++k) {
    Diagnosis one;
    one.findings = named;
    add_agreement(fitted[k].recording, vehicle, o, one);
    one.findings.erase(one.findings.begin(),
                       one.findings.begin() + static_cast<std::ptrdiff_t>(named.size()));
    add_recording(one, fitted[k].recording.file, d);
  }
}

/// Recordings of one reach, with what stands for them.
struct Chosen {
  std::vector<recording::Recording> fit, held_out;
  Options options;
  std::vector<Diagnosis> others;  ///< of those that carry none
  std::vector<std::string> left_out;
};

/// Beside flights that carry a wrench, those that do not are judged by their sensors only.
Chosen with_a_wrench(std::span<const recording::Recording> fit,
                     std::span<const recording::Recording> held_out, const vehicle::Vehicle& vehicle,
                     const Options& o) {
  Chosen c;
  c.options = o;
  const bool again = o.refly.size() == fit.size();
  if (again) c.options.refly.clear();
  for (std::size_t k = 0; k < fit.size(); ++k) {
    if (reach_of(fit[k]) == Reach::wrench) {
      c.fit.push_back(fit[k]);
      if (again) c.options.refly.push_back(o.refly[k]);
      continue;
    }
    c.others.push_back(judge_sensors_of(at_origin(fit[k], o.imu_position), vehicle, o));
    c.left_out.push_back("the wrench in " + fit[k].file + " (" + hindrance(fit[k]) + ")");
  }
  for (const recording::Recording& r : held_out)
    if (reach_of(r) == Reach::wrench)
      c.held_out.push_back(r);
    else
      c.left_out.push_back("the prediction of " + r.file + " (" + hindrance(r) + ")");
  return c;
}

/// What the stages beside the wrench show: allocation, actuation, control, sensing.
void add_other_stages(std::span<const Repaired> fitted, const std::vector<Flight>& flights,
                      const vehicle::Vehicle& vehicle,
                      const std::vector<std::vector<ActuationFit>>& actuation,
                      const std::vector<Diagnosis>& of_sensors, const Options& o, Diagnosis& d) {
  for (const Repaired& one : fitted) {
    Diagnosis allocation;
    allocation.mismatch = locate_allocation(one.recording);
    add_recording(allocation, one.recording.file, d);
  }
  add_actuation(actuation, d);
  if (o.has_controller) {
    std::vector<const recording::Recording*> flown;
    for (const Repaired& one : fitted) flown.push_back(&one.recording);
    add_controls(flown, o.controller, d, attitude_is_free(vehicle, flown));
  }
  add_sensors(fitted, flights, vehicle, o, d);
  drop_what_a_sensor_explains(d);
  for (std::size_t k = 0; k < fitted.size(); ++k) add_recording(of_sensors[k], fitted[k].recording.file, d);
}

/// How the rotors of each flight follow their commands; a delay that all share is noted at the flight.
std::vector<std::vector<ActuationFit>> actuation_of(std::span<const Repaired> fitted,
                                                    const vehicle::Vehicle& vehicle,
                                                    std::vector<Flight>& flights) {
  std::vector<std::vector<ActuationFit>> out;
  for (std::size_t k = 0; k < fitted.size(); ++k) {
    if (flights[k].speed_from_command) continue;
    out.push_back(fit_actuation(fitted[k].recording, vehicle, flights[k]));
    if (const std::string note = on_shared_delay(out.back()); !note.empty()) flights[k].notes.push_back(note);
  }
  return out;
}

/// How well what the posterior names predicts what it was not fitted to.
void add_validation(const Inference& inference, const std::vector<const Flight*>& usable,
                    const std::vector<Flight>& flights, const std::vector<Flight>& unseen,
                    const vehicle::Vehicle& vehicle, const Options& o, Diagnosis& d) {
  const std::vector<std::size_t> named = named_members(inference);
  d.fit.held_out = on_unseen_flights(inference, named, unseen, vehicle, o);
  if (unseen.empty() && flights.size() == 1)
    d.fit.held_out = on_thirds(inference, named, flights[0], vehicle, o);
  if (o.rollouts && !o.stopped())
    d.fit.rollout = rollouts(unseen.empty() ? usable : pointers(unseen), vehicle, d.model, o);
}

/// Effects that could not be asked for, and why, as decisions.
void add_not_asked(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle, const Options& o,
                   Diagnosis& d) {
  for (const physics::Effect* effect : physics::builtin_effects())
    if (const std::string why = why_not_offered(*effect, flights, vehicle, o); !why.empty())
      d.decisions.push_back({effect->info().id, "whether these recordings can show it", 0, 0,
                             "signals of the recordings, and options", "not asked: " + why});
}

}  // namespace

Result<Diagnosis> diagnose(std::span<const recording::Recording> fit,
                           std::span<const recording::Recording> held_out, const vehicle::Vehicle& vehicle,
                           const Options& o) {
  if (fit.empty()) return bad_input("no recording to diagnose", "", "Name at least one recording");
  if (auto valid = vehicle::validate(vehicle); !valid) return tl::unexpected(valid.error());
  const auto lacks = [](const recording::Recording& r) { return reach_of(r) != Reach::wrench; };
  if (!o.baseline.empty() &&
      std::any_of(fit.begin(), fit.end(), [](const auto& r) { return reach_of(r) != Reach::motors; }))
    return bad_input("a baseline is compared only where the motors, and nothing but them, can be judged",
                     fit.front().file,
                     "Diagnose both flights without --baseline and compare their parameters");
  // what is fitted or predicted is without copies, freezes and clipping
  std::vector<Repaired> fitted, predicted;
  for (const recording::Recording& r : fit) fitted.push_back(in_order(r, o));
  for (const recording::Recording& r : held_out) predicted.push_back(in_order(r, o));
  for (const auto* list : {&fitted, &predicted}) {
    for (const Repaired& r : *list) {
      auto against = objections(r.recording, vehicle, o);
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
    auto d = diagnose(c.fit, c.held_out, vehicle, c.options);
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
        take_out(*errors, *f);
        if (list == &fitted) add_kinematics(*errors, of_sensors[flights.size()]);
      }
      d.inputs.push_back({f->file, f->sha256, f->duration_s, f->signals, f->excluded});
      (list == &fitted ? flights : unseen).push_back(std::move(*f));
    }
  }
  if (const auto height = hub_height(flights, vehicle, o))
    for (auto* list : {&flights, &unseen})
      for (Flight& f : *list) put_floor(*height, f);
  if (o.engine == Engine::posterior) {
    const auto late = actuation_of(fitted, vehicle, flights);
    const std::vector<const Flight*> usable = with_honest_speeds(flights);
    d.intake = describe(fitted[0].recording, flights[0]);
    for (std::size_t k = 1; k < fit.size(); ++k)
      d.further.push_back(describe(fitted[k].recording, flights[k]));
    if (!usable.empty()) {
      const Inference inference =
          infer(usable, vehicle, by_rotor(offered_effects(usable, vehicle, o), vehicle), o);
      add_posterior(inference, usable, d);
      add_not_asked(usable, vehicle, o, d);
      add_validation(inference, usable, flights, unseen, vehicle, o, d);
      add_next_flight(inference, usable, vehicle, o, d);
    } else {
      flights[0].notes.push_back(
          "With a stuck rotor speed the wrench cannot be judged; only the sensors were.");
    }
    Diagnosis others;
    add_other_stages(fitted, flights, vehicle, late, of_sensors, o, others);
    add_judged(others, vehicle, o, d);
    d.tracking_rms = tracking_rms_of(flights[0]);
    if (o.stopped()) mark_unfinished(d);
    d.summary = summarise(d, flights);
    return d;
  }
  Course course(flights, vehicle, o, d.inputs);
  if (course.blind())
    flights[0].notes.push_back(
        "With a stuck rotor speed the wrench cannot be judged; only the sensors were.");
  const auto actuation = actuation_of(fitted, vehicle, flights);
  d.intake = describe(fitted[0].recording, flights[0]);
  for (std::size_t k = 1; k < fit.size(); ++k) d.further.push_back(describe(fitted[k].recording, flights[k]));
  Diagnosis motors;  // they follow late with whatever pushes the body, and turn the thrusts of a flight again
  add_actuation(actuation, motors);
  if (const physics::Effect* overlooked = course.name(motors.model)) {
    Options measured_only = o;
    measured_only.refly.clear();
    auto again = diagnose(fit, held_out, vehicle, measured_only);
    if (again)
      again->summary += " The flight flown again without disturbance does not show what " +
                        overlooked->info().term +
                        " does here: the names come from the measured flight alone.";
    return again;
  }
  const Problem &problem = course.problem(), &all = course.all();
  const Problem* const measured = course.measured();
  const std::vector<const Flight*>& used = course.used();
  Naming& naming = course.naming();
  const auto estimate = [&] {
    if (naming.model.effects.empty()) return;
    naming.model = settle(problem, naming.model, o);
    if (!measured) {
      if (auto better = refine_by_shooting(course.named_on(), vehicle, problem, naming.model, o)) {
        naming.model = std::move(better->fit);
        d.fit.shooting = better->summary;
      }
      return;
    }
    if (auto better = by_instruments(problem, *measured, naming.model, settled_offsets(problem, naming.model),
                                     uncertainty_of(problem, naming.model).se))
      naming.model = std::move(*better);
  };
  estimate();
  std::vector<Term> terms;
  if (measured) {
    terms = terms_beside(problem, naming, o);
    for (int weak = 0; (weak = weakest_name(problem, naming, terms)) >= 0;) {
      naming.named.erase(naming.named.begin() + weak);
      naming.model.effects.erase(naming.model.effects.begin() + weak);
      naming.model = fit_effects(problem, naming.model.effects, o);
      estimate();
      terms = terms_beside(problem, naming, o);
    }
  }
  d.candidates = naming.candidates;
  d.aliases = naming.aliases;
  if (!course.blind()) d.mismatch = locate_wrench(problem, naming.null_model, naming.model, used, o);
  add_wrench_findings(problem, naming, d);
  std::vector<ActiveEffect> model = naming.model.effects;  // of what moves the body, with what has no name
  if (!course.blind()) {
    if (!measured) {
      d.unexplained = locate_unexplained(problem, naming.model, o);
    } else {
      d.unexplained = as_unexplained(problem, terms, naming.model.residual);
      for (const Unexplained& u : d.unexplained)
        for (const CorrectionTerm& term : u.correction)
          if (term.model) model.push_back(physics::as_effect(*term.model));
      d.model.insert(d.model.end(), model.begin() + static_cast<std::ptrdiff_t>(naming.model.effects.size()),
                     model.end());
    }
    Eigen::VectorXd before, after;
    all.predict({}, naming.model.offsets, before, nullptr);
    all.predict(naming.model.effects, naming.model.offsets, after, nullptr);
    add_bursts(all, before, after, d);
  }
  add_other_stages(fitted, flights, vehicle, actuation, of_sensors, o, d);

  // before and after, on what the fit saw and on what it did not see
  Eigen::VectorXd rest;
  problem.predict(model, naming.model.offsets, rest, nullptr);
  d.fit.in_sample = on_fitted(problem, rest);
  d.fit.held_out = on_unseen(unseen, vehicle, model, o);
  if (unseen.empty() && flights.size() == 1 && !model.empty() && !o.stopped())
    d.fit.held_out = on_unseen_thirds(flights[0], vehicle, model, o);
  if (o.rollouts && !o.stopped())
    d.fit.rollout = rollouts(unseen.empty() ? used : pointers(unseen), vehicle, model, o);
  for (const Flight& f : flights) d.series.push_back(series_of(f, vehicle, o, model, naming.model.offsets));
  d.tracking_rms = tracking_rms_of(flights[0]);

  const bool ambiguous =
      std::any_of(d.findings.begin(), d.findings.end(), [](const Finding& f) { return f.rivals > 0; });
  if (ambiguous && !o.stopped()) {
    std::vector<Rivals> pairs;
    for (std::size_t k = 0; k < naming.model.effects.size(); ++k)
      for (Rivals& pair : rivals_of(naming, k)) pairs.push_back(std::move(pair));
    d.next_flight.proposed = propose_flights(problem, *used.front(), vehicle, pairs, o);
  }
  d.left_out = naming.left_out;
  if (!d.unexplained.empty())
    d.verdict = Verdict::unexplained;
  else if (ambiguous)
    d.verdict = Verdict::ambiguous;
  else if (!d.findings.empty())
    d.verdict = Verdict::explained;
  else
    d.verdict = Verdict::nothing_missing;
  if (o.stopped()) mark_unfinished(d);
  d.summary = summarise(d, flights);
  return d;
}

}  // namespace omniflight::diagnosis
