// Host time of samples that carry only an 8-bit sequence number.
// E. Olson, "A passive solution to the sensor synchronization problem", IROS 2010: a message can be late but
// never early, so the smallest delay seen bounds the offset between the board's count and the host's clock.
#pragma once

#include <cstdint>

namespace omniflight::gateway {

class SequenceClock {
 public:
  /// @param rate_hz nominal rate of the stream, positive; @param drift bound on the board clock's relative
  /// error;
  /// @param reset_s the estimate starts anew when it lags the arrival by more than this (rate wrong, or a
  /// long gap).
  explicit SequenceClock(double rate_hz, double drift = 1e-3, double reset_s = 5e-3)
      : period_s_(1.0 / rate_hz), drift_(drift), reset_s_(reset_s) {}

  struct Stamp {
    double time_s = 0.0;     ///< s, host clock, never after the arrival
    unsigned missed = 0;     ///< samples between the one before and this one
    bool duplicate = false;  ///< the same number again: drop it
  };
  /// @param arrival_s host clock, s, when the sample was read.
  Stamp stamp(std::uint8_t seq, double arrival_s);

  std::uint64_t received() const { return received_; }
  std::uint64_t missed() const { return missed_; }
  /// Forgets the offset (after a reconnect); the counts stay.
  void restart() { started_ = false; }

 private:
  double period_s_, drift_, reset_s_;
  bool started_ = false;
  std::uint8_t seq_ = 0;
  double board_s_ = 0.0;   ///< board clock, s, counted in periods
  double offset_s_ = 0.0;  ///< largest (board - arrival) seen, allowing for drift
  std::uint64_t received_ = 0, missed_ = 0;
};

}  // namespace omniflight::gateway
