#include "omniflight_planning/timing.hpp"

#include <algorithm>
#include <cmath>

#include "actuation.hpp"
#include "minimum_jerk.hpp"
#include "rotation_length.hpp"
#include "shortest_ride.hpp"
#include "text.hpp"

namespace omniflight::planning {
namespace {

/// The rotation vector of q that lies nearest to `near`: it must not jump by a turn along a curve.
Vec3 log_near(const Quat& q, const Vec3& near) {
  const Vec3 phi = log_rotation(q);
  if (phi.norm() < 1e-9) return phi;
  const Vec3 other = phi - 2.0 * kPi * phi.normalized();
  return (other - near).norm() < (phi - near).norm() ? other : phi;
}

/// Minimum-jerk law on [0, 1] with its derivatives.
struct Law {
  double u, du, ddu;
  explicit Law(double s)
      : u(s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)),
        du(30.0 * s * s * (1.0 - s) * (1.0 - s)),
        ddu(60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)) {}
};

}  // namespace

PoseCurve::PoseCurve(const std::vector<Pose>& poses) : q_WF_(poses.front().q_WB.normalized()) {
  Vec3 phi = Vec3::Zero();
  for (const Pose& pose : poses) {
    phi = log_near(q_WF_.conjugate() * pose.q_WB, phi);
    Vec6 x;
    x << pose.p_WB, phi;
    if (value_.empty()) {
      u_.push_back(0.0);
    } else {
      const Vec6 d = x - value_.back();
      const double step = d.head<3>().norm() + kRotationLength * d.tail<3>().norm();
      if (step < 1e-9) continue;
      u_.push_back(u_.back() + step);
    }
    value_.push_back(x);
  }
  // Natural spline: tridiagonal system for the second derivatives at the inner places (Thomas).
  const std::size_t n = value_.size();
  curvature_.assign(n, Vec6::Zero());
  if (n < 3) return;
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h0 = u_[i] - u_[i - 1], h1 = u_[i + 1] - u_[i];
    const Vec6 right = 6.0 * ((value_[i + 1] - value_[i]) / h1 - (value_[i] - value_[i - 1]) / h0);
    const double pivot = 2.0 * (h0 + h1) - h0 * upper[i - 1];
    upper[i] = h1 / pivot;
    curvature_[i] = (right - h0 * curvature_[i - 1]) / pivot;
  }
  for (std::size_t i = n - 2; i >= 1; --i) curvature_[i] -= upper[i] * curvature_[i + 1];
}

Reference PoseCurve::at(double u, double du, double ddu) const {
  Reference r;
  Vec6 x = value_.front(), dx = Vec6::Zero(), ddx = Vec6::Zero();
  if (value_.size() > 1) {
    u = std::clamp(u, 0.0, u_.back());
    const auto next = std::upper_bound(u_.begin() + 1, u_.end() - 1, u);
    const auto k = static_cast<std::size_t>(next - u_.begin()) - 1;
    const double h = u_[k + 1] - u_[k], a = (u_[k + 1] - u) / h, b = (u - u_[k]) / h;
    const Vec6 &m0 = curvature_[k], &m1 = curvature_[k + 1];
    x = a * value_[k] + b * value_[k + 1] + h * h / 6.0 * ((a * a * a - a) * m0 + (b * b * b - b) * m1);
    dx = (value_[k + 1] - value_[k]) / h + h / 6.0 * ((3.0 * b * b - 1.0) * m1 - (3.0 * a * a - 1.0) * m0);
    ddx = a * m0 + b * m1;
  }
  const Vec6 rate = dx * du, second = ddx * du * du + dx * ddu;
  r.p_WB = x.head<3>();
  r.v_WB_W = rate.head<3>();
  r.a_WB_W = second.head<3>();
  r.q_WB = (q_WF_ * exp_rotation(x.tail<3>())).normalized();
  const Mat3 J = right_jacobian(x.tail<3>());
  r.w_WB_B = J * rate.tail<3>();
  r.dw_WB_B = J * second.tail<3>() + jacobian_rate_times(x.tail<3>(), rate.tail<3>());
  return r;
}

MotionPeaks peaks(const std::vector<TrajectoryKnot>& knots, const Rotors& rotors) {
  MotionPeaks out;
  Rotors::Thrusts thrusts(rotors);
  vehicle::RotorVector before;
  Vec6 wrench_before = Vec6::Zero();
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const auto& knot = knots[k];
    const Reference& r = knot.reference;
    out.speed = std::max(out.speed, r.v_WB_W.norm());
    out.acceleration = std::max(out.acceleration, r.a_WB_W.norm());
    out.rate = std::max(out.rate, r.w_WB_B.norm());
    out.angular_acceleration = std::max(out.angular_acceleration, r.dw_WB_B.norm());
    const Vec6 wrench = rotors.load().required_wrench(r);
    if (k > 0 && wrench == wrench_before) continue;  // a hold asks nothing new
    if (const double load = rotors.load().load(wrench); load > out.rotor_load) {
      out.rotor_load = load;
      out.rotor_load_at = knot.t;
    }
    const vehicle::RotorVector now = thrusts.of(wrench);
    if (k > 0)
      if (const auto rate = rotors.rate(before, now, knot.t - knots[k - 1].t);
          rate.share > out.thrust_rate.share)
        out.thrust_rate = rate, out.thrust_rate_at = knot.t;
    before = now, wrench_before = wrench;
  }
  return out;
}

