// Makes the keys, certificates and signed permissions of DDS Security 1.1 (section 9.4: X.509, S/MIME).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::bus {

/// Topics (ROS names) that a role may publish and subscribe; "*" is every topic. Every role may also say
/// which nodes it has (ros_discovery_info).
struct Rights {
  std::vector<std::string> publish, subscribe;
};

struct Validity {
  std::int64_t from_s = 0, until_s = 0;  ///< s of UNIX time
};

/// What one role gets, as the texts of its files.
struct Credentials {
  std::string certificate;  ///< PEM
  std::string private_key;  ///< PEM, secret
  std::string permissions;  ///< XML signed by the authority (S/MIME)
};

/// Two certificate authorities, for identities and for permissions, whose private keys exist in the memory of
/// this object alone: nobody can sign further roles once it is gone.
class Authority {
 public:
  /// ErrorCode::internal when OpenSSL refuses.
  static Result<Authority> create(const Validity& validity);
  Authority(Authority&&) noexcept;
  Authority& operator=(Authority&&) noexcept;
  ~Authority();

  const std::string& identity_ca() const;     ///< PEM certificate
  const std::string& permissions_ca() const;  ///< PEM certificate
  /// The name of a role is [a-z_]+, at most 40 letters.
  Result<Credentials> issue(const std::string& role, const Rights& rights, const Validity& validity) const;
  /// S/MIME, signed by the authority for permissions.
  Result<std::string> sign(const std::string& xml) const;

 private:
  struct State;
  explicit Authority(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Governance: nobody joins without keys; discovery and data are encrypted, whole packets signed; rights to
/// publish and to subscribe are checked on every topic.
std::string governance_xml();
std::string permissions_xml(const std::string& role, const Rights& rights, const Validity& validity);

/// Makes the folder (0700) with keys of every role; private keys are 0600. Whole or absent; an existing
/// folder is refused.
Status write_keys(const std::filesystem::path& folder, const std::map<std::string, Rights>& roles,
                  const Validity& validity);

}  // namespace omniflight::bus
