// The way from recordings to a diagnosis, step by step.
#include <algorithm>
#include <cmath>
#include <memory>

#include "actuation.hpp"
#include "agreement.hpp"
#include "balance.hpp"
#include "bursts.hpp"
#include "control_replay.hpp"
#include "findings.hpp"
#include "ground_law.hpp"
#include "improvement.hpp"
#include "instrument_estimate.hpp"
#include "instruments.hpp"
#include "intake.hpp"
#include "lever.hpp"
#include "locate.hpp"
#include "naming.hpp"
#include "offered.hpp"
#include "propose.hpp"
#include "remainder.hpp"
#include "rollout.hpp"
#include "sanity.hpp"
#include "shooting.hpp"
#include "single_rotor.hpp"
#include "text.hpp"
#include "uncertainty.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;

std::vector<const Flight*> pointers(const std::vector<Flight>& flights) {
  std::vector<const Flight*> out;
  for (const Flight& f : flights) out.push_back(&f);
  return out;
}

/// What a model's effects do to the body in every flight [N, Nm], a row a sample; held where nothing is
/// known.
std::vector<Eigen::MatrixXd> wrench_of(const Problem& problem, const Fit& model,
                                       const std::vector<const Flight*>& flights) {
  Eigen::VectorXd without, with;
  problem.predict({}, model.offsets, without, nullptr);
  problem.predict(model.effects, model.offsets, with, nullptr);
  const Eigen::VectorXd own = without - with;
  const int n = problem.samples();
  std::vector<Eigen::MatrixXd> out;
  int row = 0;
  for (const Flight* flight : flights) {
    Eigen::MatrixXd& w = out.emplace_back(Eigen::MatrixXd::Zero(flight->size(), 6));
    int filled = 0;
    for (const Segment& s : flight->segments)
      for (int i = s.begin; i < s.end; ++i, ++row) {
        for (int c = 0; c < 6; ++c) w(i, c) = own[c * n + row];
        for (; filled < i; ++filled) w.row(filled) = filled > 0 ? w.row(filled - 1).eval() : w.row(i);
        ++filled;
      }
    for (; filled > 0 && filled < flight->size(); ++filled) w.row(filled) = w.row(filled - 1);
  }
  return out;
}

/// The answer about a recording that cannot be believed.
Diagnosis unusable(const recording::Recording& r, const std::vector<std::string>& against) {
  Diagnosis d;
  d.verdict = Verdict::unusable;
  d.inputs.push_back({r.file, r.sha256, r.duration_s, {}, {}});
  for (const std::string& name : r.signal_names())
    if (name.rfind("truth_", 0) != 0) d.inputs.back().signals.push_back(name);
  d.summary = "This recording cannot be used as it is:";
  for (const std::string& text : against) d.summary += " " + text + ".";
  d.summary += " Nothing was fitted.";
  return d;
}

}  // namespace

