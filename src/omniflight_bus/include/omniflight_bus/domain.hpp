// Which domain a run uses, so that runs beside each other never meet.
#pragma once

#include <string>

#include "omniflight_core/result.hpp"

namespace omniflight::bus {

/// Holds a domain for one run until it is destroyed or the process ends, however it ends.
class DomainClaim {
 public:
  DomainClaim(DomainClaim&& other) noexcept;
  DomainClaim& operator=(DomainClaim&& other) noexcept;
  ~DomainClaim();
  int domain() const { return domain_; }
  /// Tells whoever asks keys_of_run that this run is secured by a folder of keys (an absolute path).
  void tell_keys(const std::string& folder) const;

 private:
  friend Result<DomainClaim> claim_domain(int domain);
  DomainClaim(int domain, int file) : domain_(domain), file_(file) {}
  int domain_ = -1, file_ = -1;
};

/// Locks ${XDG_RUNTIME_DIR:-/tmp}/omniflight-domain-N.lock. ErrorCode::bad_input when another run holds the
/// domain. The process that owns the run claims (command line, launcher); its components join without a claim
/// of their own.
Result<DomainClaim> claim_domain(int domain);
/// The first free domain of [first, last].
Result<DomainClaim> claim_free_domain(int first = 1, int last = 100);

/// The folder of keys that the run in this domain is secured by. Empty: none, or it is another user's run.
std::string keys_of_run(int domain);

/// Makes the bus use this configuration file, which keeps it on the loopback interface: sets CYCLONEDDS_URI,
/// whatever it was (and says so on stderr), and has the sockets of later participants bound to that
/// interface. Only OMNIFLIGHT_BUS=FILE in the environment chooses another configuration, and then nothing is
/// promised. Call it before the first Participant and before threads start.
Status use_loopback(const std::string& xml_file);
/// Whether use_loopback has promised that nothing leaves or enters this machine.
bool loopback_promised();

}  // namespace omniflight::bus
