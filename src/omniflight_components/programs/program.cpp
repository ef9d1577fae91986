#include "program.hpp"

#include <iostream>

#include "omniflight_bus/run_arguments.hpp"
#include "omniflight_components/components.hpp"

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
  bus::add_run_arguments(app, options);
  app.add_flag("--heartbeat", options.heartbeat,
               "Beat on /omniflight/alive, so that others notice when it stands still");
  CLI11_PARSE(app, argc, argv);
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
