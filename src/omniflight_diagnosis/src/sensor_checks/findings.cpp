#include "findings.hpp"

#include <algorithm>
#include <cmath>

#include "../numerics/text.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;

std::string in_words(const CorrectionTerm& t) {
  std::string s = format("%.3g %s times ", t.coefficient, t.unit.c_str()) + t.words;
  if (t.frequency_hz > 0) s += format(" at %.2f Hz", t.frequency_hz);
  return s;
}

}  // namespace

void add_sensor(Diagnosis& d, const char* id, const std::string& channel, const char* unit,
                const std::string& sentence, std::vector<ParameterValue> parameters, double off,
                double noise) {
  const physics::Effect* effect = physics::find_effect(id);
  if (!effect) return;
  Finding f;
  f.effect = id;
  f.stage = effect->info().stage;
  f.channels = {channel};
  f.equation = effect->info().equation;
  f.latex = effect->info().latex;
  f.sentence = sentence;
  f.parameters = std::move(parameters);
  d.findings.push_back(std::move(f));
  Mismatch m;
  m.stage = effect->info().stage;
  m.channel = channel;
  m.frame = "body";
  m.unit = unit;
  m.where = "throughout";
  m.rms = off;
  m.noise_rms = noise;
  m.p_value = std::erfc(off / std::max(1e-12, noise) / std::sqrt(2.0));
  d.mismatch.push_back(std::move(m));
}

bool is_named(const Diagnosis& d, const std::string& effect) {
  return std::any_of(d.findings.begin(), d.findings.end(),
                     [&](const Finding& f) { return f.effect == effect; });
}

Finding finding_of(const SensorFault& fault) {
  Finding out;
  out.effect = fault.effect;
  out.log_factor = fault.log_factor;
  out.cannot_be_told_apart_from = fault.rivals;
  out.rivals = static_cast<int>(fault.rivals.size());
  const physics::Effect* effect = physics::find_effect(fault.effect);
  out.stage = effect ? effect->info().stage : physics::Stage::sensing;
  out.channels = {fault.channel};
  out.sentence = fault.sentence;
  out.parameters = fault.parameters;
  return out;
}

void add_faults(const std::vector<SensorFault>& faults, const std::vector<Window>& excluded, Diagnosis& d) {
  for (const SensorFault& fault : faults) {
    Finding finding = finding_of(fault);
    finding.equation = "measured value does not follow the quantity";
    d.findings.push_back(finding);
    Mismatch m;
    m.stage = finding.stage;
    m.channel = fault.channel;
    const recording::SignalSpec* spec = recording::find_spec(fault.channel);
    m.frame = fault.channel.starts_with("rotor")                         ? "rotor"
              : fault.channel == "gyro" || fault.channel == "acc"        ? "body"
              : fault.effect == physics::effect_id::battery_sensor_fault ? "-"
                                                                         : "world";
    m.unit = spec ? spec->unit : "rad/s";
    m.where = format("%.0f %% of the flight", 100 * fault.share);
    if (!fault.parameters.empty()) {
      m.unit = fault.parameters[0].unit;
      m.rms = std::abs(fault.parameters[0].value);
    }
    m.p_value = 0;
    for (const Window& w : excluded)
      if (w.why.rfind(fault.channel, 0) == 0) m.windows_s.emplace_back(w.from_s, w.to_s);
    d.mismatch.push_back(m);
  }
}

void drop_what_a_sensor_explains(Diagnosis& d) {
  for (const Finding& fault : d.findings) {
    if (fault.effect != physics::effect_id::rotor_speed_sensor_fault || fault.parameters.size() != 2)
      continue;
    const int rotor = static_cast<int>(fault.parameters[0].value);
    const double e = fault.parameters[1].value, as_thrust = 1 / ((1 + e) * (1 + e)) - 1;
    const std::string scale = "scale_" + std::to_string(rotor), place = "rotor" + std::to_string(rotor) + "_";
    const auto seems = [&](const Finding& f) {
      const auto& rivals = f.cannot_be_told_apart_from;
      if (f.effect == physics::effect_id::rotor_thrust_scale)
        return f.parameters.size() == 1 && f.parameters[0].name == scale &&
               std::abs(f.parameters[0].value - as_thrust) < 0.4 * std::abs(as_thrust);
      return std::find(rivals.begin(), rivals.end(), physics::effect_id::rotor_thrust_scale) !=
                 rivals.end() &&
             std::all_of(f.parameters.begin(), f.parameters.end(),
                         [&](const ParameterValue& p) { return p.name.starts_with(place); });
    };
    const auto at = std::find_if(d.findings.begin(), d.findings.end(), seems);
    if (at == d.findings.end()) continue;
    std::erase_if(d.model, [&](const ActiveEffect& m) { return m.effect->info().id == at->effect; });
    d.findings.erase(at);
    return;
  }
}

std::string summarise(const Diagnosis& d, const std::vector<Flight>& flights) {
  std::string s;
  const bool unfinished = d.verdict == Verdict::unfinished;
  if (unfinished) {
    s = "Not finished: stopped, or the time was up. Still open: ";
    for (std::size_t k = 0; k < d.left_out.size(); ++k) s += (k > 0 ? ", " : "") + d.left_out[k];
    s += ". What follows is where it stood and no answer. ";
  } else if (d.findings.empty() && d.unexplained.empty() && d.mismatch.empty())
    s = (d.probability_of_nothing < 0.5 ? "Nothing is named, but something may be missing"
                                        : "Nothing is missing") +
        (d.probability_of_nothing < 0.95 ? format(" (probability of nothing %.2f)", d.probability_of_nothing)
                                         : std::string()) +
        ": the rotors, the mass and the inertia of the vehicle file explain what was measured, within the "
        "noise and the tolerances of the sensors. ";
  else if (d.findings.empty() && d.unexplained.empty())
    s = "No left-out physics is named: what differs is too small, or what offsets within the tolerances may "
        "do. ";
  for (const Mismatch& m : d.mismatch)
    if (m.stage == physics::Stage::wrench)
      s += format("%s (%s frame) differs by %.3g %s where %.3g is noise%s%s. ", m.channel.c_str(),
                  m.frame.c_str(), m.rms, m.unit.c_str(), m.noise_rms, m.where.empty() ? "" : ": ",
                  m.where.c_str());
  for (const Finding& f : d.findings) s += (unfinished ? "Tried " : "Found ") + f.sentence + " ";
  for (const Unexplained& u : d.unexplained) {
    s += format(
        "Something in %s (%s frame) is not in the library: %.0f %% of what remains can still be "
        "predicted",
        u.channel.c_str(), u.frame.c_str(), 100 * u.share_of_residual);
    if (!u.correction.empty()) s += ", first by " + in_words(u.correction.front());
    s += ". ";
  }
  if (!d.left_out.empty() && !unfinished) {
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

}  // namespace omniflight::diagnosis
