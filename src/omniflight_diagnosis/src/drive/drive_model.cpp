#include "drive_model.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "../numerics/statistics.hpp"
#include "omniflight_physics/actuators.hpp"

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured.
constexpr double kLagTold = 0.08;  ///< prior standard deviation of ln(lag / lag of the vehicle file)
constexpr double kFreedom = 4;     ///< degrees of freedom of errors; chosen: kurtosis just infinite
constexpr double kGaussian = 1e9;
constexpr double kLawError = 0.3;   ///< factor on Options::law_error: first-order drives are a good law
constexpr double kSettles = 0.5;    ///< s, left out at the start so that initial conditions decay
constexpr double kResolved = 1e-3;  ///< relative speed error of timing and telemetry under any model
constexpr double kNone = std::numeric_limits<double>::infinity();

/// First-order high pass. Slow changes of a motor on a duty cycle (heating, sagging supply) would otherwise
/// be fitted by a longer lag.
class QuickPart {
 public:
  double of(double t, double x) {
    value_ = before_ ? std::exp((t_ - t) / kSlow) * (value_ + x - *before_) : 0;
    t_ = t;
    before_ = x;
    return value_;
  }

 private:
  static constexpr double kSlow = 0.1;  ///< s, time constant; chosen
  std::optional<double> before_;
  double t_ = 0, value_ = 0;
};

/// Regression of speeds on three columns, with errors that follow Student's t distribution: expectation and
/// maximisation over weights, coefficients and scale (Lange, Little and Taylor 1989).
class Regression {
 public:
  /// `freedom`: degrees of freedom of the errors.
  void begin(Eigen::Index most, double freedom) {
    freedom_ = freedom;
    if (x_.rows() < most) {
      x_.resize(most, 3);
      weighted_.resize(most, 3);
      y_.resize(most);
      r_.resize(most);
      w_.resize(most);
    }
    n_ = 0;
  }
  void add(const Eigen::Vector3d& x, double y) {
    x_.row(n_) = x;
    y_[n_++] = y;
  }
  Eigen::Index size() const { return n_; }
  void solve() {
    w_.head(n_).setOnes();
    for (int k = 0; k <= kTurns; ++k) {
      const auto x = x_.topRows(n_);
      auto weighted = weighted_.topRows(n_);
      weighted = w_.head(n_).matrix().asDiagonal() * x;
      Eigen::Matrix3d H = x.transpose() * weighted;
      H.diagonal().array() += 1e-9 * H.trace() + 1e-12;
      const Eigen::Vector3d best = H.ldlt().solve(weighted.transpose() * y_.head(n_).matrix());
      r_.head(n_) = y_.head(n_) - (x * best).array();
      scale2_ = std::max(1e-300, k == 0 ? middle_square() : (w_.head(n_) * residual().square()).mean());
      w_.head(n_) = (freedom_ + 1) / (freedom_ + residual().square() / scale2_);
    }
  }
  Eigen::Ref<const Eigen::ArrayXd> residual() const { return r_.head(n_); }
  Eigen::Ref<const Eigen::ArrayXd> weight() const { return w_.head(n_); }
  double scale2() const { return scale2_; }
  /// Mean ln density of the residuals, up to a constant, where the squared scale is `scale2`.
  double mean_log_density(double scale2) const {
    return -0.5 * std::log(scale2) -
           0.5 * (freedom_ + 1) * (residual().square() / (freedom_ * scale2)).log1p().mean();
  }

 private:
  static constexpr int kTurns = 6;  ///< after least squares; chosen for run time
  /// A start that outliers do not move: squared median of the magnitudes.
  double middle_square() const {
    std::vector<double> sizes(r_.data(), r_.data() + n_);
    for (double& x : sizes) x = std::abs(x);
    const double middle = median(std::move(sizes));
    return middle * middle;
  }

  Eigen::Index n_ = 0;
  double scale2_ = 0, freedom_ = 0;
  Eigen::Matrix<double, Eigen::Dynamic, 3> x_, weighted_;
  Eigen::ArrayXd y_, r_, w_;
};

}  // namespace

