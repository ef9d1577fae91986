#include <nlohmann/json.hpp>

#include "family.hpp"

namespace omniflight::proof {
namespace {

using nlohmann::json;

json write(const Coordinates& c) {
  return {{"vehicle", c.vehicle},
          {"controller", c.controller},
          {"told_gains", c.told_gains},
          {"start", c.start},
          {"manoeuvre", c.manoeuvre},
          {"signals", c.signals},
          {"reference", c.reference},
          {"turbulence", c.turbulence},
          {"noise", c.noise},
          {"calibration", c.calibration},
          {"length_s", c.length},
          {"imu_hz", c.imu_hz},
          {"pose_hz", c.pose_hz},
          {"speed_hz", c.speed_hz},
          {"alpha_deg", c.alpha_deg},
          {"tilt", c.tilt},
          {"low", c.low}};
}

Coordinates coordinates(const json& j) {
  Coordinates c;
  c.vehicle = j.at("vehicle");
  c.controller = j.at("controller");
  c.told_gains = j.at("told_gains");
  c.start = j.at("start");
  c.manoeuvre = j.at("manoeuvre");
  c.signals = j.at("signals");
  c.reference = j.at("reference");
  c.turbulence = j.at("turbulence");
  c.noise = j.at("noise");
  c.calibration = j.at("calibration");
  c.length = j.at("length_s");
  c.imu_hz = j.at("imu_hz");
  c.pose_hz = j.at("pose_hz");
  c.speed_hz = j.at("speed_hz");
  c.alpha_deg = j.at("alpha_deg");
  c.tilt = j.at("tilt");
  c.low = j.at("low");
  return c;
}

json write(const FamilyCase& c) {
  const Truth& t = c.truth;
  json effects = json::array();
  for (std::size_t k = 0; k < t.effects.size(); ++k) {
    const TrueEffect& e = t.effects[k];
    const EffectSize& s = c.sizes.at(k);
    json parameters = json::array();
    for (const auto& p : e.parameters)
      parameters.push_back({{"name", p.name}, {"value", p.value}, {"scale", p.scale}});
    effects.push_back({{"id", e.id},
                       {"stage", e.stage},
                       {"realisation", e.realisation},
                       {"catalogue_law", s.law},
                       {"sigma", e.sigma},
                       {"channel", s.channel},
                       {"rms", s.rms},
                       {"parameters", parameters},
                       {"variables", e.variables}});
  }
  return {{"id", t.id},
          {"kind", to_string(t.kind)},
          {"decoy", t.decoy},
          {"seed", t.seed},
          {"sigma", t.magnitude},
          {"family", write(c.where)},
          {"unseen", c.unseen},
          {"effects", effects},
          {"present", t.present},
          {"noise_rms", t.noise},
          {"turbulence_rms", c.turbulence},
          {"sensor_rms", c.sensor},
          {"wrench_rms", t.wrench},
          {"wrench_variance", t.wrench_variance},
          {"oracle",
           {{"judged", c.oracle.judged},
            {"detect_sigma", c.oracle.detect},
            {"rival_sigma", c.oracle.rival},
            {"nearest", c.oracle.nearest},
            {"separable", c.oracle.separable}}}};
}

FamilyCase read(const json& j) {
  FamilyCase c;
  Truth& t = c.truth;
  t.id = j.at("id");
  const std::string kind = j.at("kind");
  bool known = false;
  for (const Kind k : {Kind::null, Kind::decoy, Kind::single, Kind::pair, Kind::triple, Kind::unknown})
    if (to_string(k) == kind) t.kind = k, known = true;
  if (!known) throw std::out_of_range("'" + kind + "' is no kind of case");
  t.level = kind;
  t.decoy = j.at("decoy");
  t.seed = j.at("seed");
  t.magnitude = j.at("sigma");
  c.where = coordinates(j.at("family"));
  t.flight = c.where.manoeuvre;
  c.unseen = j.at("unseen").get<std::vector<std::string>>();
  t.present = j.at("present").get<std::vector<std::string>>();
  t.noise = j.at("noise_rms");
  c.turbulence = j.at("turbulence_rms");
  c.sensor = j.at("sensor_rms");
  t.wrench = j.at("wrench_rms");
  t.wrench_variance = j.at("wrench_variance");
  for (const json& e : j.at("effects")) {
    TrueEffect effect{e.at("id"), e.at("stage"), e.at("realisation"), e.at("sigma"), {}, e.at("variables")};
    for (const json& p : e.at("parameters"))
      effect.parameters.push_back({p.at("name"), p.at("value"), p.at("scale")});
    c.sizes.push_back({e.at("rms"), effect.sigma, e.at("channel"), e.at("catalogue_law")});
    t.effects.push_back(std::move(effect));
  }
  const json& o = j.at("oracle");
  c.oracle = {o.at("judged"), o.at("detect_sigma"), o.at("rival_sigma"), o.at("nearest"), o.at("separable")};
  return c;
}

}  // namespace

bool reverses(const Coordinates& c) {
  return c.vehicle == "omnimorph" && c.tilt == "fixed" && c.alpha_deg > 50 &&
         (c.manoeuvre == "designed" || c.manoeuvre == "pilot");
}

double BoxRandom::unit() {
  const double in = random_.uniform(0, 4);  // four of eight strips, every other one
  return (2 * std::floor(in) + (in - std::floor(in)) + (box_ == Box::sealed ? 1 : 0)) / 8;
}

double BoxRandom::between_log(double low, double high) { return low * std::pow(high / low, unit()); }

std::string to_json(const FamilySeal& seal) {
  json cases = json::array();
  for (const FamilyCase& c : seal.cases) cases.push_back(write(c));
  return json{{"schema", "omniflight.proof_families/1"},
              {"salt", seal.salt},
              {"box", seal.box},
              {"generator_sha256", seal.program},
              {"cases", cases}}
             .dump(1) +
         "\n";
}

Result<FamilySeal> read_family_seal(std::string_view text, const std::string& name) {
  std::string at = "schema";
  try {
    const json j = json::parse(text);
    if (j.at("schema") != "omniflight.proof_families/1")
      return bad_input("is not omniflight.proof_families/1", name + ": schema");
    FamilySeal seal{j.at("salt"), j.at("box"), j.at("generator_sha256"), {}};
    for (const json& c : j.at("cases")) {
      at = "cases[" + std::to_string(seal.cases.size()) + "]";
      seal.cases.push_back(read(c));
    }
    return seal;
  } catch (const std::exception& e) {
    return bad_input(e.what(), name + ": " + at, "Give the sealed file that omniflight_proof_families wrote");
  }
}

}  // namespace omniflight::proof