Result<Diagnosis> diagnose(std::span<const recording::Recording> fit,
                           std::span<const recording::Recording> held_out, const vehicle::Vehicle& vehicle,
                           const Options& o) {
  if (fit.empty()) return bad_input("no recording to diagnose", "", "Name at least one recording");
  if (auto valid = vehicle::validate(vehicle); !valid) return tl::unexpected(valid.error());
  Diagnosis d;
  if (fit.size() == 1 && only_motors(fit[0])) {
    if (auto against = objections(fit[0], vehicle, o); !against)
      return tl::unexpected(against.error());
    else if (!against->empty())
      return unusable(fit[0], *against);
    return diagnose_balance(fit[0], vehicle, o);
  }
  for (const auto* list : {&fit, &held_out}) {
    for (const recording::Recording& r : *list) {
      auto against = objections(r, vehicle, o);
      if (!against) return tl::unexpected(against.error());
      if (!against->empty()) return unusable(r, *against);
    }
  }
  std::vector<Flight> flights, unseen;
  Diagnosis of_sensors;
  for (const auto* list : {&fit, &held_out}) {
    for (const recording::Recording& r : *list) {
      auto f = prepare_flight(r, vehicle, o);
      if (!f) return tl::unexpected(f.error());
      if (auto errors = judge_kinematics(r, o)) {
        attribute_lever(*f, vehicle, o, *errors);
        take_out(*errors, *f);
        if (d.inputs.empty()) add_kinematics(*errors, of_sensors);
      }
      d.inputs.push_back({f->file, f->sha256, f->duration_s, f->signals, f->excluded});
      (list == &fit ? flights : unseen).push_back(std::move(*f));
    }
  }
  // a flight whose rotor speeds lie says nothing about the wrench
  std::vector<const Flight*> used;
  for (const Flight& f : flights)
    if (std::none_of(f.faults.begin(), f.faults.end(),
                     [](const SensorFault& fault) { return fault.effect == "rotor_speed_sensor_fault"; }))
      used.push_back(&f);
  const bool blind = used.empty();
  if (blind) {
    used = pointers(flights);
    flights[0].notes.push_back(
        "With a stuck rotor speed the wrench cannot be judged; only the sensors were.");
  }
  auto all = std::make_unique<const Problem>(used, vehicle, o);
  const auto candidates = blind ? std::vector<const physics::Effect*>{} : offered_effects(used, vehicle, o);
  const auto hypotheses = with_single_rotors(candidates, vehicle);
  d.intake = describe(fit[0], flights[0]);
  // where the flight can be flown again, effects are judged free of feedback; once more with what was found,
  // since a load moves the working point of the rotors
  std::vector<Flight> freed;
  const std::vector<const Flight*> recorded = used;
  const auto free_of_feedback = [&](const std::vector<Eigen::MatrixXd>& known) {
    if (blind || o.refly.size() != flights.size()) return false;
    std::vector<Flight> found;
    for (std::size_t k = 0; k < recorded.size(); ++k) {
      const auto which = static_cast<std::size_t>(recorded[k] - flights.data());
      auto one = with_instruments(*recorded[k], known[k], vehicle, o, o.refly[which]);
      if (!one) return false;
      d.inputs[which].excluded = one->excluded;
      found.push_back(std::move(*one));
    }
    freed = std::move(found);
    used = pointers(freed);
    all = std::make_unique<const Problem>(used, vehicle, o);
    return true;
  };
  std::vector<Eigen::MatrixXd> nothing;
  for (const Flight* f : recorded) nothing.emplace_back(Eigen::MatrixXd::Zero(f->size(), 6));
  free_of_feedback(nothing);
  Naming naming = name_effects(*all, hypotheses, o);
  if (!freed.empty() && !naming.model.effects.empty() && !o.stopped() &&
      free_of_feedback(wrench_of(*all, naming.model, used)))
    naming = name_effects(*all, hypotheses, o);
  // what comes and goes from outside must not be bent into an effect of the vehicle's own state
  std::vector<Flight> calm_flights;
  std::unique_ptr<const Problem> calm;
  const std::vector<Burst> bursts =
      blind ? std::vector<Burst>{} : find_bursts(*all, naming.null_model.residual);
  const bool offered = std::any_of(candidates.begin(), candidates.end(),
                                   [](const physics::Effect* e) { return e->info().id == "ground_effect"; });
  const double per_parameter = std::log(std::max(2.0, static_cast<double>(candidates.size())) / o.error_rate);
  const bool grounded = offered && !blind && follows_ground_law(*all, naming.null_model, per_parameter, o);
  const auto cut = [&](const Burst& b) {  // what the floor does stays in
    return !(grounded && b.force.z() > 0 && is_low(all->situation(0), b.place.z()));
  };
  if (std::any_of(bursts.begin(), bursts.end(), cut) &&
      explained_in_bursts(*all, naming.null_model.residual, naming.model.residual, bursts) < 0.7) {
    for (std::size_t k = 0; k < used.size(); ++k) {
      calm_flights.push_back(*used[k]);
      for (const Burst& b : bursts)
        if (b.flight == static_cast<int>(k) && cut(b))
          calm_flights.back() = part_of(calm_flights.back(), b.from_s - 0.5, b.to_s + 0.5, false);
    }
    const auto rest = pointers(calm_flights);
    calm = std::make_unique<const Problem>(rest, vehicle, o);
    if (calm->samples() < 4 * o.grid_hz)
      calm.reset();
    else
      naming = name_effects(*calm, hypotheses, o);
  }
  const Problem& problem = calm ? *calm : *all;
  if (grounded) add_ground_law(problem, per_parameter, o, naming);
  std::unique_ptr<const Problem> measured;  // the same samples, the state as it was measured
  if (!freed.empty()) {
    std::vector<Flight> seen = calm ? calm_flights : freed;
    for (Flight& f : seen) f.instrument = f.smooth;
    measured = std::make_unique<const Problem>(pointers(seen), vehicle, o);
  }
  const auto estimate = [&] {
    if (naming.model.effects.empty()) return;
    naming.model = settle(problem, naming.model, o);
    if (!measured) {
      std::vector<const Flight*> flown = calm ? pointers(calm_flights) : used;
      if (auto better = refine_by_shooting(flown, vehicle, problem, naming.model, o)) {
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
  if (!freed.empty()) {
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
  if (!blind) d.mismatch = locate_wrench(problem, naming.null_model, naming.model, used, o);
  add_wrench_findings(problem, naming, d);
  std::vector<ActiveEffect> model = naming.model.effects;  // of what moves the body, with what has no name
  if (!blind) {
    if (freed.empty()) {
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
    all->predict({}, naming.model.offsets, before, nullptr);
    all->predict(naming.model.effects, naming.model.offsets, after, nullptr);
    add_bursts(*all, before, after, d);
  }
  std::vector<std::vector<ActuationFit>> actuation;
  for (std::size_t k = 0; k < fit.size(); ++k) {
    if (!flights[k].speed_from_command) actuation.push_back(fit_actuation(fit[k], vehicle, flights[k]));
    if (k == 0)
      for (Mismatch& m : locate_allocation(fit[k])) d.mismatch.push_back(std::move(m));
  }
  add_actuation(actuation, d);
  if (o.has_controller) add_control(fit[0], o.controller, d);
  add_faults(flights, d);
  add_agreement(fit[0], vehicle, o, d);
  drop_what_a_sensor_explains(d);
  for (Finding& f : of_sensors.findings) d.findings.push_back(std::move(f));
  for (Mismatch& m : of_sensors.mismatch) d.mismatch.push_back(std::move(m));
  for (auto& pair : of_sensors.next_flight.separates) d.next_flight.separates.push_back(std::move(pair));
  for (auto& words : of_sensors.next_flight.manoeuvres) d.next_flight.manoeuvres.push_back(std::move(words));

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
  d.summary = summarise(d, flights);
  return d;
}

Result<Diagnosis> check(const recording::Recording& r, const vehicle::Vehicle& vehicle, const Options& o) {
  if (auto valid = vehicle::validate(vehicle); !valid) return tl::unexpected(valid.error());
  auto against = objections(r, vehicle, o);
  if (!against) return tl::unexpected(against.error());
  if (!against->empty()) return unusable(r, *against);
  Diagnosis d;
  if (only_motors(r)) {
    Flight none;
    d.intake = describe(r, none);
    d.inputs.push_back({r.file, r.sha256, r.duration_s, r.signal_names(), {}});
    d.summary =
        "No attitude or no force: only the balance of the motors in steady flight can be judged, that is a "
        "weak or "
        "damaged rotor and an offset centre of mass.";
    return d;
  }
  auto flight = prepare_flight(r, vehicle, o);
  if (!flight) return tl::unexpected(flight.error());
  std::vector<Flight> flights;
  flights.push_back(std::move(*flight));
  const Flight& f = flights[0];
  d.inputs.push_back({f.file, f.sha256, f.duration_s, f.signals, f.excluded});
  const auto used = pointers(flights);
  const Problem problem(used, vehicle, o);
  d.intake = describe(r, f);
  const auto candidates = offered_effects(used, vehicle, o);
  describe_candidates(problem, candidates, d.intake);
  add_faults(flights, d);
  double cut = 0;
  for (const Window& w : f.excluded) cut += w.to_s - w.from_s;
  d.summary = format("%.1f s of %.1f s can be used (%zu windows cut out). ", f.usable() / f.rate_hz,
                     f.duration_s, f.excluded.size());
  for (const Finding& x : d.findings) d.summary += x.sentence + " ";
  std::string blind;
  for (const Detectability& x : d.intake.detectability)
    if (x.sigma < 3) blind += (blind.empty() ? "" : ", ") + x.effect;
  if (!blind.empty()) d.summary += "Of ordinary size, this flight cannot show: " + blind + ". ";
  for (const auto& group : d.intake.alias_groups) {
    d.summary += "Look alike: ";
    for (std::size_t k = 0; k < group.size(); ++k) d.summary += (k > 0 ? ", " : "") + group[k];
    d.summary += ". ";
  }
  for (const std::string& note : f.notes) d.summary += note + " ";
  d.summary += "Nothing was fitted.";
  return d;
}

}  // namespace omniflight::diagnosis
