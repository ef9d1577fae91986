// Sockets that the middleware opens on all interfaces, taken back to the loopback interface.
#pragma once

#include <set>

#include "omniflight_core/result.hpp"

namespace omniflight::bus::detail {

/// The open UDP sockets of this process that listen on every interface (0.0.0.0).
std::set<int> sockets_on_all_interfaces();

/// Binds those that are not among `before` to the device lo: Cyclone DDS 0.10.2 binds its receiving sockets
/// to 0.0.0.0 whatever its configuration says (ddsi_udp.c), so that packets of other machines would be
/// parsed.
Status confine_to_loopback(const std::set<int>& before);

}  // namespace omniflight::bus::detail
