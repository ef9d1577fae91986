#include "motor_order.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace omniflight::cli {
namespace {

using recording::Recording;
using recording::Signal;

constexpr double kBlock = 0.04;                                     // s; means over it are differentiated
constexpr double kSlowest = 0.05;                                   // s, between samples of the motors
constexpr int kFewest = 100;                                        // blocks
constexpr int kMostSearched = 8;                                    // rotors whose orders are all tried
constexpr double kExplains = 0.5, kExplainsNot = 0.3, kNear = 0.1;  // correlations
constexpr double kAlphaSpread = 0.1;  // rad, of a tilt that is taken as constant

/// Thrust of every motor of the log [N], up to a scale where only duty cycles are known; commands are delayed
/// by the rotors' lag.
struct Thrusts {
  const Signal* from = nullptr;
  Eigen::MatrixXd values;
};

std::optional<Thrusts> thrusts_of(const Recording& r, const vehicle::Vehicle& v) {
  Thrusts out;
  for (const char* name : {"rotor_speed", "rotor_command", "pwm", "motor_power"})
    if (!out.from && r.find(name)) out.from = r.find(name);
  if (!out.from) return std::nullopt;
  const bool speeds = out.from->unit == "rad/s", measured = out.from->name == "rotor_speed";
  out.values = out.from->values;
  for (Eigen::Index k = 0; k < out.values.cols(); ++k) {
    const auto& rotor = v.rotors[static_cast<std::size_t>(std::min<Eigen::Index>(k, v.rotor_count() - 1))];
    double lagged = out.values.rows() > 0 ? out.values(0, k) : 0;
    for (Eigen::Index i = 0; i < out.values.rows(); ++i) {
      const double dt =
          i > 0 ? out.from->t_s[static_cast<std::size_t>(i)] - out.from->t_s[static_cast<std::size_t>(i - 1)]
                : 0;
      const double gain = measured || rotor.time_constant <= 0 ? 1 : 1 - std::exp(-dt / rotor.time_constant);
      lagged += gain * (out.values(i, k) - lagged);
      out.values(i, k) = speeds ? rotor.thrust(lagged) : rotor.max_thrust * lagged * std::abs(lagged);
    }
  }
  return out;
}

/// Means over blocks; NaN where there is no sample.
Eigen::MatrixXd block_means(const std::vector<double>& t, const Eigen::MatrixXd& x, double from,
                            Eigen::Index n) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, x.cols());
  Eigen::VectorXd count = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double block = (t[i] - from) / kBlock;
    if (!(block >= 0 && block < static_cast<double>(n))) continue;
    sum.row(static_cast<Eigen::Index>(block)) += x.row(static_cast<Eigen::Index>(i));
    count(static_cast<Eigen::Index>(block)) += 1;
  }
  for (Eigen::Index k = 0; k < n; ++k) sum.row(k) /= count(k) > 0 ? count(k) : std::nan("");
  return sum;
}

/// Without the mean of the second around: slow differences of thrust hold against the air and do not turn the
/// body.
Eigen::MatrixXd without_trend(const Eigen::MatrixXd& x) {
  constexpr Eigen::Index kHalf = 12;  // blocks
  Eigen::MatrixXd out = x;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const Eigen::Index from = std::max<Eigen::Index>(0, i - kHalf), to = std::min(x.rows() - 1, i + kHalf);
    out.row(i) -= x.middleRows(from, to - from + 1).colwise().mean();
  }
  return out;
}

/// What the motion needs and what the motors give, in flight.
struct Torques {
  Eigen::MatrixXd needed;   // N m, rows of x, y, z
  Eigen::MatrixXd thrusts;  // N, motors in the order of the log
};

Torques torques_of(const Signal& gyro, const Thrusts& motors, const vehicle::Vehicle& v) {
  const double from = std::max(gyro.t_s.front(), motors.from->t_s.front()),
               to = std::min(gyro.t_s.back(), motors.from->t_s.back());
  constexpr double kLongest = 1e6;  // blocks
  const auto n = static_cast<Eigen::Index>(std::clamp((to - from) / kBlock, 0.0, kLongest));
  const Eigen::MatrixXd w = block_means(gyro.t_s, gyro.values, from, n),
                        T = block_means(motors.from->t_s, motors.values, from, n);
  std::vector<double> sums;
  for (Eigen::Index k = 0; k < n; ++k)
    if (T.row(k).allFinite()) sums.push_back(T.row(k).sum());
  std::sort(sums.begin(), sums.end());
  const double flies = sums.empty() ? 0 : 0.4 * sums[sums.size() * 9 / 10];
  std::vector<Eigen::Index> use;
  for (Eigen::Index k = 1; k + 1 < n; ++k)
    if (w.middleRows(k - 1, 3).allFinite() && T.middleRows(k - 1, 3).allFinite() && T.row(k).sum() > flies)
      use.push_back(k);
  Torques out;
  out.needed.resize(static_cast<Eigen::Index>(use.size()), 3);
  out.thrusts.resize(out.needed.rows(), T.cols());
  for (std::size_t i = 0; i < use.size(); ++i) {
    const Eigen::Index k = use[i], row = static_cast<Eigen::Index>(i);
    const Vec3 here = w.row(k), dw = (w.row(k + 1) - w.row(k - 1)).transpose() / (2 * kBlock);
    out.needed.row(row) = (v.inertia * dw + here.cross(Vec3(v.inertia * here))).transpose();
    // a difference over two blocks weighs what is between as a triangle does
    out.thrusts.row(row) = 0.25 * T.row(k - 1) + 0.5 * T.row(k) + 0.25 * T.row(k + 1);
  }
  out.needed = without_trend(out.needed);
  out.thrusts = without_trend(out.thrusts);
  return out;
}

