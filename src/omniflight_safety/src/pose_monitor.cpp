#include "omniflight_safety/pose_monitor.hpp"

#include <cmath>
#include <numeric>

#include "words.hpp"

namespace omniflight::safety {
namespace {

/// The reasons of a stamp are the first ones of a pose.
PoseRefusal of(StampRefusal refusal) { return static_cast<PoseRefusal>(refusal); }
static_assert(static_cast<int>(PoseRefusal::not_finite) == static_cast<int>(StampRefusal::not_finite));
static_assert(static_cast<int>(PoseRefusal::other_epoch) == static_cast<int>(StampRefusal::other_epoch));
static_assert(static_cast<int>(PoseRefusal::from_future) == static_cast<int>(StampRefusal::from_future));
static_assert(static_cast<int>(PoseRefusal::too_old) == static_cast<int>(StampRefusal::too_old));

}  // namespace

std::string_view to_string(PoseRefusal refusal) {
  static constexpr std::array<std::string_view, kPoseRefusals> names = {
      "not_finite", "other_epoch", "from_future", "too_old", "out_of_order", "frozen", "jump"};
  return names[static_cast<std::size_t>(refusal)];
}

std::optional<PoseRefusal> PoseMonitor::find(double stamp_s, const Vec3& p, const Quat& q, double now_s,
                                             bool free, const std::optional<ExpectedPose>& expected) {
  constexpr double kLeastNorm = 0.5;  // of a quaternion that is meant to be one
  if (!std::isfinite(stamp_s) || !std::isfinite(now_s) || !p.allFinite() || !q.coeffs().allFinite() ||
      q.norm() < kLeastNorm) {
    last_words_ = "a value is not finite, or the attitude is no quaternion";
    return PoseRefusal::not_finite;
  }
  if (const auto refusal = clock_.place(stamp_s, now_s, taken_s_)) {
    last_words_ = clock_.refusal_words();
    return of(*refusal);
  }
  if (believed_s_ && taken_s_ <= *believed_s_) {
    last_words_ = words("stamp %.4g s not after the last believed one", *believed_s_ - taken_s_);
    return PoseRefusal::out_of_order;
  }
  const bool equal = p == last_p_ && q.coeffs() == last_q_;
  repeats_ = equal ? repeats_ + 1 : 0;
  if (believed_s_ && (p - last_p_).norm() > config_.step_m + config_.step_mps * std::abs(taken_s_ - last_s_))
    steady_ = false;
  last_s_ = taken_s_;
  last_p_ = p;
  last_q_ = q.coeffs();
  if (free && repeats_ + 1 >= config_.frozen_samples) {
    last_words_ = words("%.0f equal poses in a row", repeats_ + 1.0);
    return PoseRefusal::frozen;
  }
  if (expected && believed_s_) {
    const double grown_m = config_.jump_growth_mps * (taken_s_ - *believed_s_);
    const double away_m = (p - expected->p_WB).norm();
    const double away_rad = expected->q_WB.angularDistance(q.normalized());
    constexpr double kArm = 1.0;  // m
    apart_m_ = std::max(away_m, kArm * away_rad);
    if (away_m > config_.jump_m + grown_m || away_rad > config_.jump_rad) {
      last_words_ = words("%.3g m and %.3g rad from where the vehicle is expected", away_m, away_rad);
      return PoseRefusal::jump;
    }
  }
  return {};
}

std::optional<PoseRefusal> PoseMonitor::judge(double stamp_s, const Vec3& p_WB, const Quat& q_WB,
                                              double now_s, bool free,
                                              const std::optional<ExpectedPose>& expected) {
  const auto refusal = find(stamp_s, p_WB, q_WB, now_s, free, expected);
  if (refusal) {
    ++refused_[static_cast<std::size_t>(*refusal)];
  } else {
    believed_s_ = taken_s_;
    steady_ = true;
  }
  return refusal;
}

std::uint64_t PoseMonitor::refused() const {
  return std::accumulate(refused_.begin(), refused_.end(), std::uint64_t{0});
}

}  // namespace omniflight::safety
