// The proof's plant as a program on the bus, in the place of omniflight_simulator.
#include <CLI/CLI.hpp>

#include "omniflight_bus/run_components.hpp"
#include "omniflight_core/progress.hpp"
#include "plant_component.hpp"

int main(int argc, char** argv) {
  using namespace omniflight;
  CLI::App app(
      "omniflight component 'mujoco_plant': a vehicle in a world that shares no dynamics with the "
      "simulator.\n"
      "Example: omniflight_mujoco_plant --params flight.yaml --domain 7");
  bus::RunOptions options;
  options.role = "mujoco_plant";
  double timeout_s = 0;
  app.add_option("--params", options.parameter_files, "Parameter files (name: ros__parameters: {...})");
  app.add_option("-p,--param", options.overrides, "Overrides key:=value or component:key:=value");
  app.add_option("--domain", options.domain, "Domain of this run")->check(CLI::Range(0, 231));
  app.add_option("--loopback", options.loopback_file, "Bus configuration that stays on this machine (XML)");
  app.add_option(
      "--secure", options.keys,
      "Folder of keys (omniflight keys): join with those of this component, or not at all; needs --loopback");
  app.add_option("--timeout", timeout_s, "Longest run [s], 0 = none")->check(CLI::NonNegativeNumber);
  app.add_flag("--quiet", options.quiet, "No line per transition");
  CLI11_PARSE(app, argc, argv);
  if (timeout_s > 0) options.timeout = std::chrono::seconds(static_cast<long>(std::ceil(timeout_s)));
  install_interrupt_handler();
  std::vector<std::unique_ptr<bus::Component>> parts;
  parts.push_back(proof::make_plant_component());
  return bus::run_components(std::move(parts), options);
}
