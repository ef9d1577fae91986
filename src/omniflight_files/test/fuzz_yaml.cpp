// YAML of unknown origin, read as a mission or a vehicle is.
#include "mutated_inputs.hpp"
#include "omniflight_files/yaml.hpp"

std::vector<std::string> seeds() {
  return {
      "schema: omniflight.mission/1\nname: short\nclearance_m: 0.08\nlimits: {speed_mps: 0.3, rate_dps: 30}\n"
      "start: {position: [0, 0, 1.3], attitude: {rpy_deg: [0, 0, 0]}, hold_s: 0.5}\n",
      "schema: omniflight.effects/1\neffects:\n  - {effect: hung_cable, parameters: {linear_density: 0.3}}\n",
      "a: &x {b: 1}\nc: \"\\u00e9\"\nd: |\n  text\ne: [.nan, 1e400, 010, ~]\n",
  };
}

void feed(std::string_view input) {
  using namespace omniflight;
  auto yaml = files::YamlReader::parse(input, "fuzz.yaml");
  if (!yaml) return;
  (void)yaml->string("schema");
  (void)yaml->number("clearance_m", files::any_number("m"), 0.0);
  if (auto start = yaml->optional_child("start")) {
    (void)start->vec3("position", files::any_number("m"));
    (void)start->finish();
  }
  (void)yaml->finish();
}
