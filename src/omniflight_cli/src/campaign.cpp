#include "campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "folder.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;
using files::YamlReader;

struct Variant {
  std::string name = "standard", weights = "case_a", tilt = "fixed";
  double tilt_reserve = 0.1;
  std::map<std::string, std::string> parameters;
  std::vector<std::string> set;
};

/// "controller.ki" and so on; values stay YAML text.
void read_parameters(YamlReader& yaml, std::map<std::string, std::string>& out) {
  auto parameters = yaml.optional_child("parameters");
  if (!parameters) return;
  for (const std::string& key : parameters->keys()) {
    if (key.find('.') == std::string::npos)
      parameters->error_at(key, "is not component.parameter", "For instance controller.kp");
    out[key] = parameters->string(key);
  }
}

Variant read_variant(YamlReader yaml, const Variant& common) {
  Variant v = common;
  v.name = yaml.string("name");
  v.weights = yaml.string("weights", common.weights);
  v.tilt = yaml.choice<std::string>(
      "tilt", {{"fixed", "fixed"}, {"search", "search"}, {"lookahead", "lookahead"}}, common.tilt);
  v.tilt_reserve = yaml.number("tilt_reserve", files::between(0, 0.9), common.tilt_reserve);
  for (const std::string& item : yaml.strings("set", false)) v.set.push_back(item);
  read_parameters(yaml, v.parameters);
  return v;
}

/// The value at `key`, which must be one of `known` when it is there.
std::string one_of(YamlReader& yaml, const std::string& key, const std::vector<std::string>& known) {
  const std::string value = yaml.string(key, "");
  if (!value.empty() && std::find(known.begin(), known.end(), value) == known.end()) {
    const std::string near = files::nearest_word(value, known);
    yaml.error_at(key, "no flight of this campaign has " + files::shown(value),
                  near.empty() ? "" : "Did you mean '" + near + "'?");
  }
  return value;
}

std::string stem(const std::string& name) { return fs::path(name).stem().string(); }

}  // namespace

Result<Campaign> load_campaign(const std::string& path) {
  auto yaml = YamlReader::load(path);
  if (!yaml) return Failure(yaml.error());
  if (yaml->string("schema") != "omniflight.campaign/1")
    yaml->error_at("schema", "is not omniflight.campaign/1");
  Campaign c;
  c.name = yaml->string("name");
  c.question = yaml->string("question", "");
  yaml->ignore("notes");
  FlightOptions base;
  base.plant = yaml->string("plant", "simulator");
  base.sensors = yaml->string("sensors", "laboratory");
  base.realtime = !base.lockstep();
  base.in_process = base.plant == "simulator" && yaml->boolean("in_process", true);
  const auto missions = yaml->strings("missions");
  std::vector<std::string> effects = yaml->strings("effects", false),
                           vehicles = yaml->strings("vehicles", false), effect_names, variant_names;
  if (effects.empty()) effects = {"none"};
  if (vehicles.empty()) vehicles = {""};
  const auto seeds = yaml->numbers("seeds", 0, files::between(0, 1e9));
  Variant common;
  common.set = yaml->strings("set", false);
  read_parameters(*yaml, common.parameters);
  std::vector<Variant> variants;
  for (const auto& v : yaml->children("variants", 0, 100)) variants.push_back(read_variant(v, common));
  if (variants.empty()) variants.push_back(common);
  for (const auto& e : effects) effect_names.push_back(stem(e));
  for (const auto& v : variants) variant_names.push_back(v.name);
  for (auto e : yaml->children("expect", 0, 1000))
    c.expected.push_back(
        {one_of(e, "variant", variant_names), one_of(e, "effect", effect_names),
         e.choice<std::string>(
             "verdict",
             {{kFlown, kFlown}, {kFlownBadly, kFlownBadly}, {"survived", "survived"}, {kLost, kLost}})});
  if (auto further = yaml->optional_child("investigate"))
    c.more_flights = static_cast<int>(further->number("flights", files::between(0, 10)));
  if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  if (!is_plain_name(c.name))
    return bad_input("name: " + files::shown(c.name) + " is no plain name", path,
                     "Use letters, digits and _.@+-");
  std::set<std::string> names;
  for (const auto& mission : missions)
    for (const auto& vehicle : vehicles)
      for (const auto& effect : effects)
        for (const Variant& variant : variants)
          for (const double seed : seeds) {
            Case one{.name = {},
                     .mission = stem(mission),
                     .effect = stem(effect),
                     .variant = variant.name,
                     .options = base};
            one.options.mission = mission;
            one.options.vehicle = vehicle;
            one.options.effects = effect == "none" ? "" : effect;
            one.options.parameters = variant.parameters;
            one.options.weights = variant.weights;
            one.options.tilt_mode = variant.tilt;
            one.options.tilt_reserve = variant.tilt_reserve;
            one.options.set = variant.set;
            one.options.seed = static_cast<std::uint64_t>(seed);
            one.name = one.mission + (vehicle.empty() ? "" : "-" + fs::path(vehicle).stem().string()) + "-" +
                       one.effect + "-" + one.variant + "-seed" + std::to_string(one.options.seed);
            if (!is_plain_name(one.name))
              return bad_input("the flight " + files::shown(one.name) + " would be no plain folder", path,
                               "Use letters, digits and _.@+- in the names of variants, at most 100 in all");
            if (!names.insert(one.name).second)
              return bad_input("two flights would have the name " + files::shown(one.name), path,
                               "Give variants, seeds, missions and effects different names");
            c.cases.push_back(std::move(one));
            if (c.cases.size() > 10000) return bad_input("gives more than 10000 flights", path);
          }
  if (c.cases.empty()) return bad_input("gives no flight", path, "Give missions and seeds");
  return c;
}

