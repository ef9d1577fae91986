#include "case_truth.hpp"

#include <nlohmann/json.hpp>

namespace omniflight::proof {
namespace {

using nlohmann::json;
constexpr Kind kKinds[] = {Kind::null, Kind::decoy, Kind::single, Kind::pair, Kind::triple, Kind::unknown};

json write(const TrueEffect& e) {
  json parameters = json::array();
  for (const auto& p : e.parameters)
    parameters.push_back({{"name", p.name}, {"value", p.value}, {"scale", p.scale}});
  return {{"id", e.id},       {"stage", e.stage},         {"realisation", e.realisation},
          {"sigma", e.sigma}, {"parameters", parameters}, {"variables", e.variables}};
}

TrueEffect effect(const json& j) {
  TrueEffect e{j.at("id"), j.at("stage"), j.at("realisation"), j.at("sigma"), {}, j.at("variables")};
  for (const json& p : j.at("parameters"))
    e.parameters.push_back({p.at("name"), p.at("value"), p.at("scale")});
  return e;
}

}  // namespace

std::string to_string(Kind kind) {
  switch (kind) {
    case Kind::null:
      return "null";
    case Kind::decoy:
      return "decoy";
    case Kind::single:
      return "single";
    case Kind::pair:
      return "pair";
    case Kind::triple:
      return "triple";
    case Kind::unknown:
      break;
  }
  return "unknown";
}

std::string to_json(const Seal& seal) {
  json cases = json::array();
  for (const Truth& t : seal.cases) {
    json effects = json::array();
    for (const auto& e : t.effects) effects.push_back(write(e));
    cases.push_back({{"id", t.id},
                     {"level", t.level},
                     {"kind", to_string(t.kind)},
                     {"flight", t.flight},
                     {"decoy", t.decoy},
                     {"seed", t.seed},
                     {"magnitude_sigma", t.magnitude},
                     {"effects", effects},
                     {"present", t.present},
                     {"noise_rms", t.noise},
                     {"wrench_rms", t.wrench},
                     {"wrench_variance", t.wrench_variance}});
  }
  return json{{"schema", "omniflight.proof_seal/1"},
              {"salt", seal.salt},
              {"box", seal.box},
              {"generator_sha256", seal.program},
              {"cases", cases}}
             .dump(1) +
         "\n";
}

Result<Seal> read_seal(std::string_view text, const std::string& name) {
  std::string at = "schema";
  try {
    const json j = json::parse(text);
    if (j.at("schema") != "omniflight.proof_seal/1")
      return bad_input("is not omniflight.proof_seal/1", name + ": schema");
    Seal seal{j.at("salt"), j.at("box"), j.at("generator_sha256"), {}};
    for (const json& c : j.at("cases")) {
      at = "cases[" + std::to_string(seal.cases.size()) + "]";
      Truth t;
      t.id = c.at("id");
      t.level = c.at("level");
      t.flight = c.at("flight");
      t.decoy = c.at("decoy");
      t.seed = c.at("seed");
      t.magnitude = c.at("magnitude_sigma");
      t.present = c.at("present").get<std::vector<std::string>>();
      t.noise = c.at("noise_rms");
      t.wrench = c.at("wrench_rms");
      t.wrench_variance = c.at("wrench_variance");
      for (const json& e : c.at("effects")) t.effects.push_back(effect(e));
      const std::string kind = c.at("kind");
      bool known = false;
      for (const Kind k : kKinds)
        if (to_string(k) == kind) t.kind = k, known = true;
      if (!known) return bad_input("'" + kind + "' is no kind of case", name + ": " + at + ".kind");
      seal.cases.push_back(std::move(t));
    }
    return seal;
  } catch (const json::exception& e) {
    return bad_input(e.what(), name + ": " + at, "Give the sealed file that the generator wrote");
  }
}

}  // namespace omniflight::proof