MotionPeaks larger(const MotionPeaks& a, MotionPeaks b, double start) {
  b.rotor_load_at += start;
  b.thrust_rate_at += start;
  if (a.thrust_rate.share > b.thrust_rate.share)
    b.thrust_rate = a.thrust_rate, b.thrust_rate_at = a.thrust_rate_at;
  if (a.rotor_load > b.rotor_load) b.rotor_load = a.rotor_load, b.rotor_load_at = a.rotor_load_at;
  b.speed = std::max(a.speed, b.speed);
  b.acceleration = std::max(a.acceleration, b.acceleration);
  b.rate = std::max(a.rate, b.rate);
  b.angular_acceleration = std::max(a.angular_acceleration, b.angular_acceleration);
  b.lean = std::max(a.lean, b.lean);
  return b;
}

std::vector<TrajectoryKnot> minimum_jerk_knots(const PoseCurve& curve,
                                               const std::function<double(double)>& tilt, int intervals,
                                               double duration) {
  std::vector<TrajectoryKnot> knots;
  knots.reserve(static_cast<std::size_t>(intervals) + 1);
  for (int i = 0; i <= intervals; ++i) {
    const Law law(static_cast<double>(i) / intervals);
    const double u = curve.length() * law.u;
    Reference r =
        curve.at(u, curve.length() * law.du / duration, curve.length() * law.ddu / (duration * duration));
    r.alpha = tilt(u);
    knots.push_back({duration * i / intervals, r});
  }
  return knots;
}

namespace {

Failure unhoverable(const Quat& q_WB, double load, double allowed, double alpha) {
  const Vec3 rpy = roll_pitch_yaw(q_WB);
  return fail(
      ErrorCode::incomplete,
      text(
          "the attitude roll %.1f, pitch %.1f, yaw %.1f deg on the way needs %.0f %% of the rotors' range to "
          "hover at alpha %.1f deg, %.0f %% are allowed",
          to_degrees(rpy.x()), to_degrees(rpy.y()), to_degrees(rpy.z()), 100.0 * load, to_degrees(alpha),
          100.0 * allowed),
      "", "Choose another alpha or attitude, or less headroom");
}

}  // namespace

Result<double> least_time(const std::vector<TrajectoryKnot>& in_a_second,
                          const std::vector<const Rotors*>& rotors, const MotionLimits& limits,
                          double slowest, const Deadline& deadline) {
  const double allowed = 1.0 - limits.rotor_headroom;
  // With the shape fixed, speeds go with 1/T and accelerations with 1/T^2, so the kinematic limits give T at
  // once; the required wrench is that of hovering plus a part that goes with 1/T^2, so its load falls with T.
  std::vector<Vec6> hover, beyond;
  MotionPeaks unit;
  for (std::size_t i = 0; i < in_a_second.size(); ++i) {
    const Reference& r = in_a_second[i].reference;
    const allocation::RotorLoad& load_of = rotors[i]->load();
    Reference still;
    still.q_WB = r.q_WB;
    hover.push_back(load_of.required_wrench(still));
    beyond.push_back(load_of.required_wrench(r) - hover.back());
    if (const double load = load_of.load(hover.back()); load > allowed)
      return unhoverable(r.q_WB, load, allowed, load_of.alpha());
    unit.speed = std::max(unit.speed, r.v_WB_W.norm());
    unit.acceleration = std::max(unit.acceleration, r.a_WB_W.norm());
    unit.rate = std::max(unit.rate, r.w_WB_B.norm());
    unit.angular_acceleration = std::max(unit.angular_acceleration, r.dw_WB_B.norm());
  }
  const double low = std::max(
      {unit.speed / limits.speed, unit.rate / limits.rate, std::sqrt(unit.acceleration / limits.acceleration),
       std::sqrt(unit.angular_acceleration / limits.angular_acceleration), 0.1, slowest});
  const auto fits = [&](double T) {
    for (std::size_t i = 0; i < hover.size(); ++i)
      if (rotors[i]->load().load(hover[i] + beyond[i] / (T * T)) > allowed) return false;
    return true;
  };
  return shortest_time(low, fits, deadline);
}

Result<double> least_time(const PoseCurve& curve, const Rotors& rotors, const MotionLimits& limits,
                          const Deadline& deadline, int samples) {
  const double alpha = rotors.load().alpha();
  const std::vector<TrajectoryKnot> in_a_second = minimum_jerk_knots(
      curve, [alpha](double) { return alpha; }, samples, 1.0);
  const auto least = least_time(in_a_second, std::vector(in_a_second.size(), &rotors), limits, 0.0, deadline);
  if (!least) return least;
  if (auto ok = check_actuation(in_a_second, rotors.load()); !ok) return Failure(ok.error());
  return least;
}

Result<std::vector<TrajectoryKnot>> ride_from(double least, const PoseCurve& curve, const Rotors& rotors,
                                              const MotionLimits& limits, const Deadline& deadline) {
  return first_ride(
      least,
      [&](int intervals, double duration) {
        return minimum_jerk_knots(
            curve, [&](double) { return rotors.load().alpha(); }, intervals, duration);
      },
      [&](const std::vector<TrajectoryKnot>& knots) { return within(peaks(knots, rotors), limits); },
      deadline);
}

Result<std::vector<TrajectoryKnot>> ride(const PoseCurve& curve, const Rotors& rotors,
                                         const MotionLimits& limits, const Deadline& deadline) {
  const auto least = least_time(curve, rotors, limits, deadline);
  if (!least) return Failure(least.error());
  return ride_from(*least, curve, rotors, limits, deadline);
}

}  // namespace omniflight::planning
