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

constexpr std::size_t kMostOverBus = 10000, kMostInProcess = 1000000;  // flights

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

/// A list, or {from: 1, count: 2000}.
std::vector<std::uint64_t> read_seeds(YamlReader& yaml) {
  std::vector<std::uint64_t> out;
  if (auto range = yaml.optional_child("seeds"); range && range->is_map()) {
    const auto from = range->integer("from", 0, 1000000000),
               count = range->integer("count", 1, kMostInProcess);
    for (std::int64_t k = 0; k < count; ++k) out.push_back(static_cast<std::uint64_t>(from + k));
    return out;
  }
  for (const double seed : yaml.numbers("seeds", 0, files::between(0, 1e9)))
    out.push_back(static_cast<std::uint64_t>(seed));
  return out;
}

/// What is drawn anew for every flight: a value of an effect, an offset of the start, or a factor of a gain.
void read_varied(YamlReader& yaml, std::vector<campaign::Varied>& out) {
  using campaign::Varied;
  for (auto item : yaml.children("vary", 0, 50)) {
    Varied v;
    const bool start = item.has("start"), gain = item.has("gain");
    v.of = start ? Varied::Of::start : gain ? Varied::Of::gain : Varied::Of::effect;
    if (v.of == Varied::Of::effect) v.effect = item.string("effect");
    v.parameter = item.string(start ? "start" : gain ? "gain" : "parameter");
    v.name = item.string("name", start || gain ? v.parameter : v.effect + "." + v.parameter);
    const bool normal = item.has("normal");
    const auto two = item.numbers(normal ? "normal" : "uniform", 2, files::any_number());
    if (two.size() != 2) return;
    const double scale = start && v.parameter.size() > 1 ? kPi / 180 : 1;  // angles are degrees in the file
    v.distribution.kind =
        normal ? campaign::Distribution::Kind::normal : campaign::Distribution::Kind::uniform;
    v.distribution.a = two[0] * scale;
    v.distribution.b = two[1] * scale;
    if (item.has("within")) {
      const auto within = item.numbers("within", 2, files::any_number());
      if (within.size() == 2)
        v.distribution.least = within[0] * scale, v.distribution.most = within[1] * scale;
      if (!normal) item.error_at("within", "is for normal values", "Give uniform: [from, to] alone");
    }
    if (!item.ok()) return;
    if (auto ok = check(v, item.where()); !ok) return item.error(ok.error().text());
    for (const Varied& other : out)
      if (other.name == v.name) return item.error_at("name", files::shown(v.name) + " is there twice");
    out.push_back(std::move(v));
  }
}

Case group_of(const FlightOptions& base, const std::string& mission, const std::string& vehicle,
              const std::string& effect, const Variant& variant) {
  Case one{
      .name = {}, .mission = stem(mission), .effect = stem(effect), .variant = variant.name, .options = base};
  one.options.mission = mission;
  one.options.vehicle = vehicle;
  one.options.effects = effect == "none" ? "" : effect;
  one.options.parameters = variant.parameters;
  one.options.weights = variant.weights;
  one.options.tilt_mode = variant.tilt;
  one.options.tilt_reserve = variant.tilt_reserve;
  one.options.set = variant.set;
  one.name =
      one.mission + (vehicle.empty() ? "" : "-" + stem(vehicle)) + "-" + one.effect + "-" + one.variant;
  return one;
}

/// Names that can be folders, and no two alike; the flights themselves where they are flown one by one.
Status name_flights(Campaign& c, Flying flying, const std::string& path) {
  const std::size_t most = flying == Flying::bus ? kMostOverBus : kMostInProcess;
  if (c.groups.size() * c.seeds.size() > most)
    return bad_input(fmt::format("gives more than {} flights", most), path);
  if (c.groups.empty() || c.seeds.empty())
    return bad_input("gives no flight", path, "Give missions and seeds");
  std::set<std::string> names;
  std::set<std::uint64_t> seeds;
  for (const std::uint64_t seed : c.seeds)
    if (!seeds.insert(seed).second)
      return bad_input("the seed " + std::to_string(seed) + " is there twice", path,
                       "Give variants, seeds, missions and effects different names");
  for (const Case& group : c.groups) {
    const std::string longest = group.name + "-seed" + std::to_string(*seeds.rbegin());
    if (!is_plain_name(longest))
      return bad_input("the flight " + files::shown(longest) + " would be no plain folder", path,
                       "Use letters, digits and _.@+- in the names of variants, at most 100 in all");
    if (!names.insert(group.name).second)
      return bad_input("two flights would have the name " + files::shown(longest), path,
                       "Give variants, seeds, missions and effects different names");
    if (flying == Flying::in_process) continue;
    for (const std::uint64_t seed : c.seeds) {
      c.cases.push_back(group);
      c.cases.back().options.seed = seed;
      c.cases.back().name += "-seed" + std::to_string(seed);
    }
  }
  return {};
}

}  // namespace

