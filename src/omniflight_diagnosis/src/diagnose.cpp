// The way from recordings to a diagnosis, step by step.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "actuation.hpp"
#include "agreement.hpp"
#include "balance.hpp"
#include "bursts.hpp"
#include "control_replay.hpp"
#include "dictionary.hpp"
#include "ground_law.hpp"
#include "instrument_estimate.hpp"
#include "instruments.hpp"
#include "intake.hpp"
#include "lever.hpp"
#include "locate.hpp"
#include "naming.hpp"
#include "propose.hpp"
#include "rollout.hpp"
#include "sanity.hpp"
#include "single_rotor.hpp"
#include "statistics.hpp"
#include "uncertainty.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;

std::string format(const char* pattern, auto... values) {
  char text[400];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

std::vector<const Flight*> pointers(const std::vector<Flight>& flights) {
  std::vector<const Flight*> out;
  for (const Flight& f : flights) out.push_back(&f);
  return out;
}

/// The flight with only the samples inside (or only those outside) [from_s, to_s).
Flight part_of(const Flight& f, double from_s, double to_s, bool inside) {
  Flight out = f;
  out.segments.clear();
  const int settle = static_cast<int>(0.5 * f.rate_hz);
  for (const Segment& s : f.segments) {
    Segment open{-1, -1};
    for (int i = s.begin; i <= s.end; ++i) {
      const double t = i < s.end ? f.t[static_cast<std::size_t>(i)] : 0;
      const bool in = i < s.end && ((t >= from_s && t < to_s) == inside);
      if (in && open.begin < 0) open.begin = i;
      if (!in && open.begin >= 0) {
        if (i - open.begin > settle) out.segments.push_back({open.begin, i});
        open.begin = -1;
      }
    }
  }
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

/// RMS a channel and share explained, without and with effects: body wrench, specific force [m/s^2].
std::vector<ChannelFit> compare(const Flight& flight, const vehicle::Vehicle& vehicle, const Options& o,
                                const std::vector<ActiveEffect>& effects, const std::string& name) {
  std::vector<ChannelFit> out;
  const Flight* one[] = {&flight};
  const Problem problem(one, vehicle, o);
  const int n = problem.samples();
  if (n == 0) return out;
  std::vector<ActiveEffect> wrench;
  for (const ActiveEffect& e : effects)
    if (e.effect->can_replay()) wrench.push_back(e);
  Eigen::VectorXd after;
  problem.predict(wrench, Eigen::VectorXd::Zero(problem.offset_sigma().size()), after, nullptr);
  Eigen::VectorXd before = problem.residual();
  if (problem.forces_only()) {  // the scale of a modelled thrust comes from every flight anew, with any model
    const auto rotors = problem.offsets().col(0);
    for (Eigen::VectorXd* r : {&before, &after}) *r -= rotors.dot(*r) / rotors.squaredNorm() * rotors;
  }
  Eigen::VectorXd measured(6 * n);
  for (int i = 0; i < n; ++i) {
    const physics::Situation& s = problem.situation(i);
    const Vec3 force = s.mass * (s.a_WB_B - s.g_B), &w = s.body.w_WB_B;
    const Vec3 torque = s.inertia * s.dw_WB_B + w.cross(s.inertia * w);
    for (int c = 0; c < 3; ++c) measured[c * n + i] = force[c], measured[(c + 3) * n + i] = torque[c];
  }
  const auto explained = [&](const Eigen::VectorXd& left, int c) {
    const auto m = measured.segment(c * n, n).array();
    const auto l = left.segment(c * n, n).array();
    const double all = (m - m.mean()).square().sum();
    return all > 0 ? 1 - (l - l.mean()).square().sum() / all : std::nan("");
  };
  for (int c = 0; c < 6; ++c)
    out.push_back({name, kChannels[static_cast<std::size_t>(c)], channel_unit(c),
                   rms(before.segment(c * n, n)), rms(after.segment(c * n, n)), explained(before, c),
                   explained(after, c)});
  static constexpr const char* kAcceleration[] = {"ax", "ay", "az"};
  for (int c = 0; c < 3; ++c)
    out.push_back({name, kAcceleration[c], "m/s2", rms(before.segment(c * n, n)) / vehicle.mass,
                   rms(after.segment(c * n, n)) / vehicle.mass, explained(before, c), explained(after, c)});
  return out;
}

Series series_of(const Flight& flight, const vehicle::Vehicle& vehicle, const Options& o, const Fit& model) {
  const Flight* one[] = {&flight};
  const Problem problem(one, vehicle, o);
  Eigen::VectorXd after;
  problem.predict(model.effects, model.offsets, after, nullptr);
  const int n = problem.samples();
  Series s;
  s.file = flight.file;
  for (const char* c : kChannels) s.channels.emplace_back(c);
  s.channels.emplace_back("Fz_world");
  s.before.resize(7);
  s.after.resize(7);
  for (int i = 0; i < n; ++i) {
    const physics::Situation& x = problem.situation(i);
    s.t_s.push_back(x.t);
    s.height_m.push_back(x.body.p_WB.z());
    Vec3 up_before, up_after;
    for (int c = 0; c < 6; ++c) {
      s.before[static_cast<std::size_t>(c)].push_back(problem.residual()[c * n + i]);
      s.after[static_cast<std::size_t>(c)].push_back(after[c * n + i]);
      if (c < 3) up_before[c] = problem.residual()[c * n + i], up_after[c] = after[c * n + i];
    }
    s.before[6].push_back(x.R_WB.row(2).dot(up_before));
    s.after[6].push_back(x.R_WB.row(2).dot(up_after));
  }
  return s;
}

std::string values_in_words(const std::vector<ParameterValue>& parameters) {
  std::string out;
  for (const ParameterValue& p : parameters)
    out += format("%s%s = %.4g %s (95 %%: %.4g to %.4g)", out.empty() ? "" : ", ", p.name.c_str(), p.value,
                  p.unit == "1" ? "" : p.unit.c_str(), p.low, p.high);
  return out;
}

void add_wrench_findings(const Problem& problem, const Naming& naming, Diagnosis& d) {
  const Eigen::VectorXd se =
      naming.model.se.size() > 0 ? naming.model.se : uncertainty_of(problem, naming.model).se;
  Eigen::Index at = 0;
  const int n = problem.samples();
  for (std::size_t k = 0; k < naming.model.effects.size(); ++k) {
    const ActiveEffect& e = naming.model.effects[k];
    const physics::EffectInfo& info = e.effect->info();
    Finding f;
    f.effect = info.id;
    f.stage = info.stage;
    f.equation = info.equation;
    f.latex = info.latex;
    f.probability = naming.named[k].probability;
    for (const Alternative& a : naming.named[k].set) f.cannot_be_told_apart_from.push_back(a.effect);
    f.rivals = static_cast<int>(f.cannot_be_told_apart_from.size());
    for (const Alternative& a : naming.named[k].alike) f.cannot_be_told_apart_from.push_back(a.effect);
    const Eigen::VectorXd own = contribution_of(problem, naming.model, k);
    for (int c = 0; c < 6; ++c)
      if (rms(own.segment(c * n, n)) > 0.2 * rms(naming.model.residual.segment(c * n, n)))
        f.channels.emplace_back(kChannels[static_cast<std::size_t>(c)]);
    for (std::size_t p = 0; p < e.theta.size(); ++p, ++at) {
      const physics::Parameter& info_p = info.parameters[p];
      const double half = 1.96 * se[at];
      double low = e.theta[p] - half, high = e.theta[p] + half;
      if (const auto k_at = static_cast<std::size_t>(at); k_at < naming.model.plausible.size()) {
        low = std::min(low, naming.model.plausible[k_at].first);
        high = std::max(high, naming.model.plausible[k_at].second);
      }
      f.parameters.push_back({info_p.name, info_p.symbol, info_p.unit, e.theta[p],
                              std::max(info_p.lower, low), std::min(info_p.upper, high)});
    }
    f.sentence = info.term + ": " + values_in_words(f.parameters) + ".";
    if (f.rivals == 0 && !f.cannot_be_told_apart_from.empty()) {
      f.sentence += " Nearly alike on this flight, but less likely:";
      for (const std::string& id : f.cannot_be_told_apart_from) f.sentence += " " + id;
      f.sentence += ".";
    }
    if (f.rivals > 0) {
      f.sentence += " On this flight it cannot be told apart from";
      for (const std::string& id : f.cannot_be_told_apart_from) f.sentence += " " + id;
      f.sentence += "; " + info.separated_by + " would tell.";
      for (const Alternative& a : naming.named[k].set) {
        const std::string& id = a.effect;
        d.next_flight.separates.emplace_back(info.id, id);
      }
      d.next_flight.manoeuvres.push_back(info.separated_by);
    }
    d.findings.push_back(std::move(f));
    const ActiveEffect whole = in_full(e);
    const auto same = std::find_if(d.model.begin(), d.model.end(),
                                   [&](const ActiveEffect& m) { return m.effect == whole.effect; });
    if (same == d.model.end()) {
      d.model.push_back(whole);
    } else {  // two rotors, each found by itself
      for (std::size_t p = 0; p < whole.theta.size(); ++p)
        same->theta[p] += whole.theta[p] - whole.effect->info().parameters[p].neutral;
    }
  }
}

void add_faults(const std::vector<Flight>& flights, Diagnosis& d) {
  for (const Flight& f : flights)
    for (const SensorFault& fault : f.faults) {
      Finding finding;
      finding.effect = fault.effect;
      finding.probability = 0.99;
      finding.stage = physics::Stage::sensing;
      finding.channels = {fault.channel};
      finding.sentence = fault.sentence;
      finding.equation = "measured value does not follow the quantity";
      d.findings.push_back(finding);
      Mismatch m;
      m.stage = physics::Stage::sensing;
      m.channel = fault.channel;
      m.frame = fault.effect == "rotor_speed_sensor_fault" ? "rotor" : "body";
      m.unit = fault.effect == "rotor_speed_sensor_fault" ? "rad/s" : "V";
      m.where = format("%.0f %% of the flight", 100 * fault.share);
      m.p_value = 0;
      for (const Window& w : f.excluded)
        if (w.why.rfind(fault.channel, 0) == 0) m.windows_s.emplace_back(w.from_s, w.to_s);
      d.mismatch.push_back(m);
    }
}

std::string in_words(const CorrectionTerm& t) {
  std::string s = format("%.3g %s times ", t.coefficient, t.unit.c_str()) + t.words;
  if (t.frequency_hz > 0) s += format(" at %.2f Hz", t.frequency_hz);
  return s;
}

std::string summarise(const Diagnosis& d, const std::vector<Flight>& flights) {
  std::string s;
  if (d.findings.empty() && d.unexplained.empty() && d.mismatch.empty())
    s = "Nothing is missing: the rotors, the mass and the inertia of the vehicle file explain what was "
        "measured, "
        "within the noise and the tolerances of the sensors. ";
  else if (d.findings.empty() && d.unexplained.empty())
    s = "No left-out physics is named: what differs is too small, or what offsets within the tolerances may "
        "do. ";
  for (const Mismatch& m : d.mismatch)
    if (m.stage == physics::Stage::wrench)
      s += format("%s (%s frame) differs by %.3g %s where %.3g is noise%s%s. ", m.channel.c_str(),
                  m.frame.c_str(), m.rms, m.unit.c_str(), m.noise_rms, m.where.empty() ? "" : ": ",
                  m.where.c_str());
  for (const Finding& f : d.findings) s += "Found " + f.sentence + " ";
  for (const Unexplained& u : d.unexplained) {
    s += format(
        "Something in %s (%s frame) is not in the library: %.0f %% of what remains can still be "
        "predicted",
        u.channel.c_str(), u.frame.c_str(), 100 * u.share_of_residual);
    if (!u.correction.empty()) s += ", first by " + in_words(u.correction.front());
    s += ". ";
  }
  if (!d.left_out.empty()) {
    s += "Time was up; left out: ";
    for (std::size_t k = 0; k < d.left_out.size(); ++k) s += (k > 0 ? ", " : "") + d.left_out[k];
    s += ". ";
  }
  for (const Flight& f : flights) {
    for (const std::string& note : f.notes) s += note + " ";
    if (!f.notes.empty()) break;
  }
  if (const auto x = d.tracking_rms.find("pz"); x != d.tracking_rms.end() && !d.findings.empty())
    s += format("The tracking error shows little of it (vertical RMS %.1f mm).", 1e3 * x->second);
  while (!s.empty() && s.back() == ' ') s.pop_back();
  return s;
}

/// A rotor whose telemetry reads low by a share e seems to lift 2 e more than its speed says: once its sensor
/// is named, that is no effect of its own.
void drop_what_a_sensor_explains(Diagnosis& d) {
  for (const Finding& fault : d.findings) {
    if (fault.effect != "rotor_speed_sensor_fault" || fault.parameters.size() != 2) continue;
    const int rotor = static_cast<int>(fault.parameters[0].value);
    const double e = fault.parameters[1].value, as_thrust = 1 / ((1 + e) * (1 + e)) - 1;
    const auto seems = [&](const Finding& f) {
      return f.effect == "rotor_thrust_scale" && f.parameters.size() == 1 &&
             f.parameters[0].name == "scale_" + std::to_string(rotor) &&
             std::abs(f.parameters[0].value - as_thrust) < 0.4 * std::abs(as_thrust);
    };
    const auto at = std::find_if(d.findings.begin(), d.findings.end(), seems);
    if (at == d.findings.end()) continue;
    std::erase_if(d.model, [](const ActiveEffect& m) { return m.effect->info().id == "rotor_thrust_scale"; });
    d.findings.erase(at);
    return;
  }
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
  if (!naming.model.effects.empty()) naming.model = settle(problem, naming.model, o);
  if (!freed.empty() && !naming.model.effects.empty()) {
    std::vector<Flight> seen = calm ? calm_flights : freed;
    for (Flight& f : seen) f.instrument = f.smooth;
    const Problem measured(pointers(seen), vehicle, o);
    if (auto better = by_instruments(problem, measured, naming.model, settled_offsets(problem, naming.model),
                                     uncertainty_of(problem, naming.model).se))
      naming.model = std::move(*better);
  }
  d.candidates = naming.candidates;
  d.aliases = naming.aliases;
  if (!blind) d.mismatch = locate_wrench(problem, naming.null_model, naming.model, used, o);
  add_wrench_findings(problem, naming, d);
  if (!blind) {
    if (freed.empty()) {
      d.unexplained = locate_unexplained(problem, naming.model, o);
    } else {
      std::vector<Term> terms = select_terms(problem, naming.model.residual, o);
      // a law that is only nearly right leaves crumbs of itself
      const double crumb = 0.1 * (naming.model.log_likelihood - naming.null_model.log_likelihood);
      std::erase_if(terms, [&](const Term& t) { return t.gain < crumb; });
      d.unexplained = as_unexplained(problem, terms, naming.model.residual);
      std::erase_if(d.unexplained, [](const Unexplained& u) { return u.share_of_residual < 0.03; });
    }
    Eigen::VectorXd before, after;
    all->predict({}, naming.model.offsets, before, nullptr);
    all->predict(naming.model.effects, naming.model.offsets, after, nullptr);
    add_bursts(*all, before, after, d);
  }
  const std::vector<ActiveEffect> wrench = naming.model.effects;

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
  for (int c = 0; c < 6; ++c) {
    const int n = problem.samples();
    d.fit.in_sample.push_back({"", kChannels[static_cast<std::size_t>(c)], channel_unit(c),
                               rms(problem.residual().segment(c * n, n)),
                               rms(naming.model.residual.segment(c * n, n))});
  }
  for (const Flight& f : unseen)
    for (ChannelFit& c : compare(f, vehicle, o, wrench, f.file)) d.fit.held_out.push_back(std::move(c));
  if (unseen.empty() && flights.size() == 1 && !wrench.empty() && !o.stopped()) {
    constexpr int kFolds = 3;
    const double from = flights[0].t.front(), span = flights[0].t.back() - from;
    for (int k = 0; k < kFolds; ++k) {
      const double a = from + span * k / kFolds, b = from + span * (k + 1) / kFolds;
      const Flight rest = part_of(flights[0], a, b, false), block = part_of(flights[0], a, b, true);
      if (rest.usable() < 2 * rest.rate_hz || block.usable() < rest.rate_hz) continue;
      const Flight* one[] = {&rest};
      const Problem without_block(one, vehicle, o);
      const Fit refitted = settle(without_block, fit_effects(without_block, wrench, o), o);
      for (ChannelFit& c : compare(block, vehicle, o, refitted.effects,
                                   format("%s [%.1f s to %.1f s, not fitted]",
                                          std::filesystem::path(flights[0].file).filename().c_str(), a, b)))
        d.fit.held_out.push_back(std::move(c));
    }
  }
  if (o.rollouts && !o.stopped())
    d.fit.rollout = rollouts(unseen.empty() ? used : pointers(unseen), vehicle, wrench, o);
  for (const Flight& f : flights) d.series.push_back(series_of(f, vehicle, o, naming.model));
  if (flights[0].tracking_error.rows() > 0) {
    static constexpr const char* kAxis[] = {"px", "py", "pz"};
    for (int c = 0; c < 3; ++c) {
      double sum = 0;
      int count = 0;
      for (const Segment& s : flights[0].segments)
        for (int i = s.begin; i < s.end; ++i)
          if (std::isfinite(flights[0].tracking_error(i, c))) {
            sum += std::pow(flights[0].tracking_error(i, c), 2);
            ++count;
          }
      if (count > 0) d.tracking_rms[kAxis[c]] = std::sqrt(sum / count);
    }
  }

  const bool ambiguous =
      std::any_of(d.findings.begin(), d.findings.end(), [](const Finding& f) { return f.rivals > 0; });
  if (ambiguous && !o.stopped()) {
    std::vector<Rivals> pairs;
    for (std::size_t k = 0; k < naming.model.effects.size(); ++k)
      for (const Alternative& a : naming.named[k].set)
        pairs.push_back({naming.model.effects[k], {physics::find_effect(a.effect), a.theta}});
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
