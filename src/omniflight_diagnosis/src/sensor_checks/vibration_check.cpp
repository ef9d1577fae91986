#include "vibration_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "../numerics/statistics.hpp"
#include "../numerics/text.hpp"
#include "findings.hpp"
#include "omniflight_diagnosis/residual.hpp"
#include "omniflight_physics/effect_ids.hpp"
#include "omniflight_physics/prior.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Signal;

// Chosen, not measured.
constexpr double kWindow = 0.5;  // s; the phase of a line drifts with the errors of the speeds
constexpr int kOrder = 12;       // of the autoregression that whitens an axis
/// Neighbouring lines, in multiples of 1 / kWindow: as far as is needed to be orthogonal, on both sides.
constexpr int kBeside[] = {-5, -4, -3, -2, 2, 3, 4, 5};

/// One axis of the accelerometer whitened by an autoregression.
struct Whitened {
  Eigen::VectorXd filter;  ///< 1, -b_1, ..., -b_p
  Eigen::VectorXd y;       ///< m/s^2, from sample kOrder on; zero before

  explicit Whitened(Eigen::VectorXd x) {
    const Eigen::Index n = x.size();
    x.array() -= x.mean();
    Eigen::MatrixXd past(n - kOrder, kOrder);
    for (int j = 0; j < kOrder; ++j) past.col(j) = x.segment(kOrder - 1 - j, n - kOrder);
    Eigen::MatrixXd H = past.transpose() * past;
    H.diagonal().array() += 1e-9 * H.trace() + 1e-30;
    const Eigen::VectorXd b = H.llt().solve(past.transpose() * x.tail(n - kOrder));
    filter.resize(kOrder + 1);
    filter << 1, -b;
    y = Eigen::VectorXd::Zero(n);
    y.tail(n - kOrder) = x.tail(n - kOrder) - past * b;
  }
  /// Squared gain of the filter at an angle [rad] per sample.
  double gain2(double angle) const {
    std::complex<double> sum = 0;
    for (Eigen::Index j = 0; j < filter.size(); ++j)
      sum += filter[j] * std::polar(1.0, -angle * static_cast<double>(j));
    return std::norm(sum);
  }
};

/// Speeds [rad/s, samples x rotors] at the times of `t`, and how far the rotors have turned since its first
/// sample [rad].
struct Turning {
  Eigen::MatrixXd speed, phase;
};

/// Speeds that commands reach through the motors' nominal lags.
Eigen::MatrixXd through_lags(const Signal& command, const vehicle::Vehicle& vehicle) {
  Eigen::MatrixXd out = command.values.cwiseAbs();
  for (Eigen::Index r = 0; r < out.cols(); ++r) {
    const double tau = vehicle.rotors[static_cast<std::size_t>(r)].time_constant;
    if (!(tau > 0)) continue;
    for (Eigen::Index i = 1; i < out.rows(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      out(i, r) = lagged_speed(out(i - 1, r), std::abs(command.values(i - 1, r)), tau,
                               command.t_s[k] - command.t_s[k - 1]);
    }
  }
  return out;
}

/// Speeds between samples are linear. False where times do not overlap or a speed is not finite.
bool turning_of(const std::vector<double>& t, const std::vector<double>& at, const Eigen::MatrixXd& speed,
                Turning& out) {
  const auto n = static_cast<Eigen::Index>(t.size());
  if (at.size() < 2 || !speed.allFinite()) return false;
  Eigen::MatrixXd turned = Eigen::MatrixXd::Zero(speed.rows(), speed.cols());
  for (Eigen::Index i = 1; i < speed.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    turned.row(i) = turned.row(i - 1) + 0.5 * (at[k] - at[k - 1]) * (speed.row(i) + speed.row(i - 1));
  }
  out.speed.resize(n, speed.cols());
  out.phase.resize(n, speed.cols());
  std::size_t k = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double now = t[static_cast<std::size_t>(i)];
    while (k + 2 < at.size() && at[k + 1] <= now) ++k;
    const auto row = static_cast<Eigen::Index>(k);
    const double step = at[k + 1] - at[k], u = std::clamp(now - at[k], 0.0, step);
    const Eigen::RowVectorXd slope = (speed.row(row + 1) - speed.row(row)) / std::max(step, 1e-9);
    out.speed.row(i) = speed.row(row) + slope * u;
    out.phase.row(i) = turned.row(row) + speed.row(row) * u + 0.5 * slope * u * u;
  }
  return true;
}

