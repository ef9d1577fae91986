#include "score_answer.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace omniflight::proof {
namespace {

using nlohmann::json;

double number(const json& j, const char* key) {
  const auto it = j.find(key);
  return it != j.end() && it->is_number() ? it->get<double>() : std::nan("");
}
std::string text(const json& j, const char* key) {
  const auto it = j.find(key);
  return it != j.end() && it->is_string() ? it->get<std::string>() : std::string();
}

AnsweredEffect finding(const json& j) {
  AnsweredEffect e;
  e.id = j.at("effect").get<std::string>();
  e.stage = text(j, "stage");
  e.probability = number(j, "probability");
  e.set = j.value("cannot_be_told_apart_from", std::vector<std::string>{});
  e.set.insert(e.set.begin(), e.id);
  std::sort(e.set.begin() + 1, e.set.end());
  e.set.erase(std::unique(e.set.begin(), e.set.end()), e.set.end());
  for (const json& p : j.value("parameters", json::array())) {
    AnsweredParameter a{p.at("name").get<std::string>(), number(p, "value"), std::nan(""), std::nan("")};
    if (const auto i = p.find("interval95");
        i != p.end() && i->is_array() && i->size() == 2 && (*i)[0].is_number() && (*i)[1].is_number()) {
      a.low = (*i)[0];
      a.high = (*i)[1];
    }
    e.parameters.push_back(a);
  }
  return e;
}

}  // namespace

Answer read_answer(std::string_view content) {
  Answer a;
  try {
    const json j = json::parse(content);
    if (j.at("schema") != "omniflight.diagnosis/1") {
      a.problem = "schema is not omniflight.diagnosis/1";
      return a;
    }
    a.verdict = j.at("verdict").get<std::string>();
    for (const json& f : j.at("findings")) a.findings.push_back(finding(f));
    for (const json& u : j.at("unexplained")) {
      AnsweredUnknown one{text(u, "stage"), {}};
      for (const auto& v : u.value("depends_on", std::vector<std::string>{}))
        one.variables.push_back(plain_variable(v));
      a.unknown.push_back(std::move(one));
    }
    for (const json& m : j.at("mismatch")) a.mismatch_stages.push_back(text(m, "stage"));
    const json fit = j.value("fit", json::object());
    for (const json& c : fit.value("held_out", json::array()))
      a.held_out.push_back({text(c, "channel"), number(c, "rms_before"), number(c, "rms_after"), 0});
    for (const json& c : fit.value("closed_loop", json::array()))
      a.closed_loop.push_back({text(c, "channel"), number(c, "simulated_before"),
                               number(c, "simulated_after"), number(c, "real")});
    const json power = fit.value("power", json::object());
    a.power_real = number(power, "real_W");
    a.power_after = number(power, "simulated_after_W");
    a.proposes = j.contains("next_flight") && j["next_flight"].is_object() &&
                 !j["next_flight"].value("separates", json::array()).empty();
    a.runtime = number(j, "runtime_s");
    a.given = true;
  } catch (const json::exception& e) {
    a.problem = e.what();
  }
  return a;
}

std::string plain_variable(const std::string& word) {
  static const std::pair<const char*, std::vector<const char*>> words[] = {
      {"height", {"height", "h", "pz", "altitude", "z", "position_z", "pz_m"}},
      {"position",
       {"position", "p", "px", "py", "place", "x", "y", "position_x", "position_y", "horizontal position",
        "position x", "position y", "px_m", "py_m", "distance"}},
      {"vertical speed",
       {"vertical speed", "vz", "climb", "climb rate", "climb speed", "velocity_z", "vertical velocity"}},
      {"speed",
       {"speed", "v", "vx", "vy", "velocity", "horizontal speed", "horizontal velocity", "velocity_x",
        "velocity_y", "forward speed", "sideways speed", "sideward speed", "airspeed"}},
      {"rate",
       {"rate", "omega", "angular rate", "angular velocity", "wx", "wy", "wz", "w", "yaw rate", "roll rate",
        "pitch rate", "body rate"}},
      {"attitude", {"attitude", "roll", "pitch", "yaw", "tilt", "heading", "R", "tilt of the body"}},
      {"rotor speed",
       {"rotor speed", "rotor_speed", "thrust", "rotor speeds", "load split", "total thrust",
        "thrust split"}},
      {"alpha", {"alpha", "tilt angle", "rotor tilt"}},
      {"time", {"time", "t", "frequency", "phase"}},
      {"acceleration", {"acceleration", "a", "specific force"}}};
  for (const auto& [plain, synonyms] : words)
    for (const char* s : synonyms)
      if (word == s) return plain;
  return word;
}

}  // namespace omniflight::proof
