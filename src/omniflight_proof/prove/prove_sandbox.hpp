// Running the analysis where it cannot read the seal.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::proof {

/// How a child is kept from the seal.
enum class Confinement {
  other_user,  ///< as nobody, in a mount namespace of its own where the seal is empty when that is allowed
  namespaces,  ///< as the same user, in user and mount namespaces: seal and /proc are empty file systems
  none         ///< not at all; only when explicitly allowed
};
std::string to_string(Confinement confinement);

/// The best that works here. With `none` as the only way left: an error, unless allow_unsealed.
Result<Confinement> choose_confinement(const std::filesystem::path& seal, bool allow_unsealed);

struct Confined {
  Confinement confinement = Confinement::none;
  std::filesystem::path seal;          ///< folder that must not be readable
  std::vector<std::string> arguments;  ///< program with full path, then its arguments
  std::string log;                     ///< file for stdout and stderr
  double limit_s = 600;                ///< wall time, then it is killed
};

/// One child. Not copyable; kills what still runs when it goes.
class ConfinedChild {
 public:
  ConfinedChild() = default;  ///< none: poll() is true at once
  static Result<ConfinedChild> start(const Confined& what);
  ConfinedChild(ConfinedChild&& other) noexcept;
  ConfinedChild& operator=(ConfinedChild&& other) noexcept;
  ~ConfinedChild();
  /// True once it has ended; kills it after its time.
  bool poll();
  int exit_code() const { return code_; }  ///< 128 + signal when killed
  double seconds() const { return seconds_; }
  bool out_of_time() const { return late_; }

 private:
  int pid_ = -1, code_ = -1;
  double begin_ = 0, limit_ = 0, seconds_ = 0;
  bool late_ = false;
};

/// Runs one to its end.
Result<int> run_confined(const Confined& what);

/// What a confined process may and may not do; run inside the confinement by `omniflight_proof_campaign
/// --probe`.
struct ProbeResult {
  std::vector<std::string> leaks;     ///< ways in which the seal could be read; empty is good
  std::vector<std::string> refusals;  ///< what was tried in vain
  std::vector<std::string> hindered;  ///< what the analysis needs and may not do
};
ProbeResult probe(const std::filesystem::path& seal, const std::filesystem::path& secret_file,
                  const std::filesystem::path& readable, const std::filesystem::path& writable, int parent);

}  // namespace omniflight::proof
