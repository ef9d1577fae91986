#include "bus_access.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/security.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::cli {

void add_secure(CLI::App& verb, std::string& keys) {
  verb.add_option(
      "--secure", keys,
      "Folder of keys (omniflight keys): nobody without them is heard, and nothing starts in clear "
      "text. For instance --secure ~/keys");
}

Status use_bus_of(int domain, std::string& keys) {
  const auto configs = files::config_dir();
  if (!configs) return Failure(configs.error());
  if (auto ok = bus::use_loopback((*configs / "cyclonedds_loopback.xml").string()); !ok) return ok;
  if (keys.empty()) keys = bus::keys_of_run(domain);
  if (!keys.empty()) return bus::use_security(keys, kOperator);
  bus::forget_security();  // of a run that was joined before
  return {};
}

std::string unheard(int domain, const std::string& keys) {
  const std::string of_run = bus::keys_of_run(domain);
  std::error_code ec;
  if (of_run.empty())
    return keys.empty() ? ""
                        : "; this program is secured, a run without keys (or with others) does not hear it";
  if (std::filesystem::equivalent(keys, of_run, ec)) return {};
  return "; the run is secured by the keys in " + of_run + ", which --secure is to name";
}

}  // namespace omniflight::cli
