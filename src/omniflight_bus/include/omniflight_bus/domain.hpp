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

/// Makes the bus use the loopback interface alone: sets CYCLONEDDS_URI to this file unless it is set already.
/// Call it before the first Participant and before threads start.
Status use_loopback(const std::string& xml_file);

}  // namespace omniflight::bus
