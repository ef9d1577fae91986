// Command line of programs that run components; for programs that have CLI11.
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>

#include "omniflight_bus/run_components.hpp"

namespace omniflight::bus {

/// Adds what every such program is told. The options must live until the command line is read.
inline void add_run_arguments(CLI::App& app, RunOptions& options) {
  app.add_option("--params", options.parameter_files, "Parameter files (name: ros__parameters: {...})");
  app.add_option("-p,--param", options.overrides, "Overrides key:=value or component:key:=value");
  app.add_option("--domain", options.domain, "Domain of this run")->check(CLI::Range(0, 231));
  app.add_option("--loopback", options.loopback_file, "Bus configuration that stays on this machine (XML)");
  app.add_option(
      "--secure", options.keys,
      "Folder of keys (omniflight keys): join with those of this component, or not at all; needs --loopback");
  app.add_option_function<double>(
         "--timeout",
         [&options](double seconds) {
           if (seconds > 0) options.timeout = std::chrono::seconds(static_cast<long>(std::ceil(seconds)));
         },
         "Longest run [s], 0 = none")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--quiet", options.quiet, "No line per transition");
}

}  // namespace omniflight::bus
