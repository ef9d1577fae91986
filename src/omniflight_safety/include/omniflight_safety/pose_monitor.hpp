// Whether a measured pose can be believed: its time, its repetition, its distance from what is expected.
#pragma once

#include <array>
#include <cstdint>
#include <omniflight_core/frames.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "omniflight_safety/stamp_clock.hpp"

namespace omniflight::safety {

enum class PoseRefusal : std::uint8_t {
  not_finite,    ///< NaN, infinity, or no quaternion
  other_epoch,   ///< stamp further from flight time than any delay, of a clock that is not followed (yet)
  from_future,   ///< stamp ahead of flight time
  too_old,       ///< stamp further behind flight time than the estimator remembers
  out_of_order,  ///< stamp not after the last believed one
  frozen,        ///< equal to the bit to the pose before, in flight
  jump,          ///< further from the expected pose than the vehicle can have moved
};
inline constexpr std::size_t kPoseRefusals = 7;
std::string_view to_string(PoseRefusal refusal);

struct PoseMonitorConfig {
  StampClockConfig stamps;  ///< whose stamps are believed, and how far from flight time
  int frozen_samples = 3;   ///< equal samples in a row, in free flight, that count as frozen
  double jump_m = 0.3;      ///< m from the expected position, without a gap
  double jump_rad = 0.6;    ///< rad from the expected attitude, without a gap
  double jump_growth_mps =
      0.5;                 ///< m/s that the allowed distance grows with the age of the last believed pose
  double step_mps = 10.0;  ///< m/s that the vehicle may move from one pose to the next
  double step_m = 0.05;    ///< m beside it: noise of two poses
};

struct ExpectedPose {
  Vec3 p_WB;
  Quat q_WB;
};

/// Remembers the last pose, the last believed pose, and counts what it refuses by reason.
class PoseMonitor {
 public:
  explicit PoseMonitor(const PoseMonitorConfig& config) : config_(config), clock_(config.stamps) {}

  /// Empty: believe it, as taken at believed_s(). stamp_s: of the source's clock. now_s: flight time. free:
  /// the vehicle flies (what is held in place may repeat itself).
  std::optional<PoseRefusal> judge(double stamp_s, const Vec3& p_WB, const Quat& q_WB, double now_s,
                                   bool free, const std::optional<ExpectedPose>& expected);

  /// Flight time [s] at which the last believed pose was taken.
  double believed_s() const { return believed_s_.value_or(-1.0); }
  /// m, with an arm of 1 m for the attitude: how far the last pose lies from the expected one. Zero when the
  /// poses themselves have leapt since the last believed one: then they are wrong, not the estimate.
  double apart_m() const { return steady_ ? apart_m_ : 0.0; }
  const StampClock& clock() const { return clock_; }
  std::uint64_t refused(PoseRefusal refusal) const { return refused_[static_cast<std::size_t>(refusal)]; }
  std::uint64_t refused() const;
  /// The last refusal in words with its size, for instance "stamp 1.73e+09 s ahead of flight time".
  const std::string& last_words() const { return last_words_; }

 private:
  std::optional<PoseRefusal> find(double stamp_s, const Vec3& p_WB, const Quat& q_WB, double now_s, bool free,
                                  const std::optional<ExpectedPose>& expected);
  PoseMonitorConfig config_;
  StampClock clock_;
  double taken_s_ = 0;  ///< flight time of the pose that is judged
  std::optional<double> believed_s_;
  Vec3 last_p_ = Vec3::Constant(1e300);
  Eigen::Vector4d last_q_ = Eigen::Vector4d::Zero();
  double last_s_ = 0;  ///< flight time of the last pose
  double apart_m_ = 0;
  bool steady_ = true;  ///< no leap since the last believed pose
  int repeats_ = 0;
  std::array<std::uint64_t, kPoseRefusals> refused_{};
  std::string last_words_;
};

}  // namespace omniflight::safety