Result<Campaign> load_campaign(const std::string& path, Flying flying) {
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
  base.quiet = true;
  const auto missions = yaml->strings("missions");
  std::vector<std::string> effects = yaml->strings("effects", false),
                           vehicles = yaml->strings("vehicles", false), effect_names, variant_names,
                           mission_names;
  if (effects.empty()) effects = {"none"};
  if (vehicles.empty()) vehicles = {""};
  c.seeds = read_seeds(*yaml);
  read_varied(*yaml, c.varied);
  Variant common;
  common.set = yaml->strings("set", false);
  read_parameters(*yaml, common.parameters);
  std::vector<Variant> variants;
  for (const auto& v : yaml->children("variants", 0, 100)) variants.push_back(read_variant(v, common));
  if (variants.empty()) variants.push_back(common);
  for (const auto& e : effects) effect_names.push_back(stem(e));
  for (const auto& v : variants) variant_names.push_back(v.name);
  for (const auto& m : missions) mission_names.push_back(stem(m));
  for (auto e : yaml->children("expect", 0, 1000))
    c.expected.push_back(
        {one_of(e, "variant", variant_names), one_of(e, "effect", effect_names),
         one_of(e, "mission", mission_names),
         e.choice<std::string>(
             "verdict",
             {{kFlown, kFlown}, {kFlownBadly, kFlownBadly}, {"survived", "survived"}, {kLost, kLost}})});
  if (auto further = yaml->optional_child("investigate"))
    c.more_flights = static_cast<int>(further->number("flights", files::between(0, 10)));
  if (flying == Flying::bus && !c.varied.empty())
    yaml->error_at("vary", "is drawn for flights without a bus only", "Give --in-process");
  if (flying == Flying::in_process && base.plant != "simulator")
    yaml->error_at("plant", "is " + files::shown(base.plant) + ", which needs the bus",
                   "Leave --in-process out, or take the simulator");
  if (flying == Flying::in_process && c.more_flights >= 0)
    yaml->error_at("investigate", "needs recordings, which flights in process have not",
                   "Leave one of both out");
  if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  if (!is_plain_name(c.name))
    return bad_input("name: " + files::shown(c.name) + " is no plain name", path,
                     "Use letters, digits and _.@+-");
  for (const auto& mission : missions)
    for (const auto& vehicle : vehicles)
      for (const auto& effect : effects)
        for (const Variant& variant : variants)
          c.groups.push_back(group_of(base, mission, vehicle, effect, variant));
  if (auto ok = name_flights(c, flying, path); !ok) return Failure(ok.error());
  return c;
}

std::string Judgement::words() const {
  const std::string who = rest ? "every other flight"
                               : (expected.variant.empty() ? "every variant" : expected.variant) +
                                     (expected.effect.empty()     ? " with every effect"
                                      : expected.effect == "none" ? " without effects"
                                                                  : " with " + expected.effect) +
                                     (expected.mission.empty() ? "" : " in " + expected.mission);
  const std::string wanted = expected.verdict == kFlown        ? "flown"
                             : expected.verdict == kFlownBadly ? "flown badly"
                                                               : expected.verdict;
  if (flights == 0) return who + ": not flown";
  return fmt::format("{}: {} of {} flights {}, {}", who, as_expected, flights, wanted,
                     as_expected == flights ? "as expected" : "but all were expected to be");
}

std::vector<Judgement> judge(const Campaign& campaign, const std::vector<Tally>& tallies) {
  std::vector<Judgement> out;
  for (const Expectation& expected : campaign.expected) {
    Judgement j{expected};
    for (const Tally& t : tallies) {
      if (t.verdict.empty() || !expected.covers(*t.group)) continue;
      j.flights += t.flights;
      if (expected.met_by(t.verdict)) j.as_expected += t.flights;
    }
    out.push_back(j);
  }
  Judgement rest{Expectation{}};
  rest.rest = !campaign.expected.empty();
  for (const Tally& t : tallies) {
    const auto covers = [&](const Expectation& e) { return e.covers(*t.group); };
    if (t.verdict.empty() || std::any_of(campaign.expected.begin(), campaign.expected.end(), covers))
      continue;
    rest.flights += t.flights;
    if (t.verdict == kFlown) rest.as_expected += t.flights;
  }
  if (rest.flights > 0) out.push_back(rest);
  return out;
}

std::vector<Judgement> judge(const Campaign& campaign, const std::vector<Outcome>& outcomes) {
  std::vector<Tally> tallies;
  for (const Outcome& o : outcomes) tallies.push_back({&o.flight, o.verdict, 1});
  return judge(campaign, tallies);
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

nlohmann::json to_json(const std::vector<Judgement>& judgements) {
  nlohmann::json out = nlohmann::json::array();
  for (const Judgement& j : judgements)
    out.push_back({{"variant", j.expected.variant},
                   {"effect", j.expected.effect},
                   {"mission", j.expected.mission},
                   {"verdict", j.expected.verdict},
                   {"flights", j.flights},
                   {"as_expected", j.as_expected}});
  return out;
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
