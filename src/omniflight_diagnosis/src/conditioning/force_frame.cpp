#include "force_frame.hpp"

#include <algorithm>

namespace omniflight::diagnosis {
namespace {

/// Running variance of a 2-vector (mean removed).
struct Spread {
  double count = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero(), squares = Eigen::Vector2d::Zero();

  void add(const Eigen::Vector2d& x) {
    ++count;
    sum += x;
    squares += x.cwiseAbs2();
  }
  double variance() const {
    const Eigen::Vector2d mean = sum / std::max(1.0, count);
    return (squares / std::max(1.0, count) - mean.cwiseAbs2()).sum();
  }
};

}  // namespace

bool force_is_in_world(const Eigen::MatrixXd& force, const Eigen::MatrixXd& acceleration,
                       const Eigen::MatrixXd& q, const std::vector<char>& use, double gravity) {
  Spread in_body, in_world, moves;
  for (Eigen::Index i = 0; i < force.rows(); ++i) {
    if (!use[static_cast<std::size_t>(i)] || !force.row(i).allFinite() || !acceleration.row(i).allFinite() ||
        !q.row(i).allFinite() || !(q.row(i).squaredNorm() > 0.25))
      continue;
    const Eigen::Vector3d f = force.row(i).transpose();
    const Eigen::Vector3d world =
        Eigen::Vector3d(acceleration.row(i).transpose()) + gravity * Eigen::Vector3d::UnitZ();
    const Eigen::Quaterniond turn = Eigen::Quaterniond(q(i, 0), q(i, 1), q(i, 2), q(i, 3)).normalized();
    in_body.add((f - turn.conjugate() * world).head<2>());
    in_world.add((f - world).head<2>());
    moves.add(world.head<2>());
  }
  // Thresholds chosen: (0.05 m/s^2)^2 of horizontal motion, and clear margins between the two hypotheses.
  constexpr double kLeast = 0.05 * 0.05;  // (m/s^2)^2
  return moves.count > 100 && moves.variance() > kLeast && in_world.variance() < 0.5 * moves.variance() &&
         in_world.variance() < 0.25 * in_body.variance();
}

}  // namespace omniflight::diagnosis
