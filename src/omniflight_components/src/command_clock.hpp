// Stamps of rotor commands on flight time, whoever's clock they are of.
#pragma once

#include <cstdint>
#include <string>

#include "conversions.hpp"
#include "omniflight_bus/say.hpp"
#include "omniflight_safety/stamp_clock.hpp"

namespace omniflight::components {

class CommandClock {
 public:
  /// component: who speaks. future_s, old_s: s ahead of flight time and behind it that a command may be.
  CommandClock(std::string component, double future_s, double old_s)
      : component_(std::move(component)), clock_(config(future_s, old_s)) {}

  /// Flight time [s] of a command; the stamp as it lies when it is refused, for the gate's own judgement.
  /// believed tells which.
  double place(std::int64_t stamp_ns, double now_s, bool& believed) {
    const double stamp_s = to_s(stamp_ns);
    double flight_s = 0;
    believed = !clock_.place(stamp_s, now_s, flight_s);
    if (clock_.resets() > resets_told_) say("commands: " + clock_.reset_words());
    resets_told_ = clock_.resets();
    if (believed) return flight_s;
    ++refused_;
    if (now_s >= next_s_) {  // at most one line a second
      say(std::to_string(refused_ - refused_told_) +
          " commands refused, the last: " + clock_.refusal_words());
      refused_told_ = refused_;
      next_s_ = now_s + 1.0;
    }
    return stamp_s + clock_.offset_s();
  }
  const safety::StampClock& clock() const { return clock_; }
  std::uint64_t refused() const { return refused_; }

 private:
  static safety::StampClockConfig config(double future_s, double old_s) {
    safety::StampClockConfig c;
    c.future_s = future_s;
    c.old_s = old_s;
    c.agree_s = std::min(c.agree_s, old_s);
    return c;
  }
  void say(const std::string& words) const {
    bus::say(component_, words);
  }

  std::string component_;
  safety::StampClock clock_;
  std::uint64_t refused_ = 0, refused_told_ = 0, resets_told_ = 0;
  double next_s_ = -1e300;
};

}  // namespace omniflight::components
