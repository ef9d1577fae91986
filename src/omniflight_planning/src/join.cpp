#include "omniflight_planning/join.hpp"

#include <algorithm>
#include <cmath>

#include "text.hpp"

namespace omniflight::planning {
namespace {

constexpr double kAtRest = 1e-6;  // m/s, m/s^2, m/s^3, rad/s, rad/s^2

}  // namespace

Vec3 jerk_between(const TrajectoryKnot& k0, const TrajectoryKnot& k1, double s) {
  const Reference &a = k0.reference, &b = k1.reference;
  const double h = k1.t - k0.t;
  // cubic, quartic and quintic coefficients of the Hermite polynomial
  const Vec3 dx = b.p_WB - a.p_WB - h * a.v_WB_W - 0.5 * h * h * a.a_WB_W;
  const Vec3 dv = b.v_WB_W - a.v_WB_W - h * a.a_WB_W, da = b.a_WB_W - a.a_WB_W;
  const Vec3 c3 = (10.0 * dx - 4.0 * h * dv + 0.5 * h * h * da) / std::pow(h, 3);
  const Vec3 c4 = (-15.0 * dx + 7.0 * h * dv - h * h * da) / std::pow(h, 4);
  const Vec3 c5 = (6.0 * dx - 3.0 * h * dv + 0.5 * h * h * da) / std::pow(h, 5);
  return 6.0 * c3 + 24.0 * s * c4 + 60.0 * s * s * c5;
}

Result<FlightState> state_at(const Trajectory& trajectory, double t) {
  const auto& knots = trajectory.knots();
  if (knots.size() < 2) return bad_input("the trajectory has no motion to begin from");
  if (!(t >= 0.0 && t <= trajectory.duration()))
    return bad_input(
        text("%.3f s lies outside of the trajectory, which lasts %.3f s", t, trajectory.duration()), "",
        "Give a time [s] within it");
  FlightState out;
  out.reference = trajectory.sample(t);
  auto next = std::lower_bound(knots.begin() + 1, knots.end() - 1, t,
                               [](const TrajectoryKnot& k, double value) { return k.t < value; });
  if (next->reference.alpha != (next - 1)->reference.alpha)
    return bad_input(text("the tilt of the rotors moves at %.3f s, and plans begin at a tilt that rests", t),
                     "", "Give a time at which it rests");
  out.j_WB_W = jerk_between(*(next - 1), *next, std::max(0.0, t - (next - 1)->t));
  // the last knot is sampled at rest, which it is; before the first motion there was none
  if (t <= 0.0 || t >= trajectory.duration()) out.j_WB_W.setZero();
  return out;
}

bool at_rest(const FlightState& state) {
  const Reference& r = state.reference;
  return r.v_WB_W.norm() + r.a_WB_W.norm() + state.j_WB_W.norm() + r.w_WB_B.norm() + r.dw_WB_B.norm() <
         kAtRest;
}

}  // namespace omniflight::planning
