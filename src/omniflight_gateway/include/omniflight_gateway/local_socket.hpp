// A line to a board by Unix stream socket. What one end writes the other can read at once, in the writer's
// own time: the kernel hands a tty's bytes over in a worker thread of ordinary priority, which a loaded
// machine can leave without a processor for seconds.
#pragma once

#include <string>

#include "omniflight_gateway/serial_port.hpp"

namespace omniflight::gateway {

/// Is there a socket under this path? False for anything else, and for nothing.
bool is_local_socket(const std::string& path);

/// Makes a socket under the path, in place of one that a killed run left behind, and listens without
/// blocking.
/// @returns bad_input when something else has the path, or its directory is missing or cannot be written.
Result<FileDescriptor> listen_local(const std::string& path);

/// The next host that waits at the listener, non-blocking; closed when none does.
FileDescriptor accept_local(const FileDescriptor& listener);

/// Connects without blocking. Little is buffered towards the board, so that commands do not grow old on the
/// way.
/// @returns bad_input when nobody listens there.
Result<FileDescriptor> connect_local(const std::string& path);

}  // namespace omniflight::gateway
