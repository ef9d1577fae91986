#include "score.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "case_aliases.hpp"

namespace omniflight::proof {
namespace {

bool contains(const std::vector<std::string>& list, const std::string& what) {
  return std::find(list.begin(), list.end(), what) != list.end();
}

template <class Effect>
std::set<std::string> names(const std::vector<Effect>& effects, const std::string& flight) {
  std::set<std::string> out;
  for (const auto& e : effects) out.insert(merged(e.id, flight));
  return out;
}
template <class Effect>
std::set<std::string> own_names(const std::vector<Effect>& effects) {
  std::set<std::string> out;
  for (const auto& e : effects) out.insert(e.id);
  return out;
}
template <class Range>
std::string joined(const Range& range) {
  std::string out;
  for (const auto& r : range) out += (out.empty() ? "" : " + ") + r;
  return out;
}

/// The stage an answer points at first: of its first finding, else of what it calls unexplained, else of the
/// first mismatch.
std::string first_stage(const Answer& a) {
  if (!a.findings.empty()) return a.findings.front().stage;
  if (!a.unknown.empty()) return a.unknown.front().stage;
  return a.mismatch_stages.empty() ? "" : a.mismatch_stages.front();
}

/// Share of the energy that knowing the truth would remove from held-out data, which the answer removes;
/// channels weighted by the inverse variance of the noise.
double explained_share(const Truth& t, const Answer& a) {
  static const char* const channels[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
  double removed = 0, removable = 0;
  bool any = false;
  for (std::size_t c = 0; c < 6; ++c)
    for (const auto& h : a.held_out)
      if (h.channel == channels[c] && std::isfinite(h.before) && std::isfinite(h.after) && t.noise[c] > 0) {
        any = true;
        removed += (h.before * h.before - h.after * h.after) / (t.noise[c] * t.noise[c]);
        removable += t.wrench[c] * t.wrench[c] / (t.noise[c] * t.noise[c]);
      }
  return any && removable > 0 ? removed / removable : std::nan("");
}

}  // namespace

Answer without_nuisances(const Truth& truth, Answer a) {
  if (truth.present.empty()) return a;
  const auto there = [&](const AnsweredEffect& f) { return contains(truth.present, f.id); };
  const bool named = std::any_of(a.findings.begin(), a.findings.end(), there);
  a.findings.erase(std::remove_if(a.findings.begin(), a.findings.end(), there), a.findings.end());
  if (named && a.findings.empty() && a.unknown.empty()) a.verdict = "nothing_missing";
  return a;
}

Judged judge(const Truth& t, const Answer& given) {
  const Answer a = without_nuisances(t, given);
  Judged j;
  j.id = t.id;
  j.kind = to_string(t.kind);
  j.level = t.level;
  j.flight = t.flight;
  j.magnitude = t.effects.empty() ? "" : fmt::format("{:.2g}", t.magnitude);
  const auto truth = names(t.effects, t.flight), said = names(a.findings, t.flight);
  j.truth = t.effects.empty() ? (t.decoy.empty() ? "nothing" : "nothing (" + t.decoy + ")") : joined(truth);
  j.hidden = t.effects.empty() ? j.truth : joined(own_names(t.effects));
  j.verdict = a.given ? a.verdict : "no answer: " + a.problem;
  j.said = a.findings.empty() ? (a.unknown.empty() ? "nothing" : "unknown") : joined(said);
  j.named = a.findings.empty() ? j.said : joined(own_names(a.findings));
  j.refused = !a.given || a.verdict == "unusable" || a.verdict == "unfinished";
  j.explained = std::nan("");
  j.alarm = !j.refused && (a.verdict != "nothing_missing" || !a.findings.empty() || !a.unknown.empty());
  if (t.effects.empty()) {
    j.badness = j.alarm ? 2 : (j.refused ? 1 : 0);
    if (j.alarm) j.why = "alarm on a nominal flight";
    if (j.refused) j.why = "no answer";
    return j;
  }
  j.detected = j.alarm;
  const std::string stage = first_stage(a);
  j.stage = j.detected && std::any_of(t.effects.begin(), t.effects.end(),
                                      [&](const TrueEffect& e) { return e.stage == stage; });
  if (t.kind == Kind::unknown) {
    const bool called = j.detected && !a.unknown.empty() && a.findings.empty();
    bool variable = false;
    for (const auto& u : a.unknown)
      variable = variable || (!u.variables.empty() && contains(t.effects[0].variables, u.variables.front()));
    j.exact = called && variable && a.unknown.front().stage == t.effects[0].stage;
    j.top1 = called;
    if (!a.findings.empty())
      j.why = "named as a library effect";
    else if (!j.detected)
      j.why = "not detected";
    else if (!called)
      j.why = "not called unknown";
    else if (!j.exact)
      j.why = variable ? "wrong stage" : "wrong variable";
  } else {
    if (!a.findings.empty()) {
      j.top1 = truth.count(merged(a.findings.front().id, t.flight)) > 0;
      int covered = 0;
      double size = 0;
      for (const auto& name : truth)
        covered += std::any_of(a.findings.begin(), a.findings.end(), [&](const AnsweredEffect& f) {
          return std::any_of(f.set.begin(), f.set.end(),
                             [&](const std::string& s) { return merged(s, t.flight) == name; });
        });
      for (const auto& f : a.findings) size += static_cast<double>(f.set.size());
      j.covered = covered == static_cast<int>(truth.size());
      j.set_size = static_cast<int>(std::lround(size / static_cast<double>(a.findings.size())));
    }
    j.exact = truth == said && a.unknown.empty();
    j.explained = explained_share(t, a);
    if (j.refused)
      j.why = "no answer";
    else if (!j.detected)
      j.why = "not detected";
    else if (a.findings.empty())
      j.why = "called unknown";
    else if (!j.top1)
      j.why = j.covered ? "another of the stated set" : "wrong name";
    else if (!j.exact)
      j.why = "further or missing effects";
  }
  j.badness = (j.refused ? 3 : 0) +
              (t.magnitude >= 0.3 ? 1.0 : 0.3) *
                  ((j.detected ? 0 : 2) + (j.top1 ? 0 : 1) + (j.stage ? 0 : 1) + (j.exact ? 0 : 0.5));
  return j;
}

}  // namespace omniflight::proof
