#include "kinematics.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "../conditioning/attitude_rows.hpp"
#include "../numerics/statistics.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

// Chosen, not measured.
// s, half width of a window; longer suppresses noise, shorter gives more windows
constexpr double kHalf = 0.3;
// nat, least gain; half a chi-square of 3 degrees exceeds it with probability 4e-6
constexpr double kEntry = 14;
constexpr double kCorrelated = 1.5;  // variance inflation, since adjacent windows overlap by half
constexpr double kWild = 0.08;  // m/s^2, RMS misfit above which timing or axes are wrong: nothing is judged
constexpr double kLeastLever = 0.004;  // m, about 3.5 prior deviations of the lever arm
constexpr int kColumns = 10;  // bias (3), tilt (2), lever arm (3), clock of the pose, of the attitude

/// Window phi of unit area on [-kHalf, kHalf] and its second time derivative, at u = t / kHalf.
double window(double u) { return 315.0 / 256.0 * std::pow(1 - u * u, 4) / kHalf; }
double curvature(double u) {
  const double v = 1 - u * u;
  return 315.0 / 256.0 * (-8 * std::pow(v, 3) + 48 * u * u * v * v) / (kHalf * kHalf * kHalf);
}

/// Samples of a signal inside a window; weights [s] of the trapezoidal rule.
struct Samples {
  Eigen::Index begin = 0, end = 0;
  std::vector<double> u, weight;

  /// Selects the samples around `center`; false with fewer than 15 or a gap longer than `gap` (all s).
  bool take(const std::vector<double>& t, double shift, double center, double gap) {
    const auto first = std::lower_bound(t.begin(), t.end(), center - kHalf - shift);
    const auto last = std::upper_bound(t.begin(), t.end(), center + kHalf - shift);
    begin = first - t.begin();
    end = last - t.begin();
    const auto n = static_cast<std::size_t>(std::max<Eigen::Index>(0, end - begin));
    if (n < 15 || begin == 0 || last == t.end()) return false;
    u.resize(n);
    weight.assign(n, 0);
    for (std::size_t k = 0; k < n; ++k) {
      u[k] = (*(first + static_cast<std::ptrdiff_t>(k)) + shift - center) / kHalf;
      if (k == 0) continue;
      const double step = (u[k] - u[k - 1]) * kHalf;
      if (step > gap) return false;
      weight[k - 1] += step / 2;
      weight[k] += step / 2;
    }
    return true;
  }
};

/// Weighted mean of x: integral of phi x.
Eigen::RowVectorXd mean_under(const Samples& s, const Eigen::MatrixXd& x) {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(x.cols());
  double all = 0;
  for (std::size_t k = 0; k < s.u.size(); ++k) {
    const double w = s.weight[k] * window(s.u[k]);
    sum += w * x.row(s.begin + static_cast<Eigen::Index>(k));
    all += w;
  }
  return sum / all;
}

/// Integral of phi'' x, the weighted mean of the second derivative of x. A fitted parabola is integrated
/// exactly, so that quadrature errors affect the remainder only.
Eigen::RowVectorXd curvature_under(const Samples& s, const Eigen::MatrixXd& x) {
  const auto n = static_cast<Eigen::Index>(s.u.size());
  Eigen::MatrixXd A(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double u = s.u[static_cast<std::size_t>(k)];
    A.row(k) << 1, u, u * u;
  }
  const Eigen::MatrixXd y = x.middleRows(s.begin, n);
  const Eigen::MatrixXd b = (A.transpose() * A).ldlt().solve(A.transpose() * y);
  const Eigen::MatrixXd rest = y - A * b;
  Eigen::RowVectorXd out = 2 * b.row(2) / (kHalf * kHalf);
  for (Eigen::Index k = 0; k < n; ++k)
    out += s.weight[static_cast<std::size_t>(k)] * curvature(s.u[static_cast<std::size_t>(k)]) * rest.row(k);
  return out;
}

/// Rotation matrices of quaternion rows (w, x, y, z); n x 9, column-major.
Eigen::MatrixXd rotations(const Eigen::MatrixXd& q) {
  Eigen::MatrixXd out(q.rows(), 9);
  for (Eigen::Index i = 0; i < q.rows(); ++i) {
    const Mat3 R = quaternion(q, i).toRotationMatrix();
    out.row(i) = Eigen::Map<const Eigen::Matrix<double, 1, 9>>(R.data());
  }
  return out;
}

/// Pose and accelerometer of one recording, each on its clock.
struct Motion {
  const Signal &position, &attitude, &force;
  Eigen::MatrixXd R_mocap;  ///< at the times of the position
  double gravity = 9.81;
  /// s, longest gap that is interpolated
  double position_gap = std::min(5 * position.median_period_s(), 0.05);
  double force_gap = std::min(8 * force.median_period_s(), 0.05);