struct DriveModel::Rest {
  double mean_square = 0;  ///< (rad/s)^2, of the residual
  double log_density = 0;  ///< mean of a sample, up to a constant
  double moved = 0;        ///< (rad/s)^2, mean square of simulated speed minus command
  double speed = 0;        ///< rad/s, mean magnitude
  double samples = 0;
  Eigen::VectorXd left;  ///< rad/s, residuals times their weights, if requested
};

Eigen::Index DriveSet::first(std::size_t member) const {
  Eigen::Index at = 2;
  for (std::size_t k = 0; k < member; ++k)
    at += static_cast<Eigen::Index>(members[k]->info().parameters.size());
  return at;
}

std::vector<double> DriveSet::theta(std::size_t member, const physics::VehicleSize& size) const {
  std::vector<double> out;
  const Eigen::Index at = first(member);
  for (std::size_t k = 0; k < members[member]->info().parameters.size(); ++k) {
    const physics::ParameterPrior prior = physics::prior_of(*members[member], k, size);
    const double u = coordinates[at + static_cast<Eigen::Index>(k)];
    out.push_back(prior.value(prior.law == physics::ParameterPrior::Law::half_normal ? std::abs(u) : u));
  }
  return out;
}

DriveModel::DriveModel(const vehicle::Vehicle& vehicle, std::vector<DriveRecord> records, Between between,
                       double stamps_s, const Options& o)
    : vehicle_(vehicle),
      size_(physics::size_of(vehicle, o.environment.gravity)),
      records_(std::move(records)),
      between_(between),
      stamps_s_(stamps_s),
      law_error_(kLawError * o.error_of_laws()),
      freedom_(o.assumes(Assumption::heavy_tails) ? kFreedom : kGaussian),
      temperature_(o.temperature) {
  for (const DriveRecord& r : records_)
    for (Eigen::Index k = 0; k < r.speed.cols(); ++k) independent_.push_back(static_cast<double>(r.t.size()));
}

DriveModel DriveModel::part(double seconds) const {
  DriveModel out = *this;
  std::vector<Eigen::Index> kept;
  std::vector<int> boards;
  for (std::size_t k = 0; k < vehicle_.rotors.size(); ++k)
    if (std::find(boards.begin(), boards.end(), vehicle_.rotors[k].board) == boards.end()) {
      boards.push_back(vehicle_.rotors[k].board);
      kept.push_back(static_cast<Eigen::Index>(k));
    }
  out.vehicle_.rotors.clear();
  for (const Eigen::Index k : kept)
    out.vehicle_.rotors.push_back(vehicle_.rotors[static_cast<std::size_t>(k)]);
  out.records_.resize(1);
  out.independent_.clear();
  DriveRecord& r = out.records_.front();
  r.steps = std::min(r.steps, static_cast<Eigen::Index>((seconds + kSettles) / r.step));
  const auto samples = std::lower_bound(r.t.begin(), r.t.end(), seconds + kSettles) - r.t.begin();
  const double share = static_cast<double>(samples) / static_cast<double>(r.t.size());
  r.t.resize(static_cast<std::size_t>(samples));
  r.ordered.value = Eigen::MatrixXd(r.ordered.value(kept, Eigen::all));
  for (Eigen::MatrixXd* x : {&r.speed, &r.command}) *x = Eigen::MatrixXd((*x)(Eigen::seqN(0, samples), kept));
  r.counts = Eigen::ArrayXX<bool>(r.counts(Eigen::seqN(0, samples), kept));
  for (const Eigen::Index k : kept)
    out.independent_.push_back(share * independent_[static_cast<std::size_t>(k)]);
  return out;
}

