#include "omniflight_core/trajectory.hpp"

#include <algorithm>

namespace omniflight {
namespace {

using Quintic = Eigen::Matrix<double, 3, 6>;

/// Coefficients of the quintic with the given value and two derivatives at both ends of [0, h].
Quintic quintic_hermite(const Vec3& x0, const Vec3& v0, const Vec3& a0, const Vec3& x1, const Vec3& v1,
                        const Vec3& a1, double h) {
  Quintic c;
  const Vec3 dx = x1 - x0 - v0 * h - 0.5 * a0 * h * h;
  const Vec3 dv = v1 - v0 - a0 * h;
  const Vec3 da = a1 - a0;
  c.col(0) = x0;
  c.col(1) = v0;
  c.col(2) = 0.5 * a0;
  c.col(3) = (10.0 * dx - 4.0 * dv * h + 0.5 * da * h * h) / (h * h * h);
  c.col(4) = (-15.0 * dx + 7.0 * dv * h - da * h * h) / (h * h * h * h);
  c.col(5) = (6.0 * dx - 3.0 * dv * h + 0.5 * da * h * h) / (h * h * h * h * h);
  return c;
}

struct Jet3 {
  Vec3 x, v, a;
};

Jet3 evaluate(const Quintic& c, double s) {
  Jet3 out;
  out.x = c.col(5);
  out.v.setZero();
  out.a.setZero();
  for (int k = 4; k >= 0; --k) {
    out.a = out.a * s + 2.0 * out.v;
    out.v = out.v * s + out.x;
    out.x = out.x * s + c.col(k);
  }
  return out;
}

bool finite(const Reference& r) {
  return r.p_WB.allFinite() && r.q_WB.coeffs().allFinite() && r.v_WB_W.allFinite() && r.w_WB_B.allFinite() &&
         r.a_WB_W.allFinite() && r.dw_WB_B.allFinite() && std::isfinite(r.alpha) &&
         std::abs(r.q_WB.norm() - 1.0) < 1e-3;
}

}  // namespace

Result<Trajectory> Trajectory::create(std::vector<TrajectoryKnot> knots) {
  if (knots.empty()) return bad_input("a trajectory needs at least one knot");
  if (knots.front().t != 0.0)
    return bad_input("the first knot is at t = " + std::to_string(knots.front().t) + " s, not 0 s", "knot 0");
  Trajectory out;
  out.intervals_.reserve(knots.size() - 1);
  for (std::size_t k = 0; k < knots.size(); ++k) {
    if (!std::isfinite(knots[k].t) || !finite(knots[k].reference))
      return bad_input("a value is not finite or the quaternion is not a unit one",
                       "knot " + std::to_string(k));
    knots[k].reference.q_WB.normalize();
    if (k == 0) continue;
    const double h = knots[k].t - knots[k - 1].t;
    if (h <= 0.0) return bad_input("time does not increase", "knot " + std::to_string(k));
    const Reference &r0 = knots[k - 1].reference, &r1 = knots[k].reference;
    Interval interval;
    interval.position = quintic_hermite(r0.p_WB, r0.v_WB_W, r0.a_WB_W, r1.p_WB, r1.v_WB_W, r1.a_WB_W, h);
    // attitude: R(t) = R0 exp(phi(t)), phi quintic with end derivatives from the body rates
    const Vec3 phi1 = log_rotation(r0.q_WB.conjugate() * r1.q_WB);
    if (phi1.norm() > 3.1)
      return bad_input("more than half a turn between knots", "knot " + std::to_string(k));
    const Mat3 Ji = right_jacobian_inverse(phi1);
    const Vec3 dphi1 = Ji * r1.w_WB_B;
    const Vec3 ddphi1 = Ji * (r1.dw_WB_B - jacobian_rate_times(phi1, dphi1));
    interval.rotation = quintic_hermite(Vec3::Zero(), r0.w_WB_B, r0.dw_WB_B, phi1, dphi1, ddphi1, h);
    interval.alpha0 = r0.alpha;
    interval.alpha_rate = (r1.alpha - r0.alpha) / h;
    out.intervals_.push_back(interval);
  }
  out.knots_ = std::move(knots);
  return out;
}

Reference Trajectory::sample(double t) const {
  const auto at_rest = [](Reference r) {
    r.v_WB_W.setZero();
    r.w_WB_B.setZero();
    r.a_WB_W.setZero();
    r.dw_WB_B.setZero();
    return r;
  };
  if (knots_.empty()) return {};
  if (t < 0.0) return at_rest(knots_.front().reference);
  if (t >= knots_.back().t) return at_rest(knots_.back().reference);
  const auto next = std::upper_bound(knots_.begin(), knots_.end(), t,
                                     [](double value, const TrajectoryKnot& k) { return value < k.t; });
  const std::size_t k = static_cast<std::size_t>(next - knots_.begin()) - 1;
  const double s = t - knots_[k].t;
  const Interval& interval = intervals_[k];
  const Jet3 p = evaluate(interval.position, s), phi = evaluate(interval.rotation, s);
  Reference out;
  out.p_WB = p.x;
  out.v_WB_W = p.v;
  out.a_WB_W = p.a;
  out.q_WB = knots_[k].reference.q_WB * exp_rotation(phi.x);
  const Mat3 J = right_jacobian(phi.x);
  out.w_WB_B = J * phi.v;
  out.dw_WB_B = J * phi.a + jacobian_rate_times(phi.x, phi.v);
  out.alpha = interval.alpha0 + interval.alpha_rate * s;
  return out;
}

}  // namespace omniflight