  /// Weighted mean of (d2p/dt2 - R f - g) [m/s^2, world] at `center`, with the pose delayed by `shift` and
  /// the attitude by `attitude_shift` more (all s). Also, unless null, weighted means of R and of its second
  /// derivative.
  std::optional<Vec3> mismatch(double center, double shift, double attitude_shift, Mat3* mean_R,
                               Mat3* bent_R) const {
    Samples p, f;
    if (!p.take(position.t_s, shift, center, position_gap) || !f.take(force.t_s, 0, center, force_gap))
      return std::nullopt;
    const Eigen::Index n = f.end - f.begin;
    std::vector<double> t(static_cast<std::size_t>(n));
    for (Eigen::Index k = 0; k < n; ++k)
      t[static_cast<std::size_t>(k)] =
          force.t_s[static_cast<std::size_t>(f.begin + k)] - shift - attitude_shift;
    const Eigen::MatrixXd q = recording::resample(attitude, t, 0.06);
    if (!q.allFinite() || !position.values.middleRows(p.begin, p.end - p.begin).allFinite() ||
        !R_mocap.middleRows(p.begin, p.end - p.begin).allFinite() ||
        !force.values.middleRows(f.begin, n).allFinite())
      return std::nullopt;
    const Eigen::MatrixXd R = rotations(q);
    Eigen::MatrixXd turned(n, 3);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Eigen::Matrix<double, 1, 9> row = R.row(k);
      const Vec3 f_B = force.values.row(f.begin + k).transpose();
      turned.row(k) = (Eigen::Map<const Mat3>(row.data()) * f_B).transpose();
    }
    Samples local = f;
    local.begin = 0;
    if (mean_R) {
      const Eigen::Matrix<double, 1, 9> mean = mean_under(local, R), bent = curvature_under(p, R_mocap);
      *mean_R = Eigen::Map<const Mat3>(mean.data());
      *bent_R = Eigen::Map<const Mat3>(bent.data());
    }
    return Vec3(curvature_under(p, position.values).transpose() - mean_under(local, turned).transpose() +
                gravity * Vec3::UnitZ());
  }
};

struct Group {
  const char* effect;
  int first, width;
};
constexpr std::array<Group, 3> kGroups{{{physics::effect_id::accelerometer_error, 0, 3},
                                        {physics::effect_id::mocap_tilt, 3, 2},
                                        {physics::effect_id::imu_lever_arm, 5, 3}}};

struct Solution {
  Eigen::VectorXd x, se;
  double log_likelihood = 0;  ///< with the prior
};

/// Regularised least squares of whitened rows; `prior` is the prior precision of each parameter (mean zero).
Solution solve(const Eigen::MatrixXd& X, const Eigen::VectorXd& y, const Eigen::VectorXd& prior) {
  Eigen::MatrixXd H = X.transpose() * X / kCorrelated;
  H.diagonal() += prior;
  const Eigen::VectorXd scale = H.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd h = scale.asDiagonal() * H * scale.asDiagonal();
  h.diagonal().array() += 1e-10;
  const Eigen::MatrixXd inverse =
      scale.asDiagonal() * h.ldlt().solve(Eigen::MatrixXd::Identity(h.rows(), h.rows())) * scale.asDiagonal();
  Solution out;
  out.x = inverse * (X.transpose() * y) / kCorrelated;
  out.se = inverse.diagonal().cwiseMax(0).cwiseSqrt();
  out.log_likelihood = -0.5 * ((y - X * out.x).squaredNorm() / kCorrelated + prior.dot(out.x.cwiseAbs2()));
  return out;
}

/// Prior standard deviation of component k of a group that is not a finding.
double tolerated(const Group& g, int k, const Options& o) {
  if (g.first == 3) return o.tolerance.world_force;
  if (g.first == 5) return kLeastLever / 3.5;
  const double turned = o.tolerance.accelerometer_scale + o.tolerance.accelerometer_misalignment;
  return std::hypot(k < 2 ? o.tolerance.accelerometer_lateral : o.tolerance.accelerometer_vertical,
                    turned * o.environment.gravity);
}

bool among(const std::vector<Group>& groups, const Group& g) {
  return std::any_of(groups.begin(), groups.end(), [&](const Group& c) { return c.first == g.first; });
}

/// Prior precisions: none for found groups, tolerances for the others, and fixed at zero for `without`.
Eigen::VectorXd prior_of(const std::vector<Group>& found, const Options& o, const Group* without = nullptr) {
  constexpr double kNothing = 1e18;
  Eigen::VectorXd prior = Eigen::VectorXd::Zero(kColumns);
  for (const Group& g : kGroups) {
    const bool left_out = without && without->first == g.first;
    for (int k = 0; k < g.width && (left_out || !among(found, g)); ++k)
      prior[g.first + k] = left_out ? kNothing : 1 / std::pow(std::max(tolerated(g, k, o), 1e-9), 2);
  }
  return prior;
}

}  // namespace

const Kinematics::Part* Kinematics::find(const std::string& effect) const {
  for (const Part& p : parts)
    if (p.effect == effect) return &p;
  return nullptr;
}

