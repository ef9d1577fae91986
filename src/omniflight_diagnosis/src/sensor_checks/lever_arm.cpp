#include "lever_arm.hpp"

#include <algorithm>
#include <cmath>

#include "../regression/predetermined.hpp"
#include "../regression/regression_problem.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::diagnosis {
namespace {

/// Lever-arm acceleration at r [m, body] [m/s^2, body].
Vec3 lever_acceleration(const physics::Situation& s, const Vec3& r) {
  const Vec3& w = s.body.w_WB_B;
  return s.dw_WB_B.cross(r) + w.cross(w.cross(r));
}

struct Share {
  double value = 0, se = 0;
};

/// Window means in body axes: mass times lever-arm acceleration [N], velocity [m/s], force residual [N].
struct Means {
  Vec3 lever = Vec3::Zero(), speed = Vec3::Zero(), left = Vec3::Zero();
};

constexpr double kAveraged = 0.2;  // s, averages the noise of the differentiated rate; chosen

/// Coefficient of the lever-arm force in the force residual: 1 if the accelerometer is off the origin, 0 if
/// the pose is. Regression of differences between adjacent windows, which are nearly white, with velocity for
/// unmodelled drag. Empty with fewer than 30 differences.
std::optional<Share> share_in_forces(const RegressionProblem& problem, double mass, const Vec3& r,
                                     double rate_hz) {
  const int n = problem.samples(), width = std::max(1, static_cast<int>(std::lround(kAveraged * rate_hz)));
  constexpr Eigen::Index kColumns = 4;  // lever arm, and drag per axis
  Eigen::MatrixXd X(3 * (n / width + 1), kColumns);
  Eigen::VectorXd y(X.rows());
  Eigen::Index rows = 0;
  for (const Stretch& run : problem.stretches()) {
    std::optional<Means> last;
    for (int i = run.begin; i + width <= run.end; i += width) {
      Means now;
      for (int k = i; k < i + width; ++k) {
        const physics::Situation& s = problem.measured(k);
        now.lever += mass / width * lever_acceleration(s, r);
        now.speed += s.v_WB_B / width;
        for (int c = 0; c < 3; ++c) now.left[c] += problem.residual()[c * n + k] / width;
      }
      for (int c = 0; last && c < 3; ++c, ++rows) {
        X.row(rows).setZero();
        X(rows, 0) = now.lever[c] - last->lever[c];
        X(rows, 1 + c) = now.speed[c] - last->speed[c];
        y[rows] = now.left[c] - last->left[c];
      }
      last = now;
    }
  }
  if (rows < 90) return std::nullopt;
  const auto A = X.topRows(rows);
  Eigen::MatrixXd H = A.transpose() * A;
  if (!(H(0, 0) > 0)) return std::nullopt;
  H.diagonal() *= 1 + 1e-9;
  H.diagonal().array() += 1e-30;
  const Eigen::MatrixXd inverse = H.ldlt().solve(Eigen::MatrixXd::Identity(kColumns, kColumns));
  const Eigen::VectorXd x = inverse * (A.transpose() * y.head(rows));
  const double variance = (y.head(rows) - A * x).squaredNorm() / static_cast<double>(rows - kColumns);
  return Share{x[0], std::sqrt(std::max(0.0, variance * inverse(0, 0)))};
}

}  // namespace

void attribute_lever(const Flight& flight, const vehicle::Vehicle& vehicle, const Options& o,
                     Kinematics& kinematics) {
  const auto part = std::find_if(kinematics.parts.begin(), kinematics.parts.end(),
                                 [](const auto& p) { return p.effect == physics::effect_id::imu_lever_arm; });
  if (part == kinematics.parts.end() || !flight.has_accelerometer) return;
  const Flight* one[] = {&flight};
  const RegressionProblem problem(one, vehicle, o, Horizon{least_horizon(flight)});
  const auto share = share_in_forces(problem, vehicle.mass, part->value, flight.rate_hz);
  if (!share) return;
  const bool sure = std::abs(share->value - 0.5) > 2 * share->se;
  const bool mocap = share->value < 0.5;
  if (!sure)
    part->as_well.emplace_back(mocap ? physics::effect_id::imu_lever_arm : physics::effect_id::mocap_offset);
  if (!mocap) return;
  part->effect = physics::effect_id::mocap_offset;
  part->value = -part->value;
}

void compensate(const Kinematics& kinematics, Flight& f) {
  const Kinematics::Part *bias = kinematics.find(physics::effect_id::accelerometer_error),
                         *lever = kinematics.find(physics::effect_id::imu_lever_arm);
  if (!f.has_accelerometer || (!bias && !lever)) return;
  for (physics::Situation& s : f.situation) {
    if (bias) s.a_WB_B -= Vec3(bias->value);
    if (lever) s.a_WB_B -= lever_acceleration(s, lever->value);
  }
}

}  // namespace omniflight::diagnosis
