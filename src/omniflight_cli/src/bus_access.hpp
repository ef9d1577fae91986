// How a verb joins the bus of a run: on the loopback interface, and with keys where the run has some.
#pragma once

#include <string>

#include "command_line_names.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::cli {

inline constexpr const char* kOperator = "operator";  ///< role of every verb, see rights_of_roles

/// The option --secure.
void add_secure(CLI::App& verb, std::string& keys);

/// Called before a participant of this domain is made. Without keys: those that the run there was started
/// with, where it is ours, so that a stop needs no option. The keys that are used are put into `keys`.
Status use_bus_of(int domain, std::string& keys);

/// Why a run may not hear: "" or "; the run ... ". For "nobody listens".
std::string unheard(int domain, const std::string& keys);

}  // namespace omniflight::cli
