#include "merge_recordings.hpp"

#include <algorithm>

namespace omniflight::diagnosis {
namespace {

/// Findings of different sensors of one kind are not merged.
bool same_sensor(const Finding& a, const Finding& b) {
  if (a.effect != b.effect || a.channels != b.channels || a.parameters.size() != b.parameters.size())
    return false;
  const bool rotor = !a.parameters.empty() && a.parameters[0].name == "rotor";
  return !rotor || a.parameters[0].value == b.parameters[0].value;
}

bool same_place(const Mismatch& a, const Mismatch& b) {
  return a.stage == b.stage && a.channel == b.channel && a.frame == b.frame && a.unit == b.unit;
}

/// Entry of another recording for the same sensor or channel; null if there is none.
template <class Entry>
Entry* merged(std::vector<Entry>& all, bool (*same)(const Entry&, const Entry&), const Entry& x) {
  const auto at = std::find_if(all.begin(), all.end(),
                               [&](const Entry& y) { return !y.recordings.empty() && same(x, y); });
  return at == all.end() ? nullptr : &*at;
}

}  // namespace

Input input_of(const recording::Recording& r) {
  Input in{r.file, r.sha256, r.duration_s, {}, {}};
  for (const std::string& name : r.signal_names())
    if (name.rfind("truth_", 0) != 0) in.signals.push_back(name);
  return in;
}

void merge_recording(const Diagnosis& one, const std::string& file, Diagnosis& all) {
  for (const Finding& f : one.findings) {
    if (Finding* known = merged(all.findings, same_sensor, f)) {
      if (known->recordings.back() == file) continue;
      known->recordings.push_back(file);
      known->probability = std::max(known->probability, f.probability);
      known->sentence += " In " + file + ": " + f.sentence;
      continue;
    }
    all.findings.push_back(f);
    all.findings.back().recordings = {file};
  }
  for (const physics::ActiveEffect& e : one.model)
    if (std::none_of(all.model.begin(), all.model.end(),
                     [&](const physics::ActiveEffect& known) { return known.effect == e.effect; }))
      all.model.push_back(e);
  for (const Mismatch& m : one.mismatch) {
    Mismatch* known = merged(all.mismatch, same_place, m);
    if (!known) {
      all.mismatch.push_back(m);
      all.mismatch.back().recordings = {file};
      continue;
    }
    if (known->recordings.back() == file) {
      known->windows_s.insert(known->windows_s.end(), m.windows_s.begin(), m.windows_s.end());
      continue;
    }
    // windows stay those of the first recording that shows it
    known->recordings.push_back(file);
    known->rms = std::max(known->rms, m.rms);
    known->p_value = std::min(known->p_value, m.p_value);
  }
  auto& pairs = all.next_flight.separates;
  for (const auto& pair : one.next_flight.separates)
    if (std::find(pairs.begin(), pairs.end(), pair) == pairs.end()) pairs.push_back(pair);
  auto& words = all.next_flight.manoeuvres;
  for (const std::string& text : one.next_flight.manoeuvres)
    if (std::find(words.begin(), words.end(), text) == words.end()) words.push_back(text);
}

Diagnosis unusable(const recording::Recording& r, const std::vector<std::string>& against) {
  Diagnosis d;
  d.verdict = Verdict::unusable;
  d.inputs.push_back(input_of(r));
  d.summary = "This recording cannot be used as it is:";
  for (const std::string& text : against) d.summary += " " + text + ".";
  d.summary += " Nothing was fitted.";
  return d;
}

}  // namespace omniflight::diagnosis
