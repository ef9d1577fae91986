#include "pilot_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>

#include "omniflight_physics/effect.hpp"

namespace omniflight::cli {
namespace {

using diagnosis::Diagnosis;
using diagnosis::Finding;
using diagnosis::ParameterValue;
using diagnosis::Verdict;

physics::KnownValues known_values(const Finding& f) {
  std::map<std::string, double> known;
  for (const ParameterValue& p : f.parameters)
    if (diagnosis::identifiable(f.effect, p)) known[p.name] = p.value;
  return physics::KnownValues(std::move(known));
}

/// "affine thrust curve: linear 0.0003 N s/rad".
std::string by_its_term(const Finding& f) {
  const physics::Effect* effect = physics::find_effect(f.effect);
  const std::string term = effect ? effect->info().term : f.effect;
  const ParameterValue* first = nullptr;
  for (const ParameterValue& p : f.parameters)
    if (!first && p.value != 0 && diagnosis::identifiable(f.effect, p)) first = &p;
  if (!first) return term + (f.parameters.empty() ? "" : ", its size not identifiable");
  std::string name = first->name;
  std::replace(name.begin(), name.end(), '_', ' ');
  return fmt::format(
      "{} ({} {:.3g}{})", term, name, first->value,
      first->unit == "1" || first->unit.empty() || first->unit == "-" ? "" : " " + first->unit);
}

bool is_physics(const Finding& f) {
  return f.stage != physics::Stage::sensing && f.stage != physics::Stage::control &&
         f.stage != physics::Stage::reference;
}

/// The findings of one kind, each with what it cannot be told apart from.
std::string phrases_of(const Diagnosis& d, bool physics) {
  std::string out;
  for (const Finding& f : d.findings) {
    if (is_physics(f) != physics) continue;
    out += (out.empty() ? "" : "; ") + pilot_words(f);
    const auto rivals = std::min(f.cannot_be_told_apart_from.size(), static_cast<std::size_t>(f.rivals));
    for (std::size_t k = 0; k < rivals; ++k) {
      const physics::Effect* other = physics::find_effect(f.cannot_be_told_apart_from[k]);
      out += " or " + (other ? other->info().term : f.cannot_be_told_apart_from[k]);
    }
  }
  return out;
}

std::string unnamed(const Diagnosis& d) {
  std::string channels;
  for (const auto& u : d.unexplained)
    if (channels.find(u.channel) == std::string::npos) channels += (channels.empty() ? "" : ", ") + u.channel;
  return channels.empty() ? "something that no known effect explains"
                          : "something in " + channels + " that no known effect explains";
}

std::string capitalised(std::string text) {
  if (!text.empty()) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

}  // namespace

std::string pilot_words(const Finding& f) {
  const physics::Effect* effect = physics::find_effect(f.effect);
  const std::string words = effect ? physics::say(effect->info().words, known_values(f)) : "";
  return words.empty() ? by_its_term(f) : words;
}

bool names_physics(const Diagnosis& d) {
  return std::any_of(d.findings.begin(), d.findings.end(), is_physics);
}

std::string first_sentence(const Diagnosis& d) {
  if (d.verdict == Verdict::checked)
    return "Only looked at: nothing was fitted, so nothing is said about missing physics";
  if (d.verdict == Verdict::unfinished) return "Not finished: this is no answer yet";
  if (d.verdict == Verdict::unusable)
    return d.intake.sensors.empty() ? "This recording cannot be used" : "Only the sensors can be judged";
  const std::string vehicle = phrases_of(d, true), others = phrases_of(d, false);
  const bool open = d.verdict == Verdict::unexplained;
  if (vehicle.empty() && !open) {
    if (others.empty()) return "The model explains this flight";
    return "The vehicle flies as modelled; " + others;
  }
  std::string out = vehicle;
  if (open) out += (out.empty() ? "" : "; ") + unnamed(d);
  if (!others.empty()) out += "; " + others;
  return capitalised(out);
}

}  // namespace omniflight::cli
