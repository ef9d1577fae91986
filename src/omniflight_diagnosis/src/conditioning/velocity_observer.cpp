#include "velocity_observer.hpp"

#include "omniflight_core/frames.hpp"

namespace omniflight::diagnosis {
namespace {

/// Poles [rad/s]. Chosen: a millimetre of the pose at 100 Hz is then some millimetres per second, and so is
/// an error of the acceleration that changes by 0.03 m/s^2 in a second.
constexpr double kPole = 4;

}  // namespace

Eigen::MatrixXd observed_velocity(const Eigen::MatrixXd& position, const Eigen::MatrixXd& derivative,
                                  const Eigen::MatrixXd& acceleration, const std::vector<char>& used,
                                  double rate_hz) {
  constexpr double kPosition = 3 * kPole, kVelocity = 3 * kPole * kPole, kError = kPole * kPole * kPole;
  const double dt = 1 / rate_hz;
  Eigen::MatrixXd out = derivative;
  Vec3 p, v, error;
  bool begun = false;
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    if (!used[static_cast<std::size_t>(i)]) {
      begun = false;
      continue;
    }
    const Vec3 seen = position.row(i).transpose();
    if (!begun) {
      begun = true;
      p = seen;
      v = derivative.row(i).transpose();
      error.setZero();
      continue;
    }
    // to this sample by the mean acceleration since the last one, then corrected by its position
    const Vec3 a = 0.5 * (acceleration.row(i - 1) + acceleration.row(i)).transpose() + error;
    p += dt * (v + 0.5 * dt * a);
    v += dt * a;
    const Vec3 missed = seen - p;
    p += dt * kPosition * missed;
    v += dt * kVelocity * missed;
    error += dt * kError * missed;
    out.row(i) = v.transpose();
  }
  return out;
}

}  // namespace omniflight::diagnosis
