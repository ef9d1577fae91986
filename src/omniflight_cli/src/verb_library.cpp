// `vehicles`: what there is, and what each of them can be asked for.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "omniflight_allocation/actuation.hpp"
#include "omniflight_files/files.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

nlohmann::json to_json(const allocation::ActuationClass& c) {
  nlohmann::json tilts = nlohmann::json::array(), singular = nlohmann::json::array();
  for (const allocation::ActuationAtTilt& t : c.tilts)
    tilts.push_back({{"alpha_deg", to_degrees(t.alpha)},
                     {"kind", to_string(t.kind)},
                     {"rank", t.rank},
                     {"thrust_axis", {t.thrust_axis_B.x(), t.thrust_axis_B.y(), t.thrust_axis_B.z()}},
                     {"thrust_to_weight", t.thrust_to_weight},
                     {"hover_reserve", t.reserve()},
                     {"lean_deg", to_degrees(t.lean)}});
  for (const allocation::SingularTilt& s : c.singular)
    singular.push_back({{"alpha_deg", to_degrees(s.alpha)}, {"rank", s.rank}, {"lost", s.lost}});
  return {{"words", c.words()}, {"tilts", tilts}, {"singular", singular}};
}

}  // namespace

Action add_vehicles(CLI::App& verb, Common& common) {
  auto names = std::make_shared<std::vector<std::string>>();
  verb.add_option(
      "vehicle", *names,
      "Names or paths; default: all under configs/vehicles. For instance vehicles omnimorph@table_4_1");
  return [names, &common]() -> Result<int> {
    if (const auto configs = files::config_dir(); names->empty() && !configs) return Failure(configs.error());
    nlohmann::json all = nlohmann::json::array();
    for (const std::string& name : names->empty() ? vehicle::vehicle_names() : *names) {
      const auto v = vehicle::load_vehicle(name);
      if (!v) return Failure(v.error());
      const auto actuation = allocation::classify_actuation(*v);
      if (!actuation) return Failure(actuation.error());
      const double ratio = actuation->strongest().thrust_to_weight;
      all.push_back({{"name", name},
                     {"mass_kg", v->mass},
                     {"rotors", v->rotor_count()},
                     {"thrust_to_weight", ratio},
                     {"actuation", to_json(*actuation)},
                     {"file", v->file}});
      say(common, fmt::format("{:24} {:7.3f} kg, {} rotors, thrust to weight {:.2f}  {}", name, v->mass,
                              v->rotor_count(), ratio, v->file));
      say(common, "    " + actuation->words());
    }
    print_json(common, all);
    return 0;
  };
}

}  // namespace omniflight::cli
