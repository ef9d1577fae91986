// CYCLONEDDS_URI of this process, made of parts: the file that use_loopback chose, then keys.
#pragma once

#include <string>

#include "omniflight_core/result.hpp"

namespace omniflight::bus::detail {

/// Puts XML behind the file that use_loopback has chosen, in place of what was put there before.
/// ErrorCode::internal when none has been chosen.
Status add_configuration(const std::string& xml);

}  // namespace omniflight::bus::detail
