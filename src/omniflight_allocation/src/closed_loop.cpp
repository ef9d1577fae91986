#include "omniflight_allocation/closed_loop.hpp"

#include "omniflight_allocation/allocator.hpp"

namespace omniflight::allocation {
namespace {

constexpr int kSubsteps = 4;
constexpr double kPeriod = 0.01, kDt = kPeriod / kSubsteps;  // s
constexpr double kLost = 2.0;                                // m

void step(RigidState& x, const Vec6& wrench, const vehicle::Vehicle& v) {
  for (int j = 0; j < kSubsteps; ++j) {
    x.v_WB_W += kDt * (x.q_WB * wrench.head<3>() / v.mass - kGravity * Vec3::UnitZ());
    x.w_WB_B += kDt * (v.inertia.inverse() * (wrench.tail<3>() - x.w_WB_B.cross(v.inertia * x.w_WB_B)));
    x.p_WB += kDt * x.v_WB_W;
    x.q_WB = (x.q_WB * exp_rotation(kDt * x.w_WB_B)).normalized();
  }
}

}  // namespace

Vec3 quintic(double x) {
  if (x <= 0) return {0, 0, 0};
  if (x >= 1) return {1, 0, 0};
  return {x * x * x * (10 - 15 * x + 6 * x * x), 30 * x * x * (1 - x) * (1 - x),
          60 * x * (1 - 3 * x + 2 * x * x)};
}

Reference thesis_reference(double t, double pitch_time) {
  Reference r;
  const Vec3 move = quintic((t - 2.0) / 2.0), away(0.5, 0.4, 0.0);
  r.p_WB = Vec3(0, 0, 1) + move[0] * away;
  r.v_WB_W = move[1] / 2.0 * away;
  r.a_WB_W = move[2] / 4.0 * away;
  const Vec3 up = quintic((t - 6.0) / pitch_time), down = quintic((t - 8.0 - pitch_time) / pitch_time);
  const double quarter = 0.5 * kPi;
  r.q_WB = exp_rotation(Vec3(0, quarter * (up[0] - down[0]), 0));
  r.w_WB_B.y() = quarter * (up[1] - down[1]) / pitch_time;
  r.dw_WB_B.y() = quarter * (up[2] - down[2]) / (pitch_time * pitch_time);
  return r;
}

Reference roll_reference(double t, double roll_time) {
  Reference r;
  r.p_WB = Vec3(0, 0, 1);
  const Vec3 turn = quintic((t - 2.0) / roll_time);
  r.q_WB = exp_rotation(Vec3(2 * kPi * turn[0], 0, 0));
  r.w_WB_B.x() = 2 * kPi * turn[1] / roll_time;
  r.dw_WB_B.x() = 2 * kPi * turn[2] / (roll_time * roll_time);
  return r;
}

LoopResult fly(const vehicle::Vehicle& v, const AllocatorConfig& wanted, const Motion& motion,
               double duration, const std::function<double(double alpha)>& thrust_scale, const LoopGains& k,
               const std::function<double(double t)>& tilt) {
  AllocatorConfig config = wanted;
  if (tilt) config.tilt_mode = TiltMode::fixed, config.initial_tilt = tilt(0);
  auto allocator = Allocator::create(v, config);
  LoopResult out;
  if (!allocator) return out.failed = true, out;
  RigidState x;
  x.p_WB = Vec3(0, 0, 1);
  const int steps = static_cast<int>(duration / kPeriod);
  for (int i = 0; i < steps; ++i) {
    out.end = i * kPeriod;
    const Reference ref = motion(out.end);
    const Quat q_BR = x.q_WB.conjugate() * ref.q_WB;
    const Mat3 R_BR = q_BR.toRotationMatrix();
    const Vec3 e_p = ref.p_WB - x.p_WB, e_R = vee(R_BR - R_BR.transpose()) * 0.5;
    AllocationInput in;
    in.q_WB = x.q_WB;
    in.w_WB_B = x.w_WB_B;
    in.position_error = e_p.norm();
    in.qdd_ref << ref.a_WB_W + k.kp1 * (ref.v_WB_W - x.v_WB_W) + k.kp2 * e_p,
        R_BR * ref.dw_WB_B + k.kr1 * (R_BR * ref.w_WB_B - x.w_WB_B) + k.kr2 * e_R;
    const double angle = log_rotation(q_BR).norm();
    out.last_error = e_p.norm();
    out.worst_error = std::max(out.worst_error, e_p.norm());
    out.mean_error += e_p.norm() / steps;
    out.worst_angle = std::max(out.worst_angle, angle);
    if (tilt) in.alpha = tilt(out.end);
    const auto command = allocator->allocate(in);
    if (!command || e_p.norm() > kLost) return out.failed = true, out;
    out.samples.push_back({out.end, e_p.norm(), angle, command->alpha, command->w_input});
    out.tilt_low = std::min(out.tilt_low, command->alpha);
    out.tilt_high = std::max(out.tilt_high, command->alpha);
    for (int r = 0; r < v.rotor_count(); ++r) {
      const auto& rotor = v.rotors[static_cast<std::size_t>(r)];
      out.mean_power += rotor.drag_ratio * std::abs(command->u[r] * command->speed[r]) / steps;
    }
    step(x, v.allocation_matrix(command->alpha) * command->u * thrust_scale(command->alpha), v);
  }
  return out;
}

LoopResult fly(const vehicle::Vehicle& v, const AllocatorConfig& config, double pitch_time,
               const std::function<double(double alpha)>& thrust_scale, const LoopGains& gains,
               double until) {
  const auto motion = [&](double t) { return thesis_reference(t, pitch_time); };
  return fly(v, config, motion, std::min(10.0 + 2 * pitch_time, until), thrust_scale, gains);
}

}  // namespace omniflight::allocation
