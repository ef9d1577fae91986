#include "program.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

#include "omniflight_bus/run_components.hpp"
#include "omniflight_components/components.hpp"
#include "omniflight_core/progress.hpp"

namespace omniflight::components {

int run_program(const char* name, int argc, char** argv) {
  std::string role = name;
  std::vector<std::string> names;
  if (!role.empty()) names = {role};
  CLI::App app(role.empty() ? "Runs several omniflight components in one process.\n"
                              "Example: omniflight_container recorder planner allocator controller simulator "
                              "--params flight.yaml --domain 7"
                            : "omniflight component '" + role + "'.\nExample: omniflight_" + role +
                                  " --params flight.yaml --domain 7");
  if (role.empty()) {
    role = "container";
    app.add_option("components", names, "Components, started in this order")
        ->required()
        ->check(CLI::IsMember(component_names()));
  }
  bus::RunOptions options;
  options.role = role;
  double timeout_s = 0;
  app.add_option("--params", options.parameter_files, "Parameter files (name: ros__parameters: {...})");
  app.add_option("-p,--param", options.overrides, "Overrides key:=value or component:key:=value");
  app.add_option("--domain", options.domain, "Domain of this run")->check(CLI::Range(0, 231));
  app.add_option("--loopback", options.loopback_file, "Bus configuration that stays on this machine (XML)");
  app.add_option(
      "--secure", options.keys,
      "Folder of keys (omniflight keys): join with those of this component, or not at all; needs --loopback");
  app.add_option("--timeout", timeout_s, "Longest run [s], 0 = none")->check(CLI::NonNegativeNumber);
  app.add_flag("--heartbeat", options.heartbeat,
               "Beat on /omniflight/alive, so that others notice when it stands still");
  app.add_flag("--quiet", options.quiet, "No line per transition");
  CLI11_PARSE(app, argc, argv);
  if (timeout_s > 0) options.timeout = std::chrono::seconds(static_cast<long>(std::ceil(timeout_s)));
  install_interrupt_handler();
  std::vector<std::unique_ptr<bus::Component>> parts;
  for (const std::string& part_name : names) {
    auto part = make_component(part_name);
    if (!part) {
      std::cerr << "unknown component '" << part_name << "'\n";
      return 4;
    }
    parts.push_back(std::move(part));
  }
  return bus::run_components(std::move(parts), options);
}

}  // namespace omniflight::components
