// The proof's plant as a program on the bus, in the place of omniflight_simulator.
#include "omniflight_bus/run_arguments.hpp"
#include "plant_component.hpp"

int main(int argc, char** argv) {
  using namespace omniflight;
  CLI::App app(
      "omniflight component 'mujoco_plant': a vehicle in a world that shares no dynamics with the "
      "simulator.\n"
      "Example: omniflight_mujoco_plant --params flight.yaml --domain 7");
  bus::RunOptions options;
  options.role = "mujoco_plant";
  bus::add_run_arguments(app, options);
  CLI11_PARSE(app, argc, argv);
  std::vector<std::unique_ptr<bus::Component>> parts;
  parts.push_back(proof::make_plant_component());
  return bus::run_components(std::move(parts), options);
}
