// The laws behind the table, one file each.
#pragma once

#include "omniflight_control/law.hpp"

namespace omniflight::control {

std::unique_ptr<Law> make_thrust_vector(const LawConfig& config);
std::unique_ptr<Law> make_cascaded(const LawConfig& config);
std::unique_ptr<Law> make_incremental(const LawConfig& config);

}  // namespace omniflight::control
