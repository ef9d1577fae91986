// `vehicles`: what there is, and what each of them can be asked for.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>

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

/// Rank, trim and lean over the tilt: "rank 4 at 0 deg, 6 from 1 to 60 deg; in hover every rotor keeps 74 %
/// of half its range from its limits at 0 deg, 48 % at 60 deg; hovers leaning by up to 180 deg at 32 deg".
std::string rank_and_trim(const allocation::ActuationClass& c) {
  const auto deg = [](const allocation::ActuationAtTilt& t) { return to_degrees(t.alpha); };
  const auto& all = c.tilts;
  std::string out;
  for (std::size_t i = 0, last = 0; i < all.size(); i = last + 1) {
    for (last = i; last + 1 < all.size() && all[last + 1].rank == all[i].rank;) ++last;
    out += fmt::format("{}{}{}", out.empty() ? "rank " : ", ", all[i].rank, c.range(i, last));
  }
  const allocation::ActuationAtTilt *easy = nullptr, *hard = nullptr;  // of the tilts at which it hovers
  for (const allocation::ActuationAtTilt& t : all) {
    if (!t.hovers()) continue;
    if (!easy || t.hover_load < easy->hover_load) easy = &t;
    if (!hard || t.hover_load > hard->hover_load) hard = &t;
  }
  if (!easy) return out + "; hovers at no tilt";
  out += fmt::format("; in hover every rotor keeps {:.0f} % of half its range from its limits",
                     100 * easy->reserve());
  if (hard->hover_load - easy->hover_load > 0.005)
    out +=
        fmt::format(" at {:.3g} deg, {:.0f} % at {:.3g} deg", deg(*easy), 100 * hard->reserve(), deg(*hard));
  const auto lean =
      std::max_element(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.lean < b.lean; });
  if (lean->lean > 0) {
    out += fmt::format("; hovers leaning by up to {:.3g} deg", to_degrees(lean->lean));
    if (all.size() > 1) out += fmt::format(" at {:.3g} deg", deg(*lean));
  }
  return out;
}

/// Mass and thrust to weight of every mass that the vehicle's file lists, said and returned.
Result<nlohmann::json> list_variants(const std::string& spec, const vehicle::Vehicle& v, Common& common) {
  nlohmann::json all = nlohmann::json::array();
  for (const vehicle::MassVariant& variant : v.variants) {
    const std::string name = spec.substr(0, spec.rfind('@')) + "@" + variant.name;
    const auto loaded = vehicle::load_vehicle(name);
    if (!loaded) return Failure(loaded.error());
    const auto actuation = allocation::classify_actuation(*loaded);
    if (!actuation) return Failure(actuation.error());
    const double ratio = actuation->strongest().thrust_to_weight;
    all.push_back(
        {{"name", name}, {"mass_kg", loaded->mass}, {"thrust_to_weight", ratio}, {"why", variant.why}});
    say(common, fmt::format("    {}: {:.3f} kg, thrust to weight {:.2f}{}", name, loaded->mass, ratio,
                            variant.why.empty() ? "" : "  (" + variant.why + ")"));
  }
  return all;
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
      say(common, fmt::format("{:24} {:7.3f} kg, {} rotors, thrust to weight {:.2f}  {}", name, v->mass,
                              v->rotor_count(), ratio, v->file));
      say(common, "    " + actuation->words());
      say(common, "    " + rank_and_trim(*actuation));
      auto variants = list_variants(name, *v, common);
      if (!variants) return Failure(variants.error());
      all.push_back({{"name", name},
                     {"mass_kg", v->mass},
                     {"rotors", v->rotor_count()},
                     {"thrust_to_weight", ratio},
                     {"actuation", to_json(*actuation)},
                     {"variants", std::move(*variants)},
                     {"file", v->file}});
    }
    print_json(common, all);
    return 0;
  };
}

}  // namespace omniflight::cli
