#include "stop_ride.hpp"

#include <algorithm>
#include <cmath>

#include "text.hpp"

namespace omniflight::planning {
namespace {

constexpr double kShortest = 0.05, kLongest = 30.0;  // s
constexpr double kLonger = 1.08;                     // from one duration to the next
constexpr int kMostBlocked = 12;                     // stops that keep the limits and are not free
constexpr double kRounding = 1e-6;
const char* const kKeep = "Keep flying the old plan, or begin at another time of it";

/// A quintic on [0, 1] with given value and two derivatives at 0 and none of them at 1, its derivatives, and
/// the integral from 0.
struct Decay {
  double integral, value, first, second;
};
struct Basis {
  Decay of_value, of_first, of_second;
  explicit Basis(double s) {
    const double s2 = s * s, s3 = s2 * s, s4 = s3 * s, s5 = s4 * s, s6 = s5 * s;
    of_value = {s - 2.5 * s4 + 3.0 * s5 - s6, 1.0 - 10.0 * s3 + 15.0 * s4 - 6.0 * s5,
                -30.0 * s2 + 60.0 * s3 - 30.0 * s4, -60.0 * s + 180.0 * s2 - 120.0 * s3};
    of_first = {0.5 * s2 - 1.5 * s4 + 1.6 * s5 - 0.5 * s6, s - 6.0 * s3 + 8.0 * s4 - 3.0 * s5,
                1.0 - 18.0 * s2 + 32.0 * s3 - 15.0 * s4, -36.0 * s + 96.0 * s2 - 60.0 * s3};
    of_second = {s3 / 6.0 - 0.375 * s4 + 0.3 * s5 - s6 / 12.0, 0.5 * s2 - 1.5 * s3 + 1.5 * s4 - 0.5 * s5,
                 s - 4.5 * s2 + 6.0 * s3 - 2.5 * s4, 1.0 - 9.0 * s + 18.0 * s2 - 10.0 * s3};
  }
};

/// What exceeds its limit, with both numbers; empty where nothing does.
std::string exceeded(const MotionPeaks& most, const MotionLimits& limits) {
  const struct {
    const char* what;
    double value, limit;
  } bounds[] = {
      {"the speed comes to %.4g m/s, %.4g are allowed", most.speed, limits.speed},
      {"the acceleration comes to %.4g m/s2, %.4g are allowed", most.acceleration, limits.acceleration},
      {"the rate comes to %.4g rad/s, %.4g are allowed", most.rate, limits.rate},
      {"the angular acceleration comes to %.4g rad/s2, %.4g are allowed", most.angular_acceleration,
       limits.angular_acceleration},
      {"the rotors need %.4g of their range, %.4g are allowed", most.rotor_load, 1.0 - limits.rotor_headroom},
      {"the rotors need %.4g of the rate of thrust that their lag allows, %.4g are allowed",
       most.thrust_rate.share, 1.0 - limits.rotor_headroom}};
  for (const auto& b : bounds)
    if (!(b.value <= b.limit * (1.0 + kRounding))) return text(b.what, b.value, b.limit);
  return {};
}

}  // namespace

Knots stop_in(double duration, const FlightState& from) {
  const Reference& r0 = from.reference;
  const auto steps = std::max<long>(1, std::lround(duration / kKnotPeriod));
  const double T = static_cast<double>(steps) * kKnotPeriod;
  Knots out;
  for (long i = 0; i <= steps; ++i) {
    const Basis b(static_cast<double>(i) / static_cast<double>(steps));
    const auto sum = [&](double Decay::*part, const Vec3& x, const Vec3& dx, const Vec3& ddx) {
      return Vec3(b.of_value.*part * x + T * (b.of_first.*part) * dx + T * T * (b.of_second.*part) * ddx);
    };
    TrajectoryKnot knot;
    knot.t = static_cast<double>(i) * kKnotPeriod;
    Reference& r = knot.reference;
    r.alpha = r0.alpha;
    r.p_WB = r0.p_WB + T * sum(&Decay::integral, r0.v_WB_W, r0.a_WB_W, from.j_WB_W);
    r.v_WB_W = sum(&Decay::value, r0.v_WB_W, r0.a_WB_W, from.j_WB_W);
    r.a_WB_W = sum(&Decay::first, r0.v_WB_W, r0.a_WB_W, from.j_WB_W) / T;
    // rotation vector from the first attitude: there its derivatives are rate and angular acceleration
    const Vec3 phi = T * sum(&Decay::integral, r0.w_WB_B, r0.dw_WB_B, Vec3::Zero());
    const Vec3 dphi = sum(&Decay::value, r0.w_WB_B, r0.dw_WB_B, Vec3::Zero());
    const Vec3 ddphi = sum(&Decay::first, r0.w_WB_B, r0.dw_WB_B, Vec3::Zero()) / T;
    const Mat3 J = right_jacobian(phi);
    r.q_WB = (r0.q_WB * exp_rotation(phi)).normalized();
    r.w_WB_B = J * dphi;
    r.dw_WB_B = J * ddphi + jacobian_rate_times(phi, dphi);
    out.push_back(knot);
  }
  Reference& last = out.back().reference;  // at rest to the last digit
  last.v_WB_W.setZero(), last.a_WB_W.setZero(), last.w_WB_B.setZero(), last.dw_WB_B.setZero();
  return out;
}

Result<Knots> come_to_rest(const FlightState& from, const AtTilt& here, const MotionLimits& limits,
                           const Deadline& deadline) {
  TrajectoryKnot now;
  now.reference = from.reference;
  if (at_rest(from)) return Knots{now};
  if (const std::string why = exceeded(peaks({now}, *here.rotors), limits); !why.empty())
    return fail(ErrorCode::incomplete,
                "join_over_limits: " + why + ", in the state that the plan begins from", "", kKeep);
  std::string why_not = "no stop was tried";
  int blocked = 0;
  for (double duration = kShortest; duration <= kLongest && blocked < kMostBlocked; duration *= kLonger) {
    if (deadline.passed()) return out_of_time(deadline, "looking for a stop from the state in flight");
    const Knots knots = stop_in(duration, from);
    if (blocked == 0) why_not = "join_over_limits: ";
    if (const std::string why = exceeded(peaks(knots, *here.rotors), limits); !why.empty()) {
      if (blocked == 0) why_not += why + text(", in a stop of %.2f s", knots.back().t);
      continue;
    }
    auto curve = Trajectory::create(knots);
    if (!curve) return Failure(curve.error());
    const CurveCheck check = here.check.advance_along(*curve, deadline);
    if (check.out_of_time) return out_of_time(deadline, "checking a stop from the state in flight");
    if (check.free && here.check.valid({knots.back().reference.p_WB, knots.back().reference.q_WB}))
      return knots;
    ++blocked;
    why_not = text("join_blocked: a stop of %.2f s comes too near to the map at (%.2f, %.2f, %.2f) m",
                   knots.back().t, check.p_W.x(), check.p_W.y(), check.p_W.z());
  }
  return fail(ErrorCode::incomplete, why_not, "", kKeep);
}

}  // namespace omniflight::planning