/// Correlation of B P T with the needed torque for any order P, from covariances that are computed once.
class Correlations {
 public:
  Correlations(const Torques& t, Eigen::Matrix<double, 3, Eigen::Dynamic> B) : B_(std::move(B)) {
    const Eigen::MatrixXd dT = t.thrusts.rowwise() - t.thrusts.colwise().mean(),
                          dn = t.needed.rowwise() - t.needed.colwise().mean();
    TT_ = dT.transpose() * dT;
    nT_ = dn.transpose() * dT;
    nn_ = dn.colwise().squaredNorm().transpose();
  }
  Vec3 of(const std::vector<int>& order) const {
    Vec3 out;
    for (int k = 0; k < 3; ++k) {
      double cross = 0, own = 0;
      for (Eigen::Index i = 0; i < B_.cols(); ++i) {
        const int a = order[static_cast<std::size_t>(i)];
        cross += B_(k, i) * nT_(k, a);
        for (Eigen::Index j = 0; j < B_.cols(); ++j)
          own += B_(k, i) * B_(k, j) * TT_(a, order[static_cast<std::size_t>(j)]);
      }
      out(k) = own > 0 && nn_(k) > 0 ? cross / std::sqrt(own * nn_(k)) : 0;
    }
    return out;
  }

 private:
  Eigen::Matrix<double, 3, Eigen::Dynamic> B_;
  Eigen::MatrixXd TT_, nT_;
  Eigen::VectorXd nn_;
};

/// Fills in an order that explains what the given one does not.
void search(const Correlations& correlations, std::size_t rotors, MotorOrder& out) {
  std::vector<int> order(rotors);
  std::iota(order.begin(), order.end(), 0);
  std::vector<int> best;
  double first = -2, second = -2;  // of roll and pitch, the worse one
  do {
    const Vec3 c = correlations.of(order);
    const double score = std::min(c.x(), c.y());
    if (score > first) {
      second = first;
      first = score;
      best = order;
    } else {
      second = std::max(second, score);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  if (first < kExplains || second > first - kNear) return;
  out.better = best;
  out.better_correlation = correlations.of(best);
}

}  // namespace

MotorOrder judge_motor_order(const Recording& r, const vehicle::Vehicle& v) {
  MotorOrder out;
  const auto not_judged = [&](std::string why) {
    out.not_judged = std::move(why);
    return out;
  };
  const Signal* gyro = r.find("gyro") ? r.find("gyro") : r.find("est_angular_velocity");
  const auto motors = thrusts_of(r, v);
  if (!gyro || gyro->width() != 3) return not_judged("no gyro was logged");
  if (!motors) return not_judged("no motor signal was logged");
  if (motors->from->width() != v.rotor_count())
    return not_judged(fmt::format("the log has {} motors, the vehicle file {} rotors", motors->from->width(),
                                  v.rotor_count()));
  if (motors->from->median_period_s() > kSlowest || gyro->median_period_s() > kSlowest)
    return not_judged("gyro or motors were logged slower than 20 Hz");
  double alpha = 0;
  if (v.tilt.kind != vehicle::TiltKind::none) {
    const Signal* tilt = r.find("alpha") ? r.find("alpha") : r.find("alpha_command");
    if (!tilt || tilt->values.maxCoeff() - tilt->values.minCoeff() > kAlphaSpread)
      return not_judged("the rotors tilt in this flight");
    alpha = tilt->values.mean();
  }
  const Torques torques = torques_of(*gyro, *motors, v);
  if (torques.needed.rows() < kFewest) return not_judged("less than 4 s of flight");
  // about the centre of mass
  const auto A = v.allocation_matrix(alpha);
  Eigen::Matrix<double, 3, Eigen::Dynamic> B = A.bottomRows<3>();
  for (Eigen::Index i = 0; i < B.cols(); ++i) B.col(i) -= v.center_of_mass.cross(Vec3(A.block<3, 1>(0, i)));
  const Correlations correlations(torques, B);
  std::vector<int> as_it_is(v.rotors.size());
  std::iota(as_it_is.begin(), as_it_is.end(), 0);
  out.correlation = correlations.of(as_it_is);
  const double worse = std::min(out.correlation.x(), out.correlation.y());
  if (worse < kExplainsNot && v.rotor_count() <= kMostSearched) search(correlations, v.rotors.size(), out);
  const Vec3& chosen = out.better.empty() ? out.correlation : out.better_correlation;
  out.spins_reversed = (!out.better.empty() || worse > kExplains) && chosen.z() < -kExplains;
  return out;
}

std::string to_text(const MotorOrder& o) {
  if (!o.not_judged.empty()) return "their order is not judged: " + o.not_judged;
  const auto shown = [](const Vec3& c) {
    return fmt::format("correlation with the torques of the flight: roll {:.2f}, pitch {:.2f}, yaw {:.2f}",
                       c.x(), c.y(), c.z());
  };
  const std::string reversed =
      o.spins_reversed ? "; about yaw they are the other way round: turn the spins of the vehicle file" : "";
  if (!o.better.empty()) {
    std::string order;
    for (const int motor : o.better) order += " " + std::to_string(motor + 1);
    return fmt::format(
        "another order fits: rotors 1 to {} of the vehicle file are motors{} of the log ({}; as it is: "
        "roll {:.2f}, pitch {:.2f}){}",
        o.better.size(), order, shown(o.better_correlation), o.correlation.x(), o.correlation.y(), reversed);
  }
  if (std::min(o.correlation.x(), o.correlation.y()) > kExplains)
    return "their order fits the vehicle file (" + shown(o.correlation) + ")" + reversed;
  return "their order cannot be told, no order explains the rotation well (" + shown(o.correlation) + ")";
}

}  // namespace omniflight::cli
