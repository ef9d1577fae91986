#include "questions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "omniflight_files/files.hpp"
#include "verb_effects.hpp"

namespace omniflight::cli {
namespace {

constexpr std::size_t kMostBytes = 64 * files::kMegabyte;

/// Probabilities of earlier answers are not taken for more certain than this: the vehicle may have changed.
constexpr double kLeast = 0.01;

Status check_known(const std::vector<std::string>& ids) {
  for (const std::string& id : ids)
    if (auto known = known_effect(id); !known) return Failure(known.error());
  return {};
}

/// Probabilities of the effects that a diagnosis.json names.
Result<std::map<std::string, double>> inclusion_of(const std::string& path) {
  const auto text = files::read_file(path, kMostBytes);
  if (!text) return Failure(text.error());
  const auto told = nlohmann::json::parse(*text, nullptr, false);
  const auto refuse = [&](const std::string& what) {
    return bad_input(what, path, "Name a diagnosis.json that `omniflight diagnose` wrote");
  };
  if (!told.is_object() || told.value("schema", nlohmann::json()) != "omniflight.diagnosis/1")
    return refuse("no diagnosis of schema omniflight.diagnosis/1");
  const auto findings = told.find("findings");
  if (findings == told.end() || !findings->is_array()) return refuse("field 'findings' is no list");
  std::map<std::string, double> out;
  for (const auto& f : *findings) {
    if (!f.is_object() || !f.contains("effect") || !f["effect"].is_string())
      return refuse("a finding without field 'effect'");
    const std::string id = f["effect"];
    if (!physics::find_effect(id)) return refuse("finding of an unknown effect " + files::shown(id));
    if (!f.contains("probability") || !f["probability"].is_number())
      return refuse("field 'probability' of finding '" + id + "' is no number: the answer is unfinished");
    out[id] = std::clamp(f["probability"].get<double>(), kLeast, 1 - kLeast);
  }
  return out;
}

}  // namespace

Status ask(const Questions& q, diagnosis::Options& options) {
  for (const auto* ids : {&q.only, &q.exclude})
    if (auto ok = check_known(*ids); !ok) return ok;
  for (const std::string& id : q.only)
    if (std::find(q.exclude.begin(), q.exclude.end(), id) != q.exclude.end())
      return bad_input("'" + id + "' is asked for and excluded", "--only, --exclude", "Leave it out of one");
  options.only = q.only;
  options.exclude = q.exclude;
  if (!q.why.empty())
    if (auto ok = check_known({q.why}); !ok) return ok;
  if (q.prior.empty()) return {};
  auto inclusion = inclusion_of(q.prior);
  if (!inclusion) return Failure(inclusion.error());
  options.inclusion = std::move(*inclusion);
  return {};
}

std::vector<std::string> why(const std::string& effect, const diagnosis::Diagnosis& d) {
  std::vector<std::string> out;
  for (const auto& x : d.decisions)
    if (x.about == effect)
      out.push_back(x.statistic == 0 && x.threshold == 0
                        ? fmt::format("{}: {}", x.asked, x.outcome)
                        : fmt::format("{}: {:.3g} against {:.3g} ({}): {}", x.asked, x.statistic, x.threshold,
                                      x.source, x.outcome));
  for (const auto& f : d.findings) {
    const auto& others = f.cannot_be_told_apart_from;
    if (f.effect == effect)
      out.push_back("it is named: " + f.sentence);
    else if (std::find(others.begin(), others.end(), effect) != others.end())
      out.push_back("it may stand in the place of " + f.effect +
                    ", which these recordings do not tell from it");
  }
  for (const auto& m : d.intake.missing)
    if (m.costs.find(effect) != std::string::npos) out.push_back("missing " + m.signal + ": " + m.costs);
  if (out.empty())
    out.push_back(fmt::format(
        "nothing was asked of it: stage {}, and no signal of these recordings shows a difference there",
        physics::to_string(physics::find_effect(effect)->info().stage)));
  return out;
}

}  // namespace omniflight::cli
