// `effects`: the library of left-out physics as a list, in full, as documentation, and flown as a gallery.
#include "verb_effects.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "omniflight_files/files.hpp"
#include "omniflight_physics/document.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

nlohmann::json describe(const physics::Effect& effect) {
  const physics::EffectInfo& info = effect.info();
  nlohmann::json parameters = nlohmann::json::array(), also = nlohmann::json::array();
  for (const auto& p : info.parameters)
    parameters.push_back({{"name", p.name},
                          {"symbol", p.symbol},
                          {"unit", p.unit},
                          {"lower", p.lower},
                          {"upper", p.upper},
                          {"typical", p.typical},
                          {"neutral", p.neutral},
                          {"linear", p.linear}});
  for (const physics::Stage stage : info.also) also.push_back(to_string(stage));
  return {{"id", info.id},
          {"term", info.term},
          {"equation", info.equation},
          {"latex", info.latex},
          {"source", info.source},
          {"stage", to_string(info.stage)},
          {"also", also},
          {"parameters", parameters},
          {"signals", info.signals},
          {"channels", info.channels},
          {"aliases", physics::aliases_of(info)},
          {"separated_by", info.separated_by},
          {"comes_with", info.comes_with},
          {"memory", effect.memory_size().total()}};
}

std::string list(const std::vector<std::string>& items) {
  std::string out;
  for (const auto& i : items) out += (out.empty() ? "" : ", ") + i;
  return out;
}

void print_all(const Common& common) {
  nlohmann::json all = nlohmann::json::array();
  for (const auto* e : physics::builtin_effects()) {
    all.push_back(describe(*e));
    say(common, fmt::format("{:26} {:10} {}", e->info().id, to_string(e->info().stage), e->info().term));
  }
  print_json(common, all);
}

void print_one(const Common& common, const physics::Effect& effect) {
  const auto& info = effect.info();
  print_json(common, describe(effect));
  std::string stages = to_string(info.stage);
  for (const physics::Stage stage : info.also) stages += ", " + to_string(stage);
  say(common, info.id + ": " + info.term + "\n  " + info.equation + "\n  LaTeX: " + info.latex +
                  "\n  source: " + info.source + "\n  acts at: " + stages + "; moves " + list(info.channels) +
                  "\n  needs: " + list(info.signals) + "\n  may look like: " +
                  list(physics::aliases_of(info)) + "\n  separated by: " + info.separated_by);
  if (!info.comes_with.empty()) say(common, "  comes with: " + list(info.comes_with));
  if (effect.memory_size().total() > 0)
    say(common, fmt::format("  remembers: {} numbers", effect.memory_size().total()));
  for (const auto& p : info.parameters) {
    const bool shape = !p.linear && p.typical == p.neutral;
    say(common,
        fmt::format("  {:16} {:10} [{}] {} ... {} (typical {}{})", p.name, p.symbol, p.unit, p.lower, p.upper,
                    p.typical, shape ? ", shape" : fmt::format(", nothing at {}", p.neutral)));
  }
}

}  // namespace

Result<const physics::Effect*> known_effect(const std::string& id) {
  if (const physics::Effect* e = physics::find_effect(id)) return e;
  std::vector<std::string> ids;
  for (const auto* known : physics::builtin_effects()) ids.push_back(known->info().id);
  const std::string near = files::nearest_word(id, ids);
  return bad_input("unknown effect '" + id + "'", "effects",
                   near.empty() ? "`omniflight effects` lists them" : "Did you mean '" + near + "'?");
}

Action add_effects(CLI::App& verb, Common& common) {
  struct EffectsOptions {
    std::string id, docs;
    bool gallery = false;
    GalleryOptions flights;
  };
  auto o = std::make_shared<EffectsOptions>();
  verb.add_option("id", o->id, "One effect in full");
  verb.add_option("--write-docs", o->docs, "Write the whole library as Markdown into this file");
  verb.add_flag("--gallery", o->gallery, "Fly a mission once per effect and plot what each one does");
  verb.add_option("--only", o->flights.only, "Gallery of these effects only")->needs("--gallery");
  verb.add_option("--mission", o->flights.mission, "Mission of the gallery")->capture_default_str();
  verb.add_option("--jobs", o->flights.jobs, "Flights at once; default: processors")
      ->check(CLI::Range(1, 64));
  verb.add_flag("--keep", o->flights.keep, "Keep the recordings of the gallery");
  return [o, &common]() -> Result<int> {
    if (o->gallery) return fly_gallery(o->flights, common);
    if (!o->docs.empty()) {
      if (auto ok = files::write_file_atomic(o->docs, physics::effects_markdown()); !ok)
        return Failure(ok.error());
      say(common, fmt::format("{} effects written to {}", physics::builtin_effects().size(), o->docs));
      return 0;
    }
    if (o->id.empty()) {
      print_all(common);
      return 0;
    }
    const auto effect = known_effect(o->id);
    if (!effect) return Failure(effect.error());
    print_one(common, **effect);
    return 0;
  };
}

}  // namespace omniflight::cli
