#include "predetermined.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_diagnosis/residual.hpp"

namespace omniflight::diagnosis {
namespace {

/// Time constant [s] over which the wrench residual is averaged before it predicts the next acceleration:
/// some samples, so that sensor noise in it is small, and short against the motion.
constexpr double kResidualMemory = 0.1;

}  // namespace

int prediction_lag(const Flight& flight, double period) {
  return 1 + static_cast<int>(std::ceil(flight.reach_s / period));
}

std::vector<physics::Situation> predetermined(const Flight& f, Segment segment, const Mat6& inertia,
                                              const Vec3& center_of_mass, double period) {
  const int lag = prediction_lag(f, period);
  const double ahead = lag * period;
  const Eigen::PartialPivLU<Mat6> mass(inertia);
  const double keep = std::exp(-period / kResidualMemory);
  Vec6 slow = Vec6::Zero();  // averaged residual up to `lag` samples before
  std::vector<Vec6> rests;
  std::vector<physics::Situation> out;
  out.reserve(static_cast<std::size_t>(segment.end - segment.begin));
  const auto acceleration_of = [](const physics::Situation& x) {
    Vec6 a;
    a << x.a_WB_B, x.dw_WB_B;
    return a;
  };
  for (int i = segment.begin; i < segment.end; ++i) {
    const physics::Situation& now = f.situation[static_cast<std::size_t>(i)];
    physics::Situation s = f.smooth[static_cast<std::size_t>(i)];
    const int j = std::max(segment.begin, i - lag);
    const physics::Situation& last = f.smooth[static_cast<std::size_t>(j)];
    const Vec6 rest = wrench_residual(now, now.a_WB_B - now.g_B, center_of_mass);
    rests.push_back(rest);
    const Vec6& known = rests[static_cast<std::size_t>(j - segment.begin)];
    slow = i == segment.begin ? known : Vec6(keep * slow + (1 - keep) * known);
    for (int k = 0; k < s.rotor_count; ++k) {  // held: their rate of change is mostly noise
      physics::RotorSituation& r = s.rotors[static_cast<std::size_t>(k)];
      const physics::RotorSituation& old = last.rotors[static_cast<std::size_t>(k)];
      r.speed = old.speed;
      r.acceleration = old.acceleration;
      r.thrust = r.thrust_coefficient * r.speed * std::abs(r.speed);
    }
    // acceleration: what the rotors are expected to do, and what was left over so far
    const Vec6 modelled =
        acceleration_of(now) + mass.solve(physics::rotor_wrench(s) - physics::rotor_wrench(now) - rest);
    if (i - lag >= segment.begin) {
      const Vec6 mean = 0.5 * (acceleration_of(f.situation[static_cast<std::size_t>(j)]) + modelled + mass.solve(slow));
      s.body.w_WB_B = last.body.w_WB_B + ahead * mean.tail<3>();
      s.body.v_WB_W = last.body.v_WB_W + ahead * (last.R_WB * mean.head<3>());
      s.body.p_WB = last.body.p_WB + 0.5 * ahead * (last.body.v_WB_W + s.body.v_WB_W);
      s.body.q_WB = last.body.q_WB * exp_rotation(0.5 * ahead * (last.body.w_WB_B + s.body.w_WB_B));
      s.R_WB = s.body.q_WB.toRotationMatrix();
      s.v_WB_B = s.R_WB.transpose() * s.body.v_WB_W;
      s.g_B = s.R_WB.transpose() * Vec3(0, 0, -s.environment.gravity);
    }
    // Effects that add mass see the model's own acceleration. With the averaged residual in it, a mass of any
    // sign would predict the residual from its own past.
    s.a_WB_B = modelled.head<3>();
    s.dw_WB_B = modelled.tail<3>();
    out.push_back(s);
  }
  return out;
}

}  // namespace omniflight::diagnosis
