#include "omniflight_physics/document.hpp"

#include <fmt/format.h>

#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {
namespace {

std::string joined(const std::vector<std::string>& items, const char* quote = "") {
  std::string out;
  for (const std::string& item : items) out += (out.empty() ? "" : ", ") + (quote + item + quote);
  return out;
}

std::string stages(const EffectInfo& info) {
  std::string out = to_string(info.stage);
  for (const Stage stage : info.also) out += ", " + to_string(stage);
  return out;
}

/// Aliases of the library link to their section; others are named only.
std::string links(const std::vector<std::string>& ids) {
  std::string out;
  for (const std::string& id : ids) {
    out += out.empty() ? "" : ", ";
    out += find_effect(id) ? "[" + id + "](#" + id + ")" : id;
  }
  return out;
}

/// Parameters one a rotor are many of a kind: the first rotor's stand for all.
bool repeats(const std::string& name) {
  return name.rfind("rotor", 0) == 0 && name.size() > 5 && name[5] > '1';
}

std::string section(const Effect& effect) {
  const EffectInfo& info = effect.info();
  std::string out = fmt::format("## {}\n\n{}\n\n```math\n{}\n```\n\n`{}`\n\n", info.id, info.term, info.latex,
                                info.equation);
  if (!info.parameters.empty()) {
    out +=
        "| parameter | symbol | unit | from | to | typical | nothing at |\n|---|---|---|---|---|---|---|\n";
    int hidden = 0;
    for (const Parameter& p : info.parameters) {
      const bool shape = !p.linear && p.typical == p.neutral;
      if (repeats(p.name)) {
        ++hidden;
        continue;
      }
      out += fmt::format("| {} | {} | {} | {} | {} | {} | {} |\n", p.name, p.symbol,
                         p.unit == "1" ? "-" : p.unit, p.lower, p.upper, p.typical,
                         shape ? "-" : fmt::format("{}", p.neutral));
    }
    if (hidden > 0)
      out += fmt::format("\nThe same for the other rotors: {} parameters in all.\n", info.parameters.size());
    out += "\n";
  }
  const MemorySize memory = effect.memory_size();
  out += fmt::format("- acts at: {}; moves {}\n- needs: {}\n- may look like: {}\n- separated by: {}\n",
                     stages(info), joined(info.channels), joined(info.signals), links(aliases_of(info)),
                     info.separated_by);
  if (memory.total() > 0) out += fmt::format("- remembers: {} numbers\n", memory.total());
  return out + "- source: " + info.source + "\n\n";
}

}  // namespace

std::string effects_markdown() {
  std::string out =
      "# The library of effects\n\n"
      "Physics that a simulation may leave out. This file is written by `omniflight effects --write-docs "
      "docs/reference/effects.md`;\na test compares it with the library. Frames and signs: "
      "[notation.md](notation.md), "
      "derivations: [physics.md](../explanation/physics.md).\n\n"
      "`dF` [N] and `dM` [Nm] are added to the nominal wrench about the body origin, in body axes. \"Nothing "
      "at\" is "
      "the value at\nwhich an effect is exactly absent; a dash marks a parameter that only shapes it.\n\n"
      "| effect | is | acts at | parameters |\n|---|---|---|---|\n";
  for (const Effect* effect : builtin_effects()) {
    const EffectInfo& info = effect->info();
    out += fmt::format("| [{0}](#{0}) | {1} | {2} | {3} |\n", info.id, info.term, stages(info),
                       info.parameters.size());
  }
  out += "\n";
  for (const Effect* effect : builtin_effects()) out += section(*effect);
  out.pop_back();
  return out;
}

}  // namespace omniflight::physics
