// Running components: one in a program of its own, or several in a container.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_bus/component.hpp"

namespace omniflight::bus {

struct RunOptions {
  int domain = 0;
  std::string loopback_file;                    ///< see use_loopback; empty: the machine's own configuration
  std::string keys, role;                       ///< see use_security; without keys: in clear text
  std::vector<std::string> parameter_files;     ///< see load_parameters
  std::vector<std::string> overrides;           ///< "key:=value" or "component:key:=value"
  std::optional<std::chrono::seconds> timeout;  ///< longest run; ErrorCode::incomplete afterwards
  std::chrono::milliseconds poll{50};           ///< longest time until SIGTERM is noticed
  std::chrono::milliseconds report{1000};       ///< period of /component_state while running
  bool heartbeat = false;  ///< beats on /omniflight/alive (heartbeat.hpp), for those who watch
  bool quiet = false;      ///< no line per transition on stderr; errors are always printed
};

/// Configures and activates the components in their order, waits until one ends by itself, SIGINT, SIGTERM or
/// SIGHUP arrives or the timeout passes, then deactivates and cleans up in reverse order. So put a recorder
/// first: it starts before and stops after the others. A second SIGINT and readers of its output that have
/// gone do not cut this short. Returns the exit code: 0, or the ErrorCode of the first error.
int run_components(std::vector<std::unique_ptr<Component>> components, const RunOptions& options);

}  // namespace omniflight::bus
