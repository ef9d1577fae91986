#include "verdict.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "omniflight_campaign/judged_part.hpp"
#include "omniflight_planning/flown.hpp"

namespace omniflight::cli {
namespace {

using recording::Recording;
using recording::Signal;

constexpr double kLate = 0.3;        // s that the last reference may be missing of the end
constexpr double kPoseEvery = 0.01;  // s between poses held against the map

/// When the plan ends on the recording's clock [s], from its first motion.
double planned_end(const Expected& e, const FlightMetrics& m, const Signal& reference) {
  const auto motion = campaign::motion_of(e.plan.trajectory);
  const double begin = motion ? m.from - motion->first : reference.t_s.front();
  return begin + e.plan.trajectory.duration();
}

std::vector<planning::FlownPose> path_of(const Recording& r, bool truth, double alpha) {
  const Signal* p = truth ? r.find("truth_position") : r.find("position");
  const Signal* q = truth ? r.find("truth_attitude") : r.find("attitude");
  if (!p || !q) p = r.find("est_position"), q = r.find("est_attitude");
  std::vector<planning::FlownPose> out;
  if (!p || !q) return out;
  std::vector<double> times;
  for (const double t : p->t_s)
    if (times.empty() || t - times.back() >= kPoseEvery - 1e-9) times.push_back(t);
  const Eigen::MatrixXd at = recording::resample(*p, times), turned = recording::resample(*q, times);
  const Signal* tilt = truth && r.find("truth_alpha") ? r.find("truth_alpha") : r.find("alpha");
  const Eigen::MatrixXd alphas = tilt ? recording::resample(*tilt, times) : Eigen::MatrixXd();
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (!at.row(i).allFinite() || !turned.row(i).allFinite()) continue;
    planning::FlownPose f{times[k], {}, alpha};
    f.pose.p_WB = at.row(i).head<3>().transpose();
    f.pose.q_WB = Quat(turned(i, 0), turned(i, 1), turned(i, 2), turned(i, 3)).normalized();
    if (alphas.rows() > i && std::isfinite(alphas(i, 0))) f.alpha = alphas(i, 0);
    out.push_back(f);
  }
  return out;
}

struct RotorUse {
  double least_headroom = 1;  ///< share of the largest thrust that was free, of the rotor that had least
  double at_limit = 0;        ///< share of the samples with a rotor at its limit
};

/// Of the commanded thrusts while the reference moves; a command at the limit is control that was not there.
std::optional<RotorUse> rotor_use(const Recording& r, const vehicle::Vehicle& v, const FlightMetrics& m) {
  const Signal* thrust = r.find("thrust_command");
  if (!thrust) return std::nullopt;
  RotorUse out;
  std::size_t used = 0, at_limit = 0;
  const int rotors = std::min<int>(v.rotor_count(), static_cast<int>(thrust->width()));
  for (Eigen::Index i = 0; i < thrust->size(); ++i) {
    const double t = thrust->t_s[static_cast<std::size_t>(i)];
    if (t < m.from || t > m.to) continue;
    double most = 0;
    for (int k = 0; k < rotors; ++k)
      most =
          std::max(most, std::abs(thrust->values(i, k)) / v.rotors[static_cast<std::size_t>(k)].max_thrust);
    ++used;
    at_limit += most >= campaign::kAtLimit;
    out.least_headroom = std::min(out.least_headroom, 1 - most);
  }
  if (used == 0) return std::nullopt;
  out.at_limit = static_cast<double>(at_limit) / static_cast<double>(used);
  return out;
}

/// The mission's bounds, or the tube that the plan keeps in its margin, whichever is larger: errors that were
/// measured are paid for, and the largest of one flight is no bound for the next.
planning::Tube allowed(const Expected& e) {
  planning::Tube out = tube_of(e.mission, e.vehicle);
  const planning::Tube& kept = e.plan.certificate.tube;
  if (!kept.in_margin) return out;
  out.position = std::max(out.position, kept.position);
  out.attitude = std::max(out.attitude, kept.attitude);
  return out;
}

class Judge {
 public:
  Judge(const Expected& e, const Recording& r, const FlightMetrics& m)
      : e_(e), r_(r), m_(m), tracking_(m.has_truth ? m.truth : m.measured), tube_(allowed(e)) {}

  FlightVerdict verdict() {
    ended();
    if (!v_.complete) return v_;
    left_reference();
    clearance();
    tracked();
    reached();
    headroom();
    return v_;
  }

