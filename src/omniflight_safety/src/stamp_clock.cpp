#include "omniflight_safety/stamp_clock.hpp"

#include <algorithm>
#include <cmath>

#include "words.hpp"

namespace omniflight::safety {
Status check(const StampClockConfig& c) {
  const struct {
    double value;
    const char* field;
  } fields[] = {{c.future_s, "future_s"}, {c.old_s, "old_s"},     {c.epoch_s, "epoch_s"},
                {c.settle_s, "settle_s"}, {c.agree_s, "agree_s"}, {c.window_s, "window_s"},
                {c.drift, "drift"}};
  for (const auto& f : fields)
    if (!std::isfinite(f.value) || f.value < 0)
      return bad_input("must be a number of seconds, not negative, is " + std::to_string(f.value),
                       std::string("stamps.") + f.field);
  if (c.window_s <= 0) return bad_input("must be positive", "stamps.window_s");
  if (c.agree_s > c.old_s) return bad_input("is longer than old_s", "stamps.agree_s", "Give at most old_s");
  if (c.epoch_s <= std::max(c.future_s, c.old_s))
    return bad_input("is not longer than future_s and old_s", "stamps.epoch_s");
  return {};
}

std::optional<StampRefusal> StampClock::find(double ahead_s) {
  if (std::abs(ahead_s) > config_.epoch_s || (!config_.own && !foreign_)) {
    refusal_words_ = words("stamp %.6g s from flight time: another clock", ahead_s);
    return StampRefusal::other_epoch;
  }
  if (ahead_s > config_.future_s) {
    refusal_words_ = words("stamp %.4g s ahead of flight time", ahead_s);
    return StampRefusal::from_future;
  }
  if (-ahead_s > config_.old_s) {
    refusal_words_ = words("stamp %.4g s behind flight time", -ahead_s);
    return StampRefusal::too_old;
  }
  return {};
}

void StampClock::consider(double stamp_s, double now_s, double ahead_s) {
  const double delay = now_s - stamp_s;
  const bool agrees =
      candidate_ && std::max(delay, candidate_->most) - std::min(delay, candidate_->least) <= config_.agree_s;
  if (!agrees) {
    // What could be flight time's own is no other clock. A stamp ahead, or one that runs backwards, is a step
    // of a clock; one behind that goes on from the last is data that was held up.
    const bool own = config_.own && std::abs(stamp_s - now_s) <= config_.epoch_s;
    const bool acceptable_own = stamp_s - now_s <= config_.future_s && now_s - stamp_s <= config_.old_s;
    const bool stepped = ahead_s > 0 || !last_stamp_s_ || stamp_s < *last_stamp_s_;
    candidate_ = Candidate{now_s, delay, delay, stamp_s, 1, own ? foreign_ && acceptable_own : stepped};
    return;
  }
  Candidate& c = *candidate_;
  if (stamp_s <= c.last_stamp_s) return;  // overtaken on the way, or never set
  c.least = std::min(c.least, delay);
  c.most = std::max(c.most, delay);
  c.last_stamp_s = stamp_s;
  ++c.samples;
  if (c.believable && c.samples >= config_.settle_samples && now_s - c.since_s >= config_.settle_s)
    take_over(c.least, now_s);
}

void StampClock::take_over(double offset_s, double now_s) {
  candidate_.reset();
  foreign_ = !config_.own || std::abs(offset_s) > config_.epoch_s;
  offset_ = foreign_ ? offset_s : 0.0;
  least_.fill(offset_);
  bucket_ = 0;
  bucket_since_s_ = followed_s_ = now_s;
  ++resets_;
  reset_words_ = foreign_ ? words("another clock is followed, %.9g s from flight time", -offset_)
                          : "the clock is flight time's own again";
}

void StampClock::follow(double delay_s, double now_s) {
  const double length_s = config_.window_s / kBuckets;
  if (now_s - bucket_since_s_ >= config_.window_s) {  // nothing else was heard within the window
    least_.fill(delay_s);
    bucket_since_s_ = now_s;
  }
  while (now_s - bucket_since_s_ >= length_s) {
    bucket_ = (bucket_ + 1) % kBuckets;
    bucket_since_s_ += length_s;
    least_[bucket_] = delay_s;
  }
  least_[bucket_] = std::min(least_[bucket_], delay_s);
  const double wanted = *std::min_element(least_.begin(), least_.end());
  const double reach = config_.drift * std::max(0.0, now_s - followed_s_);
  offset_ += std::clamp(wanted - offset_, -reach, reach);
  followed_s_ = std::max(followed_s_, now_s);
}

std::optional<StampRefusal> StampClock::place(double stamp_s, double now_s, double& flight_s) {
  if (!std::isfinite(stamp_s) || !std::isfinite(now_s)) {
    refusal_words_ = "stamp is not finite";
    return StampRefusal::not_finite;
  }
  const double ahead_s = stamp_s + offset_ - now_s;
  if (const auto refusal = find(ahead_s)) {
    const std::uint64_t before = resets_;
    consider(stamp_s, now_s, ahead_s);
    if (resets_ == before) return refusal;
  } else {
    candidate_.reset();
    if (foreign_) follow(now_s - stamp_s, now_s);
  }
  last_stamp_s_ = stamp_s;
  flight_s = foreign_ ? std::min(stamp_s + offset_, now_s) : stamp_s;
  return {};
}

}  // namespace omniflight::safety
