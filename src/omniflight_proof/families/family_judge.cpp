#include "family_judge.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "family_aliases.hpp"

namespace omniflight::proof {
namespace {

std::string joined(const std::set<std::string>& names) {
  std::string out;
  for (const std::string& n : names) out += (out.empty() ? "" : " + ") + n;
  return out;
}

/// The stage that an answer points at first.
std::string first_stage(const Answer& a) {
  if (!a.findings.empty()) return a.findings.front().stage;
  if (!a.unknown.empty()) return a.unknown.front().stage;
  return a.mismatch_stages.empty() ? "" : a.mismatch_stages.front();
}

double sure(double probability) {
  return std::isfinite(probability) ? std::clamp(probability, 0.0, 1.0) : 0.5;
}

/// Findings that are really there beside what is hidden are no error; what stands for a hidden effect stays.
Answer without_present(const FamilyCase& c, Answer a, const std::set<std::string>& truth) {
  const auto beside = [&](const AnsweredEffect& f) {
    const auto& present = c.truth.present;
    return std::find(present.begin(), present.end(), f.id) != present.end() &&
           !truth.count(family_names(f.id, c.where));
  };
  const bool named = std::any_of(a.findings.begin(), a.findings.end(), beside);
  a.findings.erase(std::remove_if(a.findings.begin(), a.findings.end(), beside), a.findings.end());
  if (named && a.findings.empty() && a.unknown.empty()) a.verdict = "nothing_missing";
  return a;
}

void judge_parameters(const Truth& t, const Answer& a, FamilyJudged& j) {
  for (const TrueEffect& e : t.effects)
    for (const AnsweredEffect& f : a.findings) {
      if (f.id != e.id) continue;
      for (const TrueParameter& truth : e.parameters)
        for (const AnsweredParameter& said : f.parameters) {
          if (said.name != truth.name || !(truth.scale > 0) || !std::isfinite(said.value)) continue;
          j.parameter_errors.push_back(std::abs(said.value - truth.value) / truth.scale);
          if (!std::isfinite(said.low) || !std::isfinite(said.high)) continue;
          ++j.intervals;
          j.intervals_hold += said.low <= truth.value && truth.value <= said.high;
        }
    }
}

void judge_unknown(const FamilyCase& c, const Answer& a, FamilyJudged& j) {
  const TrueEffect& e = c.truth.effects[0];
  const bool called = j.alarm && !a.unknown.empty() && a.findings.empty();
  const auto variable = [&](const AnsweredUnknown& u) {
    return !u.variables.empty() &&
           std::find(e.variables.begin(), e.variables.end(), u.variables.front()) != e.variables.end();
  };
  j.top1 = called;
  j.unknown_right = called && std::any_of(a.unknown.begin(), a.unknown.end(), variable) && j.stage;
  j.true_probability = called ? 1 : 0;  // an answer states no probability of what it has no name for
  j.why = !a.findings.empty() ? "named as a library effect"
          : !j.alarm          ? "not detected"
          : !called           ? "not called unknown"
          : !j.unknown_right  ? "wrong stage or variable"
                              : "";
}

void judge_named(const FamilyCase& c, const Answer& a, const std::set<std::string>& truth, FamilyJudged& j) {
  std::set<std::string> said, reached;
  double sizes = 0;
  for (const AnsweredEffect& f : a.findings) {
    said.insert(family_names(f.id, c.where));
    sizes += static_cast<double>(f.set.size());
    for (const std::string& s : f.set) reached.insert(family_names(s, c.where));
    if (truth.count(family_names(f.id, c.where))) j.true_probability += sure(f.probability) / truth.size();
  }
  j.true_probability = std::min(1.0, j.true_probability);
  if (!a.findings.empty()) {
    j.top1 = truth.count(family_names(a.findings.front().id, c.where)) > 0;
    j.covered =
        std::all_of(truth.begin(), truth.end(), [&](const std::string& n) { return reached.count(n) > 0; });
    j.set_size = sizes / static_cast<double>(a.findings.size());
  }
  j.exact = truth == said && a.unknown.empty();
  judge_parameters(c.truth, a, j);
  j.why = !j.alarm             ? "not detected"
          : a.findings.empty() ? "called unknown"
          : !j.top1            ? (j.covered ? "another of the stated set" : "wrong name")
          : !j.exact           ? "further or missing effects"
                               : "";
}

}  // namespace

FamilyJudged judge(const FamilyCase& c, const Answer& given) {
  FamilyJudged j;
  j.truth = &c;
  const Truth& t = c.truth;
  j.nominal = t.effects.empty();
  std::set<std::string> truth;
  for (const TrueEffect& e : t.effects) truth.insert(family_names(e.id, c.where));
  const Answer a = without_present(c, given, truth);
  j.hidden = j.nominal ? (t.decoy.empty() ? "nothing" : "nothing (" + t.decoy + ")") : joined(truth);
  j.verdict = a.given ? a.verdict : "no answer: " + a.problem;
  j.given = a.given && a.verdict != "unusable" && a.verdict != "unfinished" && a.verdict != "checked";
  std::set<std::string> said;
  for (const AnsweredEffect& f : a.findings) said.insert(f.id);
  j.said = said.empty() ? (a.unknown.empty() ? "nothing" : "unknown") : joined(said);
  j.alarm = j.given && (a.verdict != "nothing_missing" || !a.findings.empty() || !a.unknown.empty());
  for (const AnsweredEffect& f : a.findings)
    if (j.given) j.statements.push_back({sure(f.probability), truth.count(family_names(f.id, c.where)) > 0});
  double strongest = 0;
  for (const Statement& s : j.statements) strongest = std::max(strongest, s.probability);
  j.confidence = a.findings.empty() ? (j.alarm ? 0.5 : 1) : sure(a.findings.front().probability);
  if (!j.given) {
    j.why = "no answer";
    return j;
  }
  if (j.nominal) {
    j.true_probability = j.alarm ? (a.findings.empty() ? 0 : 1 - strongest) : 1;
    if (j.alarm) j.why = "alarm on a nominal flight";
    return j;
  }
  const std::string stage = first_stage(a);
  j.stage = j.alarm && std::any_of(t.effects.begin(), t.effects.end(), [&](const TrueEffect& e) {
              return stage_is_right(e.id, e.stage, stage, c.where);
            });
  if (t.kind == Kind::unknown)
    judge_unknown(c, a, j);
  else
    judge_named(c, a, truth, j);
  return j;
}

}  // namespace omniflight::proof