/// A window of one axis at one frequency.
struct Line {
  double power = 0;        ///< chi-squared with two degrees of freedom where there is no line
  double information = 0;  ///< 1/m^2: ratio of variances of line and noise per squared imbalance
};

/// ln likelihood of these windows with an imbalance of `e` [m] against none: amplitudes of cosine and sine
/// are normal with variance e^2 Omega^4 / 2 in each window.
double log_likelihood(const std::vector<Line>& lines, double e) {
  double sum = 0;
  for (const Line& l : lines) {
    const double ratio = e * e * l.information;
    sum += 0.5 * l.power * ratio / (1 + ratio) - std::log1p(ratio);
  }
  return sum;
}

struct Imbalance {
  double log_factor = 0, mean = 0, deviation = 0;  ///< nat; m
};

/// Half-normal prior of standard deviation `scale` [m], by the trapezoidal rule over ln e.
Imbalance imbalance_of(const std::vector<Line>& lines, double scale) {
  constexpr int kPoints = 97;
  const double low = std::log(1e-4 * scale), step = (std::log(5 * scale) - low) / (kPoints - 1);
  std::vector<double> size(kPoints), density(kPoints);
  for (std::size_t k = 0; k < kPoints; ++k) {
    size[k] = std::exp(low + step * static_cast<double>(k));
    const double u = size[k] / scale;
    density[k] = log_likelihood(lines, size[k]) + std::log(std::sqrt(2 / kPi) * u * step) - 0.5 * u * u;
  }
  const double most = *std::max_element(density.begin(), density.end());
  double all = 0, first = 0, second = 0;
  for (std::size_t k = 0; k < kPoints; ++k) {
    const double p = std::exp(density[k] - most);
    all += p;
    first += p * size[k];
    second += p * size[k] * size[k];
  }
  Imbalance out{most + std::log(all), first / all, 0};
  out.deviation = std::sqrt(std::max(0.0, second / all - out.mean * out.mean));
  return out;
}

class Lines {
 public:
  Lines(const Signal& force, const vehicle::Vehicle& vehicle, Turning turning)
      : turning_(std::move(turning)), t_(force.t_s), period_(force.median_period_s()) {
    const auto per_window = static_cast<Eigen::Index>(kWindow / period_);
    for (Eigen::Index c = 0; c < 3; ++c) axes_.emplace_back(force.values.col(c));
    for (Eigen::Index from = kOrder; from + per_window <= force.size(); from += per_window) {
      bool whole = true;
      for (Eigen::Index i = from - kOrder + 1; whole && i < from + per_window; ++i)
        whole = t_[static_cast<std::size_t>(i)] - t_[static_cast<std::size_t>(i) - 1] < 1.8 * period_;
      if (whole) windows_.push_back(from);
    }
    size_ = per_window;
    scale_ =
        physics::prior_of(*physics::find_effect(physics::effect_id::vibration), 0, physics::size_of(vehicle))
            .slope(0);
  }
  std::size_t windows() const { return windows_.size(); }

