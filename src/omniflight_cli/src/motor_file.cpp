#include "motor_file.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "omniflight_files/files.hpp"

namespace omniflight::cli {
namespace {

using nlohmann::json;

Result<json> load(const std::string& file, const std::string& schema, const std::string& verb) {
  const auto text = files::read_file(file, 16 * files::kMegabyte);
  if (!text) return Failure(text.error());
  json j = json::parse(*text, nullptr, false);
  if (j.is_discarded() || !j.is_object())
    return bad_input("is no JSON object", file, "Make it with omniflight " + verb);
  if (!j.contains("schema") || !j["schema"].is_string() || j["schema"] != schema)
    return bad_input("is not of schema " + schema, file, "Make it with omniflight " + verb);
  return j;
}

/// A finite number at path (names of objects), or an error with the field.
Result<double> number(const json& j, std::initializer_list<const char*> path, const std::string& where) {
  const json* at = &j;
  std::string field;
  for (const char* name : path) {
    field += (field.empty() ? "" : ".") + std::string(name);
    if (!at->is_object() || !at->contains(name))
      return bad_input("is missing", where + ": " + field, "Make the file again");
    at = &(*at)[name];
  }
  if (!at->is_number() || !std::isfinite(at->get<double>()))
    return bad_input("is no number", where + ": " + field, "Make the file again");
  return at->get<double>();
}

}  // namespace

Result<std::vector<MotorOfFile>> load_motors(const std::string& file, int rotor) {
  const auto j = load(file, "omniflight.motor/1", "identify-motor");
  if (!j) return Failure(j.error());
  if (!j->contains("rotors") || !(*j)["rotors"].is_array()) return bad_input("is missing", file + ": rotors");
  std::vector<MotorOfFile> motors;
  for (const json& r : (*j)["rotors"]) {
    const auto id = number(r, {"rotor"}, file);
    if (!id) return Failure(id.error());
    MotorOfFile m;
    m.rotor = static_cast<int>(*id);
    if (rotor != 0 && m.rotor != rotor) continue;
    const std::string where = file + ": rotor " + std::to_string(m.rotor);
    const auto gain = number(r, {"gain", "value"}, where), up = number(r, {"lag_up", "value"}, where),
               down = number(r, {"lag_down", "value"}, where), delay = number(r, {"delay", "value"}, where);
    for (const auto* value : {&gain, &up, &down, &delay})
      if (!*value) return Failure(value->error());
    m.up = {*gain, *up, *delay};
    m.down = {*gain, *down, *delay};
    if (!r.contains("speeds_radps") || !r["speeds_radps"].is_array() || r["speeds_radps"].size() != 2 ||
        !r["speeds_radps"][0].is_number() || !r["speeds_radps"][1].is_number())
      return bad_input("must be two numbers", where + ": speeds_radps", "Make the file again");
    m.low_radps = r["speeds_radps"][0].get<double>();
    m.high_radps = r["speeds_radps"][1].get<double>();
    if (!(m.high_radps > m.low_radps) || !(m.low_radps >= 0))
      return bad_input("must be 0 or more and rise", where + ": speeds_radps", "Make the file again");
    m.noise_radps = m.high_radps - m.low_radps;
    if (!r.contains("structures") || !r["structures"].is_array())
      return bad_input("is missing", where + ": structures", "Make the file again");
    for (const json& s : r["structures"]) {
      const auto rms = number(s, {"innovation_rms_radps"}, where + ": structures");
      if (!rms) return Failure(rms.error());
      m.noise_radps = std::min(m.noise_radps, *rms);
    }
    motors.push_back(m);
  }
  if (motors.empty())
    return bad_input(rotor == 0 ? "has no rotor" : "has no rotor " + std::to_string(rotor), file,
                     "Identify it: omniflight identify-motor --rotor N");
  return motors;
}

std::vector<identification::LagPlant> plants_of(const std::vector<MotorOfFile>& motors) {
  std::vector<identification::LagPlant> plants;
  for (const MotorOfFile& m : motors) plants.insert(plants.end(), {m.up, m.down});
  return plants;
}

Result<identification::PidnGains> load_gains(const std::string& file) {
  const auto j = load(file, "omniflight.gains/1", "tune-motor");
  if (!j) return Failure(j.error());
  identification::PidnGains g;
  for (const auto& [name, to] : {std::pair{"kp", &g.kp}, {"ki", &g.ki}, {"kd", &g.kd}, {"n", &g.n}}) {
    const auto value = number(*j, {"gains", name}, file);
    if (!value) return Failure(value.error());
    *to = *value;
  }
  return g;
}

}  // namespace omniflight::cli