std::optional<Kinematics> judge_kinematics(const Recording& r, const Options& o) {
  const Signal *position = r.find("position"), *attitude = r.find("attitude"), *force = r.find("acc");
  if (!position || !attitude || !force) return std::nullopt;
  if (position->width() != 3 || attitude->width() != 4 || force->width() != 3) return std::nullopt;
  if (position->size() < 100 || attitude->size() < 100 || force->size() < 100) return std::nullopt;
  Motion motion{*position, *attitude, *force, {}, o.environment.gravity};
  const Eigen::MatrixXd q = recording::resample(*attitude, position->t_s, 0.06);
  motion.R_mocap = Eigen::MatrixXd::Constant(q.rows(), 9, std::nan(""));
  for (Eigen::Index i = 0; i < q.rows(); ++i)
    if (q.row(i).allFinite()) motion.R_mocap.row(i) = rotations(q.row(i));
  std::vector<Eigen::Matrix<double, 3, kColumns>> rows;
  std::vector<Vec3> left;
  constexpr double kShift = 0.004;  // s, step of the numerical derivative
  for (double t = force->t_s.front() + kHalf; t < force->t_s.back() - kHalf; t += kHalf) {
    Mat3 mean_R, bent_R;
    const auto e = motion.mismatch(t, 0, 0, &mean_R, &bent_R);
    if (!e) continue;
    const auto late = motion.mismatch(t, kShift, 0, nullptr, nullptr);
    const auto early = motion.mismatch(t, -kShift, 0, nullptr, nullptr);
    const auto turned_late = motion.mismatch(t, 0, kShift, nullptr, nullptr);
    const auto turned_early = motion.mismatch(t, 0, -kShift, nullptr, nullptr);
    if (!late || !early || !turned_late || !turned_early) continue;
    Eigen::Matrix<double, 3, kColumns> row = Eigen::Matrix<double, 3, kColumns>::Zero();
    row.leftCols<3>() = -mean_R;
    row(1, 3) = o.environment.gravity;
    row(0, 4) = -o.environment.gravity;
    row.middleCols<3>(5) = -bent_R;
    row.col(8) = (*late - *early) / (2 * kShift);
    row.col(9) = (*turned_late - *turned_early) / (2 * kShift);
    rows.push_back(row);
    left.push_back(*e);
  }
  const auto n = static_cast<Eigen::Index>(rows.size());
  if (n < 20) return std::nullopt;
  Eigen::MatrixXd X(3 * n, kColumns);
  Eigen::VectorXd y(3 * n);
  for (Eigen::Index k = 0; k < n; ++k)
    for (int c = 0; c < 3; ++c) {
      X.row(c * n + k) = rows[static_cast<std::size_t>(k)].row(c);
      y[c * n + k] = left[static_cast<std::size_t>(k)][c];
    }
  // whiten each axis by the residual of the full model
  const Eigen::VectorXd all = prior_of({kGroups.begin(), kGroups.end()}, o);
  for (int round = 0; round < 2; ++round) {
    const Solution full = solve(X, y, all);
    const Eigen::VectorXd rest = y - X * full.x;
    for (int c = 0; c < 3; ++c) {
      const double size = std::sqrt(rest.segment(c * n, n).squaredNorm() / static_cast<double>(n - 3));
      if (round == 0 && !(size < kWild)) return std::nullopt;
      X.middleRows(c * n, n) /= std::max(size, 1e-9);
      y.segment(c * n, n) /= std::max(size, 1e-9);
    }
  }
  Kinematics out;
  out.windows = static_cast<int>(n);
  std::vector<Group> chosen;
  double reached = solve(X, y, prior_of(chosen, o)).log_likelihood;
  const auto with = [&](std::vector<Group> groups, const Group& g) {
    groups.push_back(g);
    return solve(X, y, prior_of(groups, o)).log_likelihood;
  };
  while (chosen.size() < kGroups.size()) {
    const Group* best = nullptr;
    double most = 0;
    for (const Group& g : kGroups) {
      if (among(chosen, g)) continue;
      const double reaches = with(chosen, g);
      const double beyond = reaches - reached;  // gain over the tolerances
      const double seen = reaches - solve(X, y, prior_of(chosen, o, &g)).log_likelihood;
      if (seen > kEntry && beyond > 0.5 * chi_squared_quantile(kBeyondTold, g.width) && beyond > most)
        most = beyond, best = &g;
    }
    if (!best) break;
    chosen.push_back(*best);
    reached += most;
  }
  const Solution found = solve(X, y, prior_of(chosen, o));
  for (std::size_t j = 0; j < chosen.size(); ++j) {
    const Group& g = chosen[j];
    const Eigen::VectorXd value = found.x.segment(g.first, g.width), se = found.se.segment(g.first, g.width);
    if (!(value.array().abs() > 4 * se.array()).any()) continue;
    Kinematics::Part part{g.effect, value, se, {}};
    for (const Group& other : kGroups) {
      if (among(chosen, other)) continue;
      std::vector<Group> instead = chosen;
      instead[j] = other;
      if (solve(X, y, prior_of(instead, o)).log_likelihood > reached - 3)
        part.as_well.push_back(other.effect);
    }
    out.parts.push_back(std::move(part));
  }
  return out;
}

}  // namespace omniflight::diagnosis
