#include "structural_resonance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "../numerics/text.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured.
constexpr std::array kShares{0.0, -0.6, -0.3, -0.1, 0.05, 0.1, 0.2, 0.4};
constexpr double kNone = 0.5;  // prior probability that an axis has no share
constexpr std::array kDampings{0.03, 0.08};
constexpr int kFrequencies = 40;              // evenly in their logarithm
constexpr double kLowest = 5, kHighest = 35;  // Hz

double frequency_at(int k) { return kLowest * std::pow(kHighest / kLowest, k / (kFrequencies - 1.0)); }

/// x through wn^2 / (s^2 + 2 zeta wn s + wn^2) from rest; exact for an input that is constant between samples
/// at their mean.
Eigen::VectorXd resonating(const Eigen::VectorXd& x, double frequency_hz, double damping, double rate_hz) {
  const double wn = 2 * kPi * frequency_hz, decay = damping * wn, wd = wn * std::sqrt(1 - damping * damping),
               t = 1 / rate_hz, e = std::exp(-decay * t), c = std::cos(wd * t), s = std::sin(wd * t) / wd;
  Eigen::Matrix2d next;
  next << e * (c + decay * s), e * s, -e * wn * wn * s, e * (c - decay * s);
  const Eigen::Vector2d in = (Eigen::Matrix2d::Identity() - next).col(0);  // a constant passes unchanged
  Eigen::VectorXd out(x.size());
  Eigen::Vector2d state = Eigen::Vector2d::Zero();
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    state = next * state + in * 0.5 * (x[i] + x[std::max<Eigen::Index>(0, i - 1)]);
    out[i] = state[0];
  }
  return out;
}

}  // namespace

std::optional<StructuralResonance> structural_resonance(const RotorRegression& regression, double clock_s,
                                                        double temperature) {
  if (!regression.enough() || regression.is_feedback(clock_s)) return std::nullopt;
  const int shift = regression.best_shift();
  const double samples = regression.independent_samples() / temperature;
  StructuralResonance out;
  double most = 0;
  std::array<std::array<double, kFrequencies>, kDampings.size()> likely{};
  int at = 0;
  std::size_t damped = 0;
  for (std::size_t d = 0; d < kDampings.size(); ++d)
    for (int k = 0; k < kFrequencies; ++k) {
      double sum = 0, clearest = 0, share = 0;
      for (int c = 0; c < regression.axes(); ++c) {
        const auto left = regression.left(
            c, resonating(regression.wrench(c), frequency_at(k), kDampings[d], regression.rate_hz()), shift,
            kShares);
        if (*std::min_element(left.begin(), left.end()) > 1 - kLeastByRotors) continue;
        double mean = kNone;  // over shares, relative to none
        for (std::size_t s = 1; s < kShares.size(); ++s) {
          const double gain = 0.5 * samples * std::log(left[0] / left[s]);
          mean += (1 - kNone) / (kShares.size() - 1.0) * std::exp(std::min(gain, 600.0));
          if (gain > clearest) clearest = gain, share = kShares[s];
        }
        sum += std::log(mean);
      }
      likely[d][static_cast<std::size_t>(k)] = sum;
      if (sum > most) most = sum, at = k, damped = d, out.share = share;
    }
  double all = 0;
  for (const auto& row : likely)
    for (const double x : row) all += std::exp(x - most) / (kDampings.size() * kFrequencies);
  out.log_factor = most + std::log(all);
  if (!(out.log_factor > 0) || at == 0 || at + 1 == kFrequencies) return std::nullopt;
  const auto& row = likely[damped];
  const auto k = static_cast<std::size_t>(at);
  const double bend = -(row[k - 1] - 2 * row[k] + row[k + 1]);
  const double step = std::log(frequency_at(1) / frequency_at(0));
  out.frequency_hz = frequency_at(at) * std::exp(0.5 * (row[k + 1] - row[k - 1]) / bend * step);
  out.frequency_se = out.frequency_hz * step / std::sqrt(bend);
  out.damping = kDampings[damped];
  return out;
}

SensorFault as_fault(const StructuralResonance& r) {
  SensorFault out;
  out.effect = physics::effect_id::structural_mode;
  out.channel = "gyro";
  out.share = 1;
  out.log_factor = r.log_factor;
  out.sentence = format("the motion resonates at %.1f +- %.1f Hz in what the rotors do: %s.", r.frequency_hz,
                        r.frequency_se,
                        r.share > 0 ? "a part of the vehicle is loose, or its arms bend"
                                    : "the inertial sensor is on a soft mount");
  const double wide = 1.96 * r.frequency_se;
  out.parameters = {{"frequency", "f_n", "Hz", r.frequency_hz, r.frequency_hz - wide, r.frequency_hz + wide}};
  if (r.share < 0) out.parameters.push_back({"participation", "p", "1", -r.share, 0, 1});
  return out;
}

}  // namespace omniflight::diagnosis
