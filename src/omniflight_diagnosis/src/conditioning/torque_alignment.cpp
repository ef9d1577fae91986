#include "torque_alignment.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_diagnosis/filter.hpp"

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured.
constexpr double kLeastExplained = 0.85;  // least coefficient of determination, see lag_behind_rotors()

struct AxisFit {
  double left = 1;   ///< unexplained share of the variance
  double scale = 0;  ///< coefficient of the torque, 1/(kg m^2)
};

/// Regression of y on torque, spin-up torque and a constant, delayed by `shift` samples.
AxisFit regress(const Eigen::VectorXd& y, const Eigen::VectorXd& torque, const Eigen::VectorXd& spin_up,
                const std::vector<int>& rows, int shift) {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Vec3 g = Vec3::Zero();
  double sum = 0, squares = 0;
  for (const int i : rows) {
    const Vec3 x(torque[i - shift], spin_up[i - shift], 1);
    H += x * x.transpose();
    g += y[i] * x;
    sum += y[i];
    squares += y[i] * y[i];
  }
  const double all = squares - sum * sum / static_cast<double>(rows.size());
  const Vec3 scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::Matrix3d h = scale.asDiagonal() * H * scale.asDiagonal();
  h.diagonal().array() += 1e-12;
  const Vec3 scaled = scale.cwiseProduct(g);
  const Vec3 x = h.ldlt().solve(scaled);
  if (!(all > 0)) return {};
  return {std::clamp((squares - scaled.dot(x)) / all, 1e-6, 1.0), x[0] * scale[0]};
}

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

Eigen::MatrixXd quick_part(const Eigen::MatrixXd& x, double rate_hz) {
  constexpr double kSlowHz = 4;  // Hz, cut-off below which aerodynamic wrenches matter; chosen
  return x - low_pass(x, rate_hz, kSlowHz);
}

std::optional<TorqueLag> lag_behind_rotors(const Eigen::MatrixXd& dw, const RotorExcitation& rotors,
                                           double rate_hz, const std::vector<char>& use) {
  const auto n = static_cast<int>(dw.rows());
  const int reach = static_cast<int>(std::ceil(kReach * rate_hz));
  const Eigen::MatrixXd turn = quick_part(dw, rate_hz), cause = quick_part(rotors.torque, rate_hz),
                        start = quick_part(rotors.spin_up, rate_hz);
  std::vector<int> rows;
  for (int i = reach; i < n - reach; ++i)
    if (use[static_cast<std::size_t>(i)]) rows.push_back(i);
  if (static_cast<double>(rows.size()) < 3 * rate_hz) return std::nullopt;

  std::vector<double> misfit;  // negative log-likelihood per sample
  TorqueLag out;
  for (int shift = -reach; shift <= reach; ++shift) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
      const AxisFit axis = regress(turn.col(c), cause.col(c), start.col(c), rows, shift);
      sum += 0.5 * std::log(axis.left);
    }
    misfit.push_back(sum);
  }
  const auto at = std::min_element(misfit.begin(), misfit.end()) - misfit.begin();
  if (at == 0 || at + 1 == static_cast<std::ptrdiff_t>(misfit.size())) return std::nullopt;
  // Under a disturbance that the controller compensates, the lag is that of the controller: the torques must
  // explain the motion, with positive sign.
  for (int c = 0; c < 3; ++c) {
    const AxisFit axis = regress(turn.col(c), cause.col(c), start.col(c), rows, static_cast<int>(at) - reach);
    if (axis.scale > 0) out.explained = std::max(out.explained, 1 - axis.left);
  }
  if (out.explained < kLeastExplained) return std::nullopt;
  const auto k = static_cast<std::size_t>(at);
  const double bend = misfit[k - 1] - 2 * misfit[k] + misfit[k + 1];
  if (!(bend > 0)) return std::nullopt;
  out.lag_s = (static_cast<double>(at) - reach + 0.5 * (misfit[k - 1] - misfit[k + 1]) / bend) / rate_hz;
  const double independent = static_cast<double>(rows.size()) / (kCorrelation * rate_hz);
  out.se_s = 1 / (rate_hz * std::sqrt(bend * independent));
  return out;
}

Eigen::MatrixXd delayed(const Eigen::MatrixXd& x, double lag_s, double rate_hz) {
  Eigen::MatrixXd out(x.rows(), x.cols());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const double at =
        std::clamp(static_cast<double>(i) - lag_s * rate_hz, 0.0, static_cast<double>(x.rows() - 1));
    const auto a = static_cast<Eigen::Index>(at);
    const Eigen::Index b = std::min(a + 1, x.rows() - 1);
    out.row(i) = x.row(a) + (at - static_cast<double>(a)) * (x.row(b) - x.row(a));
  }
  return out;
}

}  // namespace omniflight::diagnosis
