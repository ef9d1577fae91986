// `vehicles`: what there is.
#include <fmt/format.h>

#include "omniflight_vehicle/vehicle.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
Action add_vehicles(CLI::App&, Common& common) {
  return [&common]() -> Result<int> {
    nlohmann::json all = nlohmann::json::array();
    for (const std::string& name : vehicle::vehicle_names()) {
      const auto v = vehicle::load_vehicle(name);
      if (!v) return Failure(v.error());
      all.push_back({{"name", name}, {"mass_kg", v->mass}, {"rotors", v->rotor_count()}, {"file", v->file}});
      say(common, fmt::format("{:24} {:7.3f} kg, {} rotors  {}", name, v->mass, v->rotor_count(), v->file));
    }
    print_json(common, all);
    return 0;
  };
}

}  // namespace omniflight::cli
