// Which inputs a control law takes.
#include "omniflight_control/controller.hpp"
#include "within.hpp"

namespace omniflight::control {
namespace {

bool is_unit(const Quat& q) {
  constexpr double kTolerance = 0.01;
  return std::abs(q.norm() - 1.0) <= kTolerance;  // false for NaN
}

bool takes(const Reference& r, const RigidState& s, double dt, const Vec6& unachieved) {
  using Most = LawInputLimits;
  const bool known_dt = dt == 0.0 || (dt >= Most::shortest_dt && dt <= Most::longest_dt);
  return known_dt && is_unit(r.q_WB) && is_unit(s.q_WB) && within(r.p_WB, Most::position) &&
         within(s.p_WB, Most::position) && within(r.v_WB_W, Most::velocity) &&
         within(s.v_WB_W, Most::velocity) && within(r.w_WB_B, Most::rate) && within(s.w_WB_B, Most::rate) &&
         within(r.a_WB_W, Most::acceleration) && within(r.dw_WB_B, Most::angular_acceleration) &&
         within(unachieved.head<3>(), Most::acceleration) &&
         within(unachieved.tail<3>(), Most::angular_acceleration);
}

}  // namespace

Vec6 Law::update(const Reference& reference, const RigidState& state, double dt, const Vec6& unachieved) {
  if (takes(reference, state, dt, unachieved))
    last_demand_ = answer(reference, state, dt, unachieved);
  else
    ++refused_;
  return last_demand_;
}

}  // namespace omniflight::control