 private:
  void find(const char* word, std::string reason) {
    if (v_.word == kFlown || (v_.word == std::string(kFlownBadly) && word == std::string(kLost)))
      v_.word = word, v_.reason = std::move(reason);
  }
  void ended() {
    const Signal& reference = *r_.find("ref_position");
    end_ = planned_end(e_, m_, reference);
    const double last = reference.t_s.back();
    v_.complete = last >= end_ + e_.after - kLate;
    v_.figures["planned_end_s"] = end_;
    v_.figures["last_reference_s"] = last;
    if (v_.complete) return;
    v_.word = kNotFlown;
    v_.reason = fmt::format("the flight ended at {:.1f} s of its recording, the plan goes on to {:.1f} s",
                            last, end_ + e_.after);
  }
  void left_reference() {
    const double distance = tracking_.position_rmse.norm(), angle = tracking_.attitude_rmse.norm();
    if (!(distance < kLeftReference && angle < kTurnedAway))
      find(kLost, fmt::format("the vehicle left its reference{} (RMSE {:.2f} m, {:.0f} deg)",
                              tracking_.left_at ? fmt::format(" at {:.1f} s", *tracking_.left_at) : "",
                              distance, angle));
  }
  /// Of the plan alone. Before it a simulated vehicle is released from where it was held, and sags by what
  /// its controller does not know yet; that is remarked.
  void clearance() {
    auto before = path_of(r_, m_.has_truth, e_.plan.certificate.alpha);
    const double begin = end_ - e_.plan.trajectory.duration();
    const auto first = std::find_if(before.begin(), before.end(), [&](auto& f) { return f.t >= begin; });
    const std::vector<planning::FlownPose> path(first, before.end());
    before.erase(first, before.end());
    if (const auto way = planning::flown_clearance(before, e_.vehicle, e_.mission.test_bed, e_.mission.zones);
        way && way->least < 0)
      v_.remarks.push_back(fmt::format(
          "before the plan began, at {:.1f} s, the vehicle came {:.3f} m into the obstacles of the map",
          way->at, -way->least));
    const auto found = planning::flown_clearance(path, e_.vehicle, e_.mission.test_bed, e_.mission.zones);
    if (!found || path.empty()) {
      v_.figures["min_clearance_m"] = nullptr;
      find(kFlownBadly,
           "its clearance is not known: " + (found ? "no pose was recorded" : found.error().text()));
      return;
    }
    v_.figures["min_clearance_m"] = found->least;
    v_.figures["min_clearance_at_s"] = found->at;
    if (found->least < 0)
      find(kLost,
           fmt::format(
               "the vehicle came {:.3f} m into the obstacles of the map at {:.1f} s, near ({:.2f}, {:.2f}, "
               "{:.2f}) m",
               -found->least, found->at, found->p_WB.x(), found->p_WB.y(), found->p_WB.z()));
  }
  void reached() {
    double worst = 0;
    for (const auto& f : path_of(r_, m_.has_truth, 0))
      if (f.t >= end_ - campaign::kAtEnd && f.t <= end_)
        worst = std::max(worst, (f.pose.p_WB - e_.plan.trajectory.knots().back().reference.p_WB).norm());
    v_.figures["end_error_m"] = worst;
    if (worst > tube_.position)
      find(worst > kLeftReference ? kLost : kFlownBadly,
           fmt::format("the end was not reached: {:.3f} m from it, {:.3f} m are allowed", worst,
                       tube_.position));
  }
  void tracked() {
    const double degrees = to_degrees(tube_.attitude);
    v_.figures["worst_position_m"] = tracking_.worst_position;
    v_.figures["position_bound_m"] = tube_.position;
    v_.figures["worst_attitude_deg"] = tracking_.worst_attitude;
    v_.figures["attitude_bound_deg"] = degrees;
    if (tracking_.worst_position > tube_.position)
      find(kFlownBadly, fmt::format("it was {:.3f} m from its reference at {:.1f} s, {:.3f} m are allowed",
                                    tracking_.worst_position, tracking_.worst_position_at, tube_.position));
    if (tracking_.worst_attitude > degrees)
      find(kFlownBadly,
           fmt::format("it was turned {:.1f} deg from its reference at {:.1f} s, {:.1f} deg are allowed",
                       tracking_.worst_attitude, tracking_.worst_attitude_at, degrees));
  }
  void headroom() {
    const auto use = rotor_use(r_, e_.vehicle, m_);
    if (!use) return;
    v_.figures["least_headroom"] = use->least_headroom;
    v_.figures["share_at_limit"] = use->at_limit;
    v_.figures["share_at_limit_bound"] = nullptr;
    if (!(e_.mission.limits.rotor_headroom > 0))
      return;  // a mission that plans with whole rotors may use them
    v_.figures["share_at_limit_bound"] = kMostAtLimit;
    if (use->at_limit > kMostAtLimit)
      find(kFlownBadly,
           fmt::format("a rotor was at its limit for {:.1f} % of the flight, {:.0f} % are allowed",
                       100 * use->at_limit, 100 * kMostAtLimit));
  }

  const Expected& e_;
  const Recording& r_;
  const FlightMetrics& m_;
  const Tracking& tracking_;
  planning::Tube tube_;
  double end_ = 0;
  FlightVerdict v_;
};

}  // namespace

FlightVerdict judge_flight(const Expected& expected, const Recording& recording,
                           const FlightMetrics& metrics) {
  return Judge(expected, recording, metrics).verdict();
}

}  // namespace omniflight::cli