DriveModel::Rest DriveModel::compare(const DriveRecord& r, Eigen::Index rotor, const Eigen::MatrixXd& ends,
                                     bool left) const {
  Rest out;
  thread_local Regression fit;  // reused, as in simulate()
  fit.begin(static_cast<Eigen::Index>(r.t.size()), freedom_);
  const double middle = 0.5 * r.duration_s();
  const double offset = r.speed(r.speed.rows() / 2, rotor);
  QuickPart quick_predicted, quick_measured;
  thread_local std::vector<Eigen::Index> used;
  used.clear();
  for (std::size_t i = 0; i < r.t.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double at = std::clamp(r.t[i] / r.step, 0.0, static_cast<double>(ends.cols() - 1));
    const auto k = std::min(static_cast<Eigen::Index>(at), ends.cols() - 2);
    const double predicted =
        ends(rotor, k) + (at - static_cast<double>(k)) * (ends(rotor, k + 1) - ends(rotor, k));
    double p = predicted - offset, y = r.speed(row, rotor) - offset;
    if (r.from_duty_cycle) {
      p = quick_predicted.of(r.t[i], p);
      y = quick_measured.of(r.t[i], y);
    }
    if (r.t[i] < kSettles || !r.counts(row, rotor)) continue;
    fit.add({p, p * (r.t[i] - middle) / middle, offset}, y);
    used.push_back(row);
    out.moved += std::pow(predicted - r.command(row, rotor), 2);
    out.speed += std::abs(r.speed(row, rotor));
  }
  if (fit.size() < 10) return Rest{};
  out.samples = static_cast<double>(fit.size());
  out.moved /= out.samples;
  out.speed /= out.samples;
  fit.solve();
  out.mean_square = fit.residual().square().mean();
  const double resolved = kResolved * out.speed;
  out.log_density =
      fit.mean_log_density(fit.scale2() + law_error_ * law_error_ * out.moved + resolved * resolved);
  if (left) {
    out.left = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(r.t.size()));
    for (Eigen::Index i = 0; i < fit.size(); ++i)
      out.left[used[static_cast<std::size_t>(i)]] = fit.weight()[i] * fit.residual()[i];
  }
  return out;
}

bool DriveModel::simulate(const DriveSet& set, std::vector<Rest>& out, bool left) const {
  out.clear();
  physics::Actuation a = physics::nominal_actuation(vehicle_);
  for (double& tau : a.time_constant) tau *= std::exp(kLagTold * set.coordinates[0]);
  for (std::size_t m = 0; m < set.members.size(); ++m)
    set.members[m]->alter_actuation(vehicle_, set.theta(m, size_).data(), a);
  for (const DriveRecord& r : records_) {
    thread_local Eigen::MatrixXd ends;  // reused, since the cost is evaluated thousands of times
    if (!simulate_drives(vehicle_, a, r.ordered, between_, r.step, r.steps, stamps_s_ * set.coordinates[1],
                         r.speed.row(0).transpose(), ends))
      return false;
    for (Eigen::Index k = 0; k < ends.rows(); ++k) out.push_back(compare(r, k, ends, left));
  }
  return true;
}

double DriveModel::cost(const DriveSet& set) const {
  std::vector<Rest> rest;
  if (!simulate(set, rest, false)) return kNone;
  double sum = 0.5 * set.coordinates.squaredNorm();
  for (std::size_t k = 0; k < rest.size(); ++k) {
    if (rest[k].samples == 0) continue;
    sum -= independent_[k] / temperature_ * rest[k].log_density;
  }
  return std::isfinite(sum) ? sum : kNone;
}

void DriveModel::count_samples(const DriveSet& set) {
  std::vector<Rest> rest;
  if (!simulate(set, rest, true)) return;
  for (std::size_t k = 0; k < rest.size(); ++k) {
    const Eigen::VectorXd& x = rest[k].left;
    const double power = x.squaredNorm();
    // integrated autocorrelation up to its first zero (initial positive sequence, Geyer 1992)
    double correlation = 1;
    for (Eigen::Index lag = 1; power > 0 && lag < x.size() / 4; ++lag) {
      const double now = x.head(x.size() - lag).dot(x.tail(x.size() - lag)) / power;
      if (now <= 0) break;
      correlation += 2 * now;
    }
    independent_[k] = rest[k].samples / correlation;
  }
}

double DriveModel::samples() const { return std::accumulate(independent_.begin(), independent_.end(), 0.0); }

double DriveModel::rms_left(const DriveSet& set) const {
  std::vector<Rest> rest;
  if (!simulate(set, rest, false)) return kNone;
  double sum = 0, samples = 0;
  for (const Rest& r : rest) {
    sum += r.samples * r.mean_square;
    samples += r.samples;
  }
  return samples > 0 ? std::sqrt(sum / samples) : kNone;
}

}  // namespace omniflight::diagnosis
