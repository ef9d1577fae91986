// DDS Security: every participant proves who it is, and says and hears only what its role may.
#pragma once

#include <filesystem>
#include <string>

#include "omniflight_core/result.hpp"

namespace omniflight::bus {

/// Files of a folder of keys: what all share, and one folder a role.
struct KeyFiles {
  KeyFiles(const std::filesystem::path& keys, const std::string& role);
  std::filesystem::path identity_ca, permissions_ca, governance;  ///< shared, nothing secret
  std::filesystem::path certificate, private_key, permissions;    ///< of the role; the key is secret
};

/// Longest flight and the time before it: keys that end sooner are refused, because Cyclone DDS disconnects
/// a participant whose certificate or permissions end.
inline constexpr double kKeysOutlast_s = 11 * 3600.0;

/// Whether these keys can be used, without using them. ErrorCode::bad_input: a file is missing, is no
/// certificate, or ends too soon; the private key can be read by others than its owner; Cyclone DDS comes
/// without its security plug-ins.
Status check_keys(const std::filesystem::path& keys, const std::string& role);
/// Makes every later participant of this process join as `role` of a folder that `omniflight keys` has made,
/// or not at all: Participant::create then fails rather than join in clear text. Adds to the configuration
/// that use_loopback has chosen, so call that first; and this before threads start. Another call exchanges
/// the keys of later domains. Errors: those of check_keys.
Status use_security(const std::filesystem::path& keys, const std::string& role);
/// Later participants join in clear text: for a program that speaks to runs with and without keys in turn.
void forget_security();
/// Whether use_security holds for participants from now on.
bool security_promised();

namespace detail {
/// Cyclone DDS configuration (XML) for these files and plug-ins, to be put behind another one in
/// CYCLONEDDS_URI.
std::string security_configuration(const KeyFiles& files, const std::filesystem::path& plugins);
}  // namespace detail

}  // namespace omniflight::bus
