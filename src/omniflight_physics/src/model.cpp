#include <fmt/format.h>

#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"
#include "omniflight_physics/correction.hpp"

namespace omniflight::physics {
namespace {

constexpr const char* kChannelNames[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};

int quantity(files::YamlReader& item, const std::string& name) {
  const auto all = quantities();
  std::vector<std::string> names;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (name == all[k].name) return static_cast<int>(k);
    names.emplace_back(all[k].name);
  }
  const std::string near = files::nearest_word(name, names);
  item.error_at("follows", "unknown quantity " + files::shown(name),
                near.empty() ? "" : "Did you mean '" + near + "'?");
  return 0;
}

Feature read_feature(files::YamlReader& item) {
  Feature f;
  const files::Bounds metres = files::between(-1e3, 1e3, "m"), angle = files::between(-kPi, kPi, "rad");
  const files::Bounds length = files::between(1e-3, 1e3, "m");
  if (auto bump = item.optional_child("near")) {
    f.form = Feature::Form::bump;
    f.center = bump->vec3("center", metres);
    f.length = bump->number("width", length);
  } else if (auto wave = item.optional_child("wave")) {
    f.form = Feature::Form::wave;
    f.length = wave->number("length", length);
    f.direction = wave->number("direction", angle);
    f.phase = wave->number("phase", angle);
  } else if (auto pulse = item.optional_child("pulse")) {
    f.form = Feature::Form::pulse;
    f.frequency = pulse->number("frequency", files::between(0, 1e3, "Hz"));
    f.phase = pulse->number("phase", angle);
  } else {
    const std::vector<std::string> names = item.strings("follows");
    if (names.empty() || names.size() > 2)
      item.error_at("follows", "needs one quantity or two", "List one, or two that are multiplied");
    else
      f.first = quantity(item, names[0]);
    if (names.size() == 2) f.second = quantity(item, names[1]);
  }
  return f;
}

Correction read_correction(files::YamlReader& item) {
  Correction c;
  c.channel = item.choice<int>("channel", {{"Fx", 0}, {"Fy", 1}, {"Fz", 2}, {"Mx", 3}, {"My", 4}, {"Mz", 5}});
  c.world = item.choice<bool>("axes", {{"body", false}, {"world", true}}, false);
  if (c.world && c.channel >= 3) item.error_at("axes", "a torque is in body axes");
  c.feature = read_feature(item);
  const char* unit = c.channel < 3 ? "N per unit" : "Nm per unit";
  c.coefficient = item.number("coefficient", files::between(-1e4, 1e4, unit));
  const files::Bounds any = files::between(-1e9, 1e9);
  c.mean = item.number("mean", any);
  c.low = item.number("from", any);
  c.high = item.number("to", any);
  if (!(c.low <= c.high)) item.error_at("to", "is below 'from'", "Give the range in which it was seen");
  return c;
}

std::string correction_yaml(const Correction& c) {
  const Feature& f = c.feature;
  std::string of, unit = "1";
  switch (f.form) {
    case Feature::Form::product: {
      const Quantity& a = quantities()[static_cast<std::size_t>(f.first)];
      of = fmt::format("follows: [{}", a.name);
      unit = a.unit;
      if (f.second >= 0) {
        const Quantity& b = quantities()[static_cast<std::size_t>(f.second)];
        of += fmt::format(", {}", b.name);
        unit += fmt::format(" {}", b.unit);
      }
      of += "]";
      break;
    }
    case Feature::Form::bump:
      of = fmt::format("near: {{center: [{:.17g}, {:.17g}, {:.17g}], width: {:.17g}}}  # m", f.center.x(),
                       f.center.y(), f.center.z(), f.length);
      break;
    case Feature::Form::wave:
      of = fmt::format("wave: {{length: {:.17g}, direction: {:.17g}, phase: {:.17g}}}  # m, rad, rad",
                       f.length, f.direction, f.phase);
      break;
    case Feature::Form::pulse:
      of = fmt::format("pulse: {{frequency: {:.17g}, phase: {:.17g}}}  # Hz, rad", f.frequency, f.phase);
      break;
  }
  return fmt::format(
      "  - channel: {}\n    axes: {}\n    {}\n    coefficient: {:.17g}  # {} per ({})\n    mean: {:.17g}  # "
      "{}\n"
      "    from: {:.17g}\n    to: {:.17g}\n",
      kChannelNames[c.channel], c.world ? "world" : "body", of, c.coefficient, c.channel < 3 ? "N" : "Nm",
      unit, c.mean, unit, c.low, c.high);
}

}  // namespace

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
  for (files::YamlReader item : yaml->children("corrections", 0, 64))
    model.effects.push_back(as_effect(read_correction(item)));
  if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  return model;
}

std::string model_yaml(const std::vector<ActiveEffect>& effects, const std::string& comment) {
  std::string out = "# " + comment + "\nschema: omniflight.model/1\n";
  std::string corrections;
  bool named = false;
  for (const ActiveEffect& e : effects) {
    if (is_correction(e)) {
      corrections += correction_yaml(correction_of(e));
      continue;
    }
    if (!named) out += "effects:\n";
    named = true;
    const EffectInfo& info = e.effect->info();
    out += fmt::format("  - id: {}  # {}\n    parameters:\n", info.id, info.term);
    for (std::size_t k = 0; k < info.parameters.size(); ++k)
      out += fmt::format("      {}: {:.17g}  # {}, {}\n", info.parameters[k].name, e.theta[k],
                         info.parameters[k].symbol, info.parameters[k].unit);
  }
  if (!named) out += "effects: []\n";
  if (!corrections.empty())
    out +=
        "# unknown physics: coefficient * (what it follows - mean), held between from and "
        "to\ncorrections:\n" +
        corrections;
  return out;
}

}  // namespace omniflight::physics
