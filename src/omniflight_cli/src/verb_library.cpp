// `effects` and `vehicles`: what there is.
#include <fmt/format.h>

#include "omniflight_files/files.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_vehicle/vehicle.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

nlohmann::json describe(const physics::EffectInfo& info) {
  nlohmann::json parameters = nlohmann::json::array();
  for (const auto& p : info.parameters)
    parameters.push_back({{"name", p.name},
                          {"symbol", p.symbol},
                          {"unit", p.unit},
                          {"lower", p.lower},
                          {"upper", p.upper},
                          {"typical", p.typical}});
  return {{"id", info.id},
          {"term", info.term},
          {"equation", info.equation},
          {"latex", info.latex},
          {"source", info.source},
          {"stage", to_string(info.stage)},
          {"parameters", parameters},
          {"signals", info.signals},
          {"channels", info.channels},
          {"aliases", info.aliases},
          {"separated_by", info.separated_by}};
}

std::string list(const std::vector<std::string>& items) {
  std::string out;
  for (const auto& i : items) out += (out.empty() ? "" : ", ") + i;
  return out;
}

}  // namespace

Action add_effects(CLI::App& verb, Common& common) {
  auto id = std::make_shared<std::string>();
  verb.add_option("id", *id, "One effect in full");
  return [id, &common]() -> Result<int> {
    if (id->empty()) {
      nlohmann::json all = nlohmann::json::array();
      for (const auto* e : physics::builtin_effects()) {
        all.push_back(describe(e->info()));
        say(common, fmt::format("{:22} {:10} {}", e->info().id, to_string(e->info().stage), e->info().term));
      }
      print_json(common, all);
      return 0;
    }
    const physics::Effect* e = physics::find_effect(*id);
    if (!e) {
      std::vector<std::string> ids;
      for (const auto* known : physics::builtin_effects()) ids.push_back(known->info().id);
      const std::string near = files::nearest_word(*id, ids);
      return bad_input("unknown effect '" + *id + "'", "effects",
                       near.empty() ? "" : "Did you mean '" + near + "'?");
    }
    const auto& info = e->info();
    print_json(common, describe(info));
    say(common, info.id + ": " + info.term + "\n  " + info.equation + "\n  source: " + info.source +
                    "\n  stage: " + to_string(info.stage) + ", channels: " + list(info.channels) +
                    "\n  needs: " + list(info.signals) + "\n  may look like: " + list(info.aliases) +
                    "\n  separated by: " + info.separated_by);
    for (const auto& p : info.parameters)
      say(common, fmt::format("  {:16} {:10} [{}] {} ... {} (typical {})", p.name, p.symbol, p.unit, p.lower,
                              p.upper, p.typical));
    return 0;
  };
}

Action add_vehicles(CLI::App&, Common& common) {
  return [&common]() -> Result<int> {
    nlohmann::json all = nlohmann::json::array();
    for (const std::string& name : vehicle::vehicle_names()) {
      const auto v = vehicle::load_vehicle(name);
      if (!v) return Failure(v.error());
      all.push_back({{"name", name}, {"mass_kg", v->mass}, {"rotors", v->rotor_count()}, {"file", v->file}});
      say(common, fmt::format("{:24} {:7.3f} kg, {} rotors  {}", name, v->mass, v->rotor_count(), v->file));
    }
    print_json(common, all);
    return 0;
  };
}

}  // namespace omniflight::cli
