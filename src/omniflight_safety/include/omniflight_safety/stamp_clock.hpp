// Stamps of other clocks (UNIX time, another machine's monotonic clock), put onto flight time.
//
// now - stamp is the offset between the clocks plus the delay on the way, which is never negative. Its
// minimum over a window is therefore the offset plus the least delay (Cristian 1989; the clock filter of
// NTP). What is left in the estimate is that least delay, and the step in which flight time is known to the
// caller.
#pragma once

#include <array>
#include <cstdint>
#include <omniflight_core/result.hpp>
#include <optional>
#include <string>

namespace omniflight::safety {

struct StampClockConfig {
  double future_s = 0.1;    ///< s ahead of flight time that a stamp may be, once it is put onto it
  double old_s = 0.5;       ///< s behind flight time that a stamp may be
  double epoch_s = 10.0;    ///< s of either, beyond which no delay explains a stamp, but another clock
  double settle_s = 0.25;   ///< s during which stamps of another clock must agree before they are followed
  int settle_samples = 10;  ///< least number of such stamps
  double agree_s = 0.1;     ///< s by which their delays may differ meanwhile
  double window_s = 10.0;   ///< s over which the least delay is looked for
  bool own = true;          ///< the source may stamp in flight time; false: its clock is another one for sure
  double drift = 2e-4;      ///< s/s, fastest change of a followed offset; two crystals differ by less
};

enum class StampRefusal : std::uint8_t {
  not_finite,
  other_epoch,  ///< further from flight time than any delay
  from_future,  ///< ahead of flight time
  too_old,      ///< behind flight time
};

/// Follows the clock of one source. It begins with flight time itself (offset zero, stamps as they are).
/// Stamps that lie elsewhere are refused; when they alone come, and agree among each other, their offset is
/// taken over and counted as a reset. Never taken over are: a stamp that could be flight time's own but lies
/// ahead of it (a future is no epoch), and one that merely lies behind (data that was held up, not another
/// clock).
class StampClock {
 public:
  explicit StampClock(const StampClockConfig& config = {}) : config_(config) {}

  /// The flight time [s] at which stamp_s was taken, or why it is refused. now_s: flight time [s].
  std::optional<StampRefusal> place(double stamp_s, double now_s, double& flight_s);

  /// Whether stamps of another clock are followed.
  bool foreign() const { return foreign_; }
  /// s, added to a stamp gives flight time; zero unless foreign.
  double offset_s() const { return offset_; }
  /// How often an offset was taken over.
  std::uint64_t resets() const { return resets_; }
  /// The last refusal with its size, for instance "stamp 3 s ahead of flight time".
  const std::string& refusal_words() const { return refusal_words_; }
  /// The last reset with its size; empty before any.
  const std::string& reset_words() const { return reset_words_; }

 private:
  struct Candidate {
    double since_s = 0, least = 0, most = 0, last_stamp_s = 0;
    int samples = 0;
    bool believable = false;  ///< nothing but another clock explains its first stamp
  };
  static constexpr std::size_t kBuckets = 10;  ///< of the window

  std::optional<StampRefusal> find(double ahead_s);
  void consider(double stamp_s, double now_s, double ahead_s);
  void take_over(double offset_s, double now_s);
  void follow(double delay_s, double now_s);

  StampClockConfig config_;
  bool foreign_ = false;
  double offset_ = 0;
  std::optional<Candidate> candidate_;
  std::optional<double> last_stamp_s_;  ///< of the last placed stamp
  std::array<double, kBuckets> least_{};
  double bucket_since_s_ = 0, followed_s_ = 0;
  std::size_t bucket_ = 0;
  std::uint64_t resets_ = 0;
  std::string refusal_words_, reset_words_;
};

/// Every number finite and positive, agree_s not above old_s.
Status check(const StampClockConfig& config);

}  // namespace omniflight::safety