std::string Judgement::words() const {
  const std::string who = rest ? "every other flight"
                               : (expected.variant.empty() ? "every variant" : expected.variant) +
                                     (expected.effect.empty()     ? " with every effect"
                                      : expected.effect == "none" ? " without effects"
                                                                  : " with " + expected.effect);
  const std::string wanted = expected.verdict == kFlown        ? "flown"
                             : expected.verdict == kFlownBadly ? "flown badly"
                                                               : expected.verdict;
  if (flights == 0) return who + ": not flown";
  return fmt::format("{}: {} of {} flights {}, {}", who, as_expected, flights, wanted,
                     as_expected == flights ? "as expected" : "but all were expected to be");
}

std::vector<Judgement> judge(const Campaign& campaign, const std::vector<Outcome>& outcomes) {
  std::vector<Judgement> out;
  for (const Expectation& expected : campaign.expected) {
    Judgement j{expected};
    for (const Outcome& o : outcomes) {
      if (o.verdict.empty() || !expected.covers(o.flight)) continue;
      ++j.flights;
      j.as_expected += expected.met_by(o.verdict);
    }
    out.push_back(j);
  }
  Judgement rest{Expectation{}};
  rest.rest = !campaign.expected.empty();
  for (const Outcome& o : outcomes) {
    const auto covers = [&](const Expectation& e) { return e.covers(o.flight); };
    if (o.verdict.empty() || std::any_of(campaign.expected.begin(), campaign.expected.end(), covers))
      continue;
    ++rest.flights;
    rest.as_expected += o.flown();
  }
  if (rest.flights > 0) out.push_back(rest);
  return out;
}

std::string verdict_in_words(const std::vector<Judgement>& judgements) {
  if (judgements.empty()) return {};
  std::string met, missed;
  for (const Judgement& j : judgements) {
    std::string& list = j.met() ? met : missed;
    list += (list.empty() ? "" : "; ") + j.words();
  }
  return missed.empty() ? "As expected: " + met + "." : "Not as expected: " + missed + ".";
}

double figure(const nlohmann::json& flight, const std::string& pointer) {
  for (const char* root : {"/metrics/true", "/metrics/measured", "/metrics"}) {
    const nlohmann::json::json_pointer p(root + pointer);
    if (flight.contains(p) && flight[p].is_number()) return flight[p].get<double>();
  }
  return std::nan("");
}

double position_rmse(const nlohmann::json& flight) {
  double sum = 0;
  for (const char* axis : {"x", "y", "z"})
    sum += std::pow(figure(flight, std::string("/position_rmse_m/") + axis), 2);
  return std::sqrt(sum);
}

}  // namespace omniflight::cli
