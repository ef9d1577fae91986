#include "ground.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "../numerics/statistics.hpp"

namespace omniflight::diagnosis {
namespace {

/// Magnitude [N] of the vector sum of the rotor thrusts (push_at() is the sum of magnitudes).
double lift_at(const Eigen::MatrixXd& speed, const Eigen::MatrixXd& alpha, Eigen::Index i,
               const vehicle::Vehicle& v) {
  Vec3 force = Vec3::Zero();
  for (Eigen::Index r = 0; r < speed.cols(); ++r)
    force += v.rotors[static_cast<std::size_t>(r)].thrust(speed(i, r)) *
             v.rotor_axis(static_cast<int>(r), alpha(i, 0));
  return force.norm();
}

}  // namespace

double push_at(const Eigen::MatrixXd& speed, Eigen::Index i, const vehicle::Vehicle& v) {
  double sum = 0;
  for (Eigen::Index r = 0; r < speed.cols(); ++r)
    sum += std::abs(v.rotors[static_cast<std::size_t>(r)].thrust(speed(i, r)));
  return sum;
}

double mean_radius(const vehicle::Vehicle& v) {
  double radius = 0;
  for (const auto& r : v.rotors) radius += r.radius / v.rotor_count();
  return radius;
}

Ground find_ground(const Eigen::MatrixXd& p, bool has_position, const Eigen::MatrixXd& speed,
                   const Eigen::MatrixXd& force, const Eigen::MatrixXd& q, double rate_hz,
                   const vehicle::Vehicle& v, const Options& o) {
  const Eigen::Index n = speed.rows();
  Ground g;
  g.resting.assign(static_cast<std::size_t>(n), 0);
  g.crashed = g.resting;
  const double weight = v.mass * o.environment.gravity;
  std::vector<double> lift(static_cast<std::size_t>(n));
  for (Eigen::Index i = 0; i < n; ++i) lift[static_cast<std::size_t>(i)] = push_at(speed, i, v) / weight;
  const auto second = static_cast<Eigen::Index>(rate_hz), moment = std::max<Eigen::Index>(2, 3 * second / 10);
  if (has_position && n > 2 * second) {
    double sum = 0;
    int windows = 0;
    for (Eigen::Index i = 0; i + moment <= n; i += std::max<Eigen::Index>(1, second / 20)) {
      const auto part = p.middleRows(i, moment);
      const double range = (part.colwise().maxCoeff() - part.colwise().minCoeff()).maxCoeff();
      const double top = *std::max_element(lift.begin() + i, lift.begin() + i + moment);
      if (range > 0.004 || top > 0.85) continue;
      std::fill(g.resting.begin() + i, g.resting.begin() + i + moment, 1);
      sum += part.col(2).mean();
      ++windows;
    }
    // within 2 cm of the lowest height and below 30 % of the weight it stands, however briefly
    const double lowest = p.col(2).minCoeff();
    for (Eigen::Index i = 0; i < n; ++i) {
      if (lift[static_cast<std::size_t>(i)] > 0.3 || p(i, 2) > lowest + 0.02) continue;
      g.resting[static_cast<std::size_t>(i)] = 1;
      sum += p(i, 2);
      ++windows;
    }
    if (windows > 0) {
      const double height = sum / windows;
      g.known = true;
      g.height = height;
      // extend to rolling, bouncing and lift-off: until 1 cm above the resting height
      for (int pass = 0; pass < 2; ++pass)
        for (Eigen::Index k = 1; k < n; ++k) {
          const Eigen::Index i = pass == 0 ? k : n - 1 - k, before = pass == 0 ? i - 1 : i + 1;
          if (g.resting[static_cast<std::size_t>(before)] && p(i, 2) < height + 0.01 &&
              lift[static_cast<std::size_t>(i)] < 0.9)
            g.resting[static_cast<std::size_t>(i)] = 1;
        }
    }
  }
  const bool turns_over =  // can fly inverted
      v.tilt.kind != vehicle::TiltKind::none ||
      std::any_of(v.rotors.begin(), v.rotors.end(), [](const auto& r) { return r.bidirectional; });
  const auto upright = [&](Eigen::Index i) {
    return 1 - 2 * (q(i, 1) * q(i, 1) + q(i, 2) * q(i, 2)) / q.row(i).squaredNorm();
  };
  const auto carries = [&](Eigen::Index from, Eigen::Index to) {
    double sum = 0;
    for (Eigen::Index k = from; k < to; ++k) sum += lift[static_cast<std::size_t>(k)];
    return sum / static_cast<double>(to - from) > 0.4;
  };
  // upright again and carried for 1 s within 3 s: a flip, not a crash
  const auto lands_on_its_feet = [&](Eigen::Index i) {
    Eigen::Index since = 0;
    for (Eigen::Index k = i; k < std::min(n, i + 3 * second); ++k) {
      since = upright(k) > 0.7 ? since + 1 : 0;
      if (since >= second) return carries(k + 1 - second, k + 1);
    }
    return false;
  };
  for (Eigen::Index i = 0; i + second < n; ++i) {
    const bool over = !turns_over && upright(i) < -0.17 && !g.resting[static_cast<std::size_t>(i)];
    if (!(force.row(i).norm() > 5 * o.environment.gravity) && !over) continue;
    if (over ? lands_on_its_feet(i) : carries(i + second / 2, i + second)) continue;
    std::fill(g.crashed.begin() + i, g.crashed.end(), 1);
    break;
  }
  return g;
}

double lift_scale(const Eigen::MatrixXd& speed, const Eigen::MatrixXd& alpha, const Eigen::MatrixXd& force,
                  const Eigen::MatrixXd& p, bool has_position, const vehicle::Vehicle& v) {
  const Eigen::Index n = speed.rows();
  double top = 0, floor = -1e18;
  for (Eigen::Index i = 0; i < n; ++i) top = std::max(top, lift_at(speed, alpha, i, v));
  if (has_position && n > 0) {
    const double low = p.col(2).minCoeff(), high = p.col(2).maxCoeff();
    if (high - low > 0.2) floor = low + std::max(0.1 * (high - low), 0.1);
  }
  std::vector<double> ratio;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double lift = lift_at(speed, alpha, i, v);
    if (lift > 0.4 * top && p(i, 2) > floor) ratio.push_back(v.mass * force.row(i).norm() / lift);
  }
  if (ratio.empty()) return 1;
  return median(std::move(ratio));
}

}  // namespace omniflight::diagnosis
