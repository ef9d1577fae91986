#include "quantisation.hpp"

#include <cmath>
#include <complex>
#include <vector>

#include "omniflight_core/frames.hpp"

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured.
constexpr double kLeastStep = 4, kMostStep = 160;  // rad/s, range of step sizes tried
constexpr std::size_t kMostSamples = 5000;         // bounds the run time
constexpr double kMotorLag = 0.05;                 // s, first-order lag applied to the commands
// Mean resultant length of the phases 2 pi speed / step: above kGathered the speeds are quantised, below
// kSpread the commands are not.
constexpr double kGathered = 0.7, kSpread = 0.35;

struct Speeds {
  std::vector<double> measured, asked;  ///< rad/s, pairs of speed and command, all rotors
};

/// Samples whose speed differs by less than 0.2 % from the one before; at most kMostSamples, evenly spread
/// (their mean resultant length would be 1 / sqrt(5000) = 0.014 for uniform phases).
Speeds at_rest(const recording::Signal& s, const Eigen::MatrixXd& command) {
  Speeds out;
  for (Eigen::Index c = 0; c < s.values.cols(); ++c)
    for (Eigen::Index i = 1; i < s.values.rows(); ++i) {
      const double a = s.values(i - 1, c), b = s.values(i, c), u = command(i, c);
      if (!std::isfinite(a) || !std::isfinite(b) || !std::isfinite(u)) continue;
      if (b == 0 || std::abs(b - a) > 0.002 * std::abs(b)) continue;  // zero: too slow for the telemetry
      out.measured.push_back(b);
      out.asked.push_back(u);
    }
  const std::size_t all = out.measured.size();
  if (all <= kMostSamples) return out;
  for (std::size_t k = 0; k < kMostSamples; ++k) {
    out.measured[k] = out.measured[k * all / kMostSamples];
    out.asked[k] = out.asked[k * all / kMostSamples];
  }
  out.measured.resize(kMostSamples);
  out.asked.resize(kMostSamples);
  return out;
}

/// Commands through the motor lag: a constant speed under a noisy command is no sign of quantisation, since
/// the motor filters that noise.
Eigen::MatrixXd lagged(Eigen::MatrixXd command, const std::vector<double>& t_s) {
  for (Eigen::Index c = 0; c < command.cols(); ++c)
    for (Eigen::Index i = 1; i < command.rows(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double before = command(i - 1, c), share = 1.0 - std::exp(-(t_s[k] - t_s[k - 1]) / kMotorLag);
      if (std::isfinite(before) && std::isfinite(command(i, c)))
        command(i, c) = before + share * (command(i, c) - before);
    }
  return command;
}

/// Mean resultant length of the phases 2 pi x / step.
double gathered(const std::vector<double>& x, double step) {
  std::complex<double> sum = 0;
  for (double v : x) sum += std::polar(1.0, 2 * kPi * v / step);
  return std::abs(sum) / static_cast<double>(x.size());
}

}  // namespace

std::optional<double> speed_step(const recording::Recording& r) {
  const recording::Signal *speed = r.find("rotor_speed"), *command = r.find("rotor_command");
  if (!speed || !command || speed->width() != command->width() || speed->size() < 200) return std::nullopt;
  const auto [measured, asked] =
      at_rest(*speed, lagged(recording::resample(*command, speed->t_s, 0.1), speed->t_s));
  if (measured.size() < 500) return std::nullopt;
  std::optional<double> best;
  for (double step = kLeastStep; step <= kMostStep; step *= 1.002)
    if (gathered(measured, step) > kGathered && gathered(asked, step) < kSpread) best = step;
  if (!best) return std::nullopt;
  double peak = 0, at = *best;
  for (double step = 0.97 * *best; step <= 1.03 * *best; step *= 1.0002)
    if (const double g = gathered(measured, step); g > peak) peak = g, at = step;
  return at;
}

}  // namespace omniflight::diagnosis