  /// Imbalance along each axis at the phase of a rotor, with a line `beside` / kWindow [Hz] away as its
  /// frequency.
  std::array<Imbalance, 3> at(Eigen::Index rotor, int beside) const {
    std::array<std::vector<Line>, 3> lines;
    const double shift = 2 * kPi * beside / kWindow;
    for (const Eigen::Index from : windows_) {
      std::array<std::complex<double>, 3> sum{};
      std::array<double, 3> squares{};
      for (Eigen::Index i = from; i < from + size_; ++i) {
        const double angle = turning_.phase(i, rotor) + shift * t_[static_cast<std::size_t>(i)];
        const std::complex<double> turn(std::cos(angle), -std::sin(angle));
        for (std::size_t c = 0; c < 3; ++c) {
          sum[c] += axes_[c].y[i] * turn;
          squares[c] += axes_[c].y[i] * axes_[c].y[i];
        }
      }
      const double speed = turning_.speed.col(rotor).segment(from, size_).mean();
      const double angle = std::remainder((speed + shift) * period_, 2 * kPi);
      // sine and cosine are collinear where the sampled line stands still
      const double apart = 4 * kPi / static_cast<double>(size_);
      if (std::abs(angle) < apart || kPi - std::abs(angle) < apart) continue;
      const auto n = static_cast<double>(size_);
      for (std::size_t c = 0; c < 3; ++c) {
        const double variance = std::max(squares[c] / n, 1e-12);
        lines[c].push_back({2 * std::norm(sum[c]) / (n * variance),
                            std::pow(speed, 4) * n * axes_[c].gain2(angle) / (4 * variance)});
      }
    }
    std::array<Imbalance, 3> out;
    for (std::size_t c = 0; c < 3; ++c) out[c] = imbalance_of(lines[c], scale_);
    return out;
  }

 private:
  Turning turning_;
  const std::vector<double>& t_;
  double period_, scale_ = 0;
  std::vector<Whitened> axes_;
  std::vector<Eigen::Index> windows_;  ///< first samples of windows without gaps
  Eigen::Index size_ = 0;              ///< samples of a window
};

double log_factor(const std::array<Imbalance, 3>& axes) {
  return axes[0].log_factor + axes[1].log_factor + axes[2].log_factor;
}

}  // namespace

void add_vibration(const recording::Recording& r, const vehicle::Vehicle& vehicle, const Options& o,
                   Diagnosis& d) {
  constexpr Eigen::Index kFewest = 500;  // samples, some ten windows at 50 Hz
  const Signal *force = r.find("acc"), *measured = r.find("rotor_speed"), *command = r.find("rotor_command");
  const auto rotors = static_cast<Eigen::Index>(vehicle.rotors.size());
  const Signal* turns = measured ? measured : command;
  if (!(o.noise.accelerometer > 0) || !force || !turns || turns->width() != rotors) return;
  if (force->width() != 3 || force->size() < kFewest || turns->size() < 100) return;
  if (!force->values.allFinite() || !turns->values.allFinite()) return;
  Turning turning;
  if (!turning_of(force->t_s, turns->t_s,
                  measured ? Eigen::MatrixXd(turns->values.cwiseAbs()) : through_lags(*turns, vehicle),
                  turning))
    return;
  const Lines lines(*force, vehicle, std::move(turning));
  if (lines.windows() < 10) return;
  double most = 0;
  Eigen::Index strongest = 0;
  for (Eigen::Index k = 0; k < rotors; ++k) {
    const double own = log_factor(lines.at(k, 0));
    if (own <= most) continue;
    // the other rotors are lines, too: half of those beside are taken for the noise
    std::vector<double> beside;
    for (const int shift : kBeside) beside.push_back(log_factor(lines.at(k, shift)));
    if (const double factor = own - std::max(0.0, median(beside)); factor > most)
      most = factor, strongest = k;
  }
  if (!(most > 0)) return;
  const auto axes = lines.at(strongest, 0);
  double squares = 0, variance = 0;
  for (const Imbalance& a : axes) squares += a.mean * a.mean;
  const double size = std::sqrt(squares / 2);  // cosine and sine along the two axes of the rotor's plane
  for (const Imbalance& a : axes) variance += std::pow(a.mean * a.deviation / (2 * size), 2);
  const double error = std::sqrt(variance);
  add_sensor(
      d, physics::effect_id::vibration, "acc", "m",
      format("The accelerometer turns with the rotors: an imbalance of %.2g um, strongest at rotor %d.",
             1e6 * size, static_cast<int>(strongest) + 1),
      {{"imbalance", "e_u", "m", size, std::max(0.0, size - 1.96 * error), size + 1.96 * error}}, size,
      error);
  d.findings.back().log_factor = most;
}

}  // namespace omniflight::diagnosis
