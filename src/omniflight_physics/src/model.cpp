#include <fmt/format.h>

#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"
#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {

std::string to_string(Stage stage) {
  static const char* const names[] = {"reference", "control", "allocation", "actuation",
                                      "wrench",    "motion",  "sensing",    "power"};
  return names[static_cast<int>(stage)];
}

Result<Model> load_model(const std::string& path) {
  const auto text = files::read_file(path, files::kMegabyte);
  if (!text) return Failure(text.error());
  auto yaml = files::YamlReader::parse(*text, path);
  if (!yaml) return Failure(yaml.error());
  if (yaml->string("schema") != "omniflight.model/1") yaml->error_at("schema", "is not omniflight.model/1");
  yaml->ignore("comment");
  yaml->ignore("vehicle");
  Model model;
  model.sha256 = files::sha256_hex(*text);
  for (files::YamlReader item : yaml->children("effects", 0, 64)) {
    const std::string id = item.string("id");
    const Effect* effect = find_effect(id);
    if (!effect) {
      std::vector<std::string> ids;
      for (const Effect* e : builtin_effects()) ids.push_back(e->info().id);
      const std::string near = files::nearest_word(id, ids);
      item.error_at(
          "id", "unknown effect " + files::shown(id),
          near.empty() ? "`omniflight effects` lists the known ones" : "Did you mean '" + near + "'?");
      break;
    }
    ActiveEffect active{effect, {}};
    auto values = item.optional_child("parameters");
    for (const Parameter& p : effect->info().parameters) {
      const files::Bounds bounds{.min = p.lower, .max = p.upper, .unit = p.unit.c_str()};
      active.theta.push_back(values ? values->number(p.name, bounds, p.typical) : p.typical);
    }
    model.effects.push_back(std::move(active));
  }
  if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  return model;
}

std::string model_yaml(const std::vector<ActiveEffect>& effects, const std::string& comment) {
  std::string out = "# " + comment + "\nschema: omniflight.model/1\n";
  if (effects.empty()) return out + "effects: []\n";
  out += "effects:\n";
  for (const ActiveEffect& e : effects) {
    const EffectInfo& info = e.effect->info();
    out += fmt::format("  - id: {}  # {}\n    parameters:\n", info.id, info.term);
    for (std::size_t k = 0; k < info.parameters.size(); ++k)
      out += fmt::format("      {}: {:.17g}  # {}, {}\n", info.parameters[k].name, e.theta[k],
                         info.parameters[k].symbol, info.parameters[k].unit);
  }
  return out;
}

}  // namespace omniflight::physics
