#include "omniflight_gateway/sequence_clock.hpp"

#include <algorithm>

namespace omniflight::gateway {

SequenceClock::Stamp SequenceClock::stamp(std::uint8_t seq, double arrival_s) {
  // After a gap this long the 8-bit count may have wrapped more than once.
  constexpr unsigned kTrustedGap = 16;
  const unsigned steps = static_cast<std::uint8_t>(seq - seq_);
  if (started_ && steps == 0) return {arrival_s, 0, true};

  const unsigned missed = started_ ? steps - 1 : 0;
  ++received_;
  missed_ += missed;
  board_s_ += started_ ? steps * period_s_ : 0.0;
  offset_s_ -= drift_ * steps * period_s_;
  const double seen = board_s_ - arrival_s;
  if (!started_ || steps > kTrustedGap || offset_s_ - seen > reset_s_) {
    offset_s_ = seen;
  } else {
    offset_s_ = std::max(offset_s_, seen);
  }
  seq_ = seq;
  started_ = true;
  return {board_s_ - offset_s_, missed, false};
}

}  // namespace omniflight::gateway
