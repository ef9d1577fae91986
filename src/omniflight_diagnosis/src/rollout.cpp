#include "rollout.hpp"

#include <array>
#include <cmath>

namespace omniflight::diagnosis {
namespace {

using physics::Situation;

/// Body accelerations of the model at a state; rotors, tilt and vehicle are those of the situation.
Vec6 acceleration(Situation& s, const RigidState& body, const Vec3& c,
                  const std::vector<physics::ActiveEffect>& effects) {
  s.body = body;
  s.R_WB = body.q_WB.toRotationMatrix();
  s.v_WB_B = s.R_WB.transpose() * body.v_WB_W;
  s.g_B = -s.environment.gravity * s.R_WB.row(2).transpose();
  physics::Wrench w;
  for (const auto& e : effects)
    if (e.effect->acts_on_wrench()) e.effect->add_wrench(s, e.theta.data(), w);
  const Vec6 rotors = physics::rotor_wrench(s);
  const Mat3 c_x = skew(c);
  const Vec3& omega = body.w_WB_B;
  Mat6 M;
  M << s.mass * Mat3::Identity(), -s.mass * c_x, s.mass * c_x, s.inertia - s.mass * c_x * c_x;
  M += w.moving_inertia(s);
  Vec6 force = rotors;
  force.head<3>() += w.force_B + s.mass * (s.g_B - omega.cross(omega.cross(c)));
  force.tail<3>() +=
      w.torque_B + s.mass * c.cross(s.g_B - omega.cross(omega.cross(c))) - omega.cross(s.inertia * omega);
  return M.partialPivLu().solve(force);
}

struct Sum {
  double position = 0, attitude = 0;
  int count = 0;
};

/// Flies from grid index `from` for `steps` grid samples and adds the squared error at the end of each
/// horizon.
void fly(const Flight& f, int from, const std::array<int, 3>& steps, const Vec3& c,
         const std::vector<physics::ActiveEffect>& effects, std::array<Sum, 3>& sums, int last) {
  RigidState x = f.situation[static_cast<std::size_t>(from)].body;
  Situation work;
  std::size_t horizon = 0;
  constexpr int kSub = 4;
  const double dt = 1.0 / (f.rate_hz * kSub);
  for (int k = 0; horizon < 3; ++k) {
    if (k == steps[horizon]) {
      const RigidState& truth = f.situation[static_cast<std::size_t>(from + k)].body;
      sums[horizon].position += (x.p_WB - truth.p_WB).squaredNorm();
      sums[horizon].attitude += std::pow(to_degrees(x.q_WB.angularDistance(truth.q_WB)), 2);
      ++sums[horizon].count;
      if (++horizon == 3) break;
    }
    if (from + k + 1 >= last) break;
    for (int sub = 0; sub < kSub; ++sub) {
      work = f.situation[static_cast<std::size_t>(from + k)];
      const Situation& next = f.situation[static_cast<std::size_t>(from + k + 1)];
      const double share = (sub + 0.5) / kSub;
      for (std::size_t r = 0; r < static_cast<std::size_t>(work.rotor_count); ++r) {
        work.rotors[r].thrust += share * (next.rotors[r].thrust - work.rotors[r].thrust);
        work.rotors[r].speed += share * (next.rotors[r].speed - work.rotors[r].speed);
      }
      RigidState half = x;
      for (int stage = 0; stage < 2; ++stage) {  // midpoint rule
        const Vec6 nu = acceleration(work, half, c, effects);
        const double h = stage == 0 ? 0.5 * dt : dt;
        const Vec3 v = half.v_WB_W, omega = half.w_WB_B;
        const Mat3 R = half.q_WB.toRotationMatrix();
        half.p_WB = x.p_WB + h * v;
        half.v_WB_W = x.v_WB_W + h * (R * nu.head<3>());
        half.w_WB_B = x.w_WB_B + h * nu.tail<3>();
        half.q_WB = (x.q_WB * exp_rotation(h * omega)).normalized();
      }
      x = half;
      if (!is_finite(x)) return;
    }
  }
}

}  // namespace

std::vector<RolloutFit> rollouts(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                                 const std::vector<physics::ActiveEffect>& effects, const Options&) {
  constexpr std::array<double, 3> kHorizon{0.1, 0.5, 2.0};
  std::array<Sum, 3> before, after;
  for (const Flight* f : flights) {
    if (!f->has_position) return {};
    std::array<int, 3> steps{};
    for (std::size_t h = 0; h < 3; ++h) steps[h] = static_cast<int>(std::lround(kHorizon[h] * f->rate_hz));
    const int stride = std::max(static_cast<int>(0.5 * f->rate_hz), f->usable() / 200);
    for (const Segment& s : f->segments)
      for (int i = s.begin; i < s.end; i += stride) {
        fly(*f, i, steps, vehicle.center_of_mass, {}, before, s.end);
        fly(*f, i, steps, vehicle.center_of_mass, effects, after, s.end);
      }
  }
  std::vector<RolloutFit> out;
  for (std::size_t h = 0; h < 3; ++h) {
    if (before[h].count == 0 || after[h].count == 0) continue;
    const double b = before[h].count, a = after[h].count;
    out.push_back(
        {kHorizon[h], "position", "m", std::sqrt(before[h].position / b), std::sqrt(after[h].position / a)});
    out.push_back({kHorizon[h], "attitude", "deg", std::sqrt(before[h].attitude / b),
                   std::sqrt(after[h].attitude / a)});
  }
  return out;
}

}  // namespace omniflight::diagnosis
