#include "rotor_regression.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "omniflight_diagnosis/filter.hpp"

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured.
constexpr double kReach = 0.024;       // s, half width of the search; gyro filters delay by less
constexpr double kCorrelation = 0.05;  // s, correlation time of the misfit, for standard errors
constexpr double kLeastTime = 3;       // s
constexpr double kSlowHz = 4;          // Hz, below it aerodynamic wrenches matter

Eigen::MatrixXd quick_part(const Eigen::MatrixXd& x, double rate_hz) {
  return x - low_pass(x, rate_hz, kSlowHz);
}

/// Inner products of (wrench, settled wrench, spin-up, 1) with each other and with the motion.
struct Products {
  Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
  Eigen::Vector4d g = Eigen::Vector4d::Zero();
  double sum = 0, squares = 0, count = 0;

  void add(const Eigen::Vector4d& x, double y) {
    H += x * x.transpose();
    g += y * x;
    sum += y;
    squares += y * y;
    ++count;
  }
  double left(double lead) const {
    Eigen::Matrix<double, 4, 3> mix = Eigen::Matrix<double, 4, 3>::Zero();
    mix(0, 0) = 1 + lead;
    mix(1, 0) = -lead;
    mix(2, 1) = mix(3, 2) = 1;
    const Eigen::Matrix3d h = mix.transpose() * H * mix;
    const Vec3 b = mix.transpose() * g;
    const Vec3 scale = h.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    Eigen::Matrix3d scaled = scale.asDiagonal() * h * scale.asDiagonal();
    scaled.diagonal().array() += 1e-12;
    const Vec3 x = scaled.ldlt().solve(scale.cwiseProduct(b));
    const double all = squares - sum * sum / count;
    if (!(all > 0) || !(x[0] > 0)) return 1;
    return std::clamp((squares - scale.cwiseProduct(b).dot(x)) / all, 1e-6, 1.0);
  }
};

}  // namespace

RotorExcitation rotor_excitation(const Eigen::MatrixXd& speed, const Eigen::MatrixXd& turning,
                                 const Eigen::MatrixXd& alpha, double rate_hz,
                                 const vehicle::Vehicle& vehicle) {
  const auto n = static_cast<int>(speed.rows());
  const Eigen::MatrixXd dspeed = differentiate(turning, rate_hz);
  RotorExcitation out{Eigen::MatrixXd(n, 3), Eigen::MatrixXd(n, 3), Eigen::MatrixXd(n, 3)};
  std::vector<double> s(static_cast<std::size_t>(speed.cols())), ds(s.size());
  physics::Situation now;
  for (int i = 0; i < n; ++i) {
    for (std::size_t r = 0; r < s.size(); ++r) {
      s[r] = speed(i, static_cast<Eigen::Index>(r));
      ds[r] = dspeed(i, static_cast<Eigen::Index>(r));
    }
    physics::prepare(vehicle, {}, alpha(i, 0), s, ds, {}, now);
    const Vec6 wrench = physics::rotor_wrench(now);
    out.force.row(i) = wrench.head<3>().transpose();
    out.torque.row(i) = wrench.tail<3>().transpose();
    Vec3 up = Vec3::Zero();
    for (const physics::RotorSituation& r : now.all_rotors()) up += r.spin * r.acceleration * r.n_B;
    out.spin_up.row(i) = up.transpose();
  }
  return out;
}

Eigen::MatrixXd lagged(const Eigen::MatrixXd& x, double time_s, double rate_hz) {
  const double kept = std::exp(-1 / (rate_hz * time_s));
  Eigen::MatrixXd out = x;
  for (Eigen::Index i = 1; i < x.rows(); ++i)
    // exact for an input that is linear between samples, to the order of its curvature
    out.row(i) = kept * out.row(i - 1) + (1 - kept) * 0.5 * (x.row(i) + x.row(i - 1));
  return out;
}

RotorRegression::RotorRegression(const Eigen::MatrixXd& dw, const Eigen::MatrixXd& force,
                                 const RotorExcitation& rotors, double rate_hz, const std::vector<char>& use)
    : rate_hz_(rate_hz), reach_(static_cast<int>(std::ceil(kReach * rate_hz))) {
  const auto n = static_cast<int>(dw.rows());
  for (int i = reach_; i < n - reach_; ++i)
    if (use[static_cast<std::size_t>(i)]) rows_.push_back(i);
  if (!enough()) return;
  const auto add = [&](const Eigen::MatrixXd& y, const Eigen::MatrixXd& x, const Eigen::MatrixXd& up) {
    const Eigen::MatrixXd motion = quick_part(y, rate_hz), wrench = quick_part(x, rate_hz),
                          spin_up = quick_part(up, rate_hz);
    for (Eigen::Index c = 0; c < 3; ++c) axes_.push_back({motion.col(c), wrench.col(c), spin_up.col(c)});
  };
  add(dw, rotors.torque, rotors.spin_up);
  if (force.rows() == dw.rows()) add(force, rotors.force, Eigen::MatrixXd::Zero(n, 3));
  at_once_.resize(axes(), 2 * reach_ + 1);
  for (int c = 0; c < axes(); ++c)
    for (int shift = -reach_; shift <= reach_; ++shift)
      at_once_(c, shift + reach_) = left(c, wrench(c), shift, std::array{0.0}).front();
  best_shift_ = -reach_;
  for (int shift = -reach_; shift <= reach_; ++shift)
    if (misfit(shift) < misfit(best_shift_)) best_shift_ = shift;
}

double RotorRegression::misfit(int shift) const {
  double sum = 0;
  for (int c = 0; c < 3; ++c) sum += 0.5 * std::log(left_at_once(c, shift));
  return sum;
}

bool RotorRegression::enough() const { return static_cast<double>(rows_.size()) >= kLeastTime * rate_hz_; }

double RotorRegression::independent_samples() const {
  return static_cast<double>(rows_.size()) / (kCorrelation * rate_hz_);
}

double RotorRegression::left_at_once(int axis, int shift) const { return at_once_(axis, shift + reach_); }

std::vector<double> RotorRegression::left(int axis, const Eigen::VectorXd& settled, int shift,
                                          std::span<const double> leads) const {
  const Axis& a = axes_[static_cast<std::size_t>(axis)];
  Products p;
  for (const int i : rows_)
    p.add({a.wrench[i - shift], settled[i - shift], a.spin_up[i - shift], 1}, a.motion[i]);
  std::vector<double> out;
  for (const double lead : leads) out.push_back(p.left(lead));
  return out;
}

}  // namespace omniflight::diagnosis
