// Who stood still in a flight, and for how long.
#pragma once

#include <fmt/format.h>

#include <mutex>
#include <string>
#include <vector>

#include "omniflight_bus/say.hpp"

namespace omniflight::components {

/// A process that was not heard of for longer than its lease.
struct Silence {
  std::string who;
  double at_s = 0;   ///< s of flight time, when it was noticed
  double for_s = 0;  ///< s; until then, or until it came back
  bool back = false;
};

/// The ladder acts on what is missing from somebody; this says whom. Safe from any thread.
class SilenceLog {
 public:
  /// As HeartbeatWatch tells it; now_s: flight time.
  void note(const std::string& who, bool alive, double silence_s, double now_s) {
    constexpr std::size_t kMost = 100;
    bus::say("gateway", fmt::format("{} {} {:.1f} ms", who,
                                    alive ? "is back after" : "has been silent for", 1e3 * silence_s));
    const std::lock_guard lock(mutex_);
    if (!alive && silences_.size() < kMost) silences_.push_back({who, now_s, silence_s, false});
    for (Silence& s : silences_)
      if (alive && s.who == who && !s.back) s = {who, s.at_s, silence_s, true};
  }
  std::vector<Silence> list() const {
    const std::lock_guard lock(mutex_);
    return silences_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Silence> silences_;  ///< guarded by mutex_
};

}  // namespace omniflight::components
