#include "omniflight_identification/pidn.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace omniflight::identification {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kFrequencies = 400;
constexpr double kFilterOfDerivative = 10.0;  // N is this over the derivative time, at most 1 / (2 T)

/// y+ = all y + old u(t - 1 - whole) + now u(t - whole), exact for a held command (Astrom and Wittenmark
/// 1997, 2.4).
struct SampledLag {
  double all, old, now;
  int whole;
};
SampledLag sampled(const LagPlant& p, double T) {
  const double late = p.delay_s / T;
  const int whole = static_cast<int>(std::floor(late));
  const double all = std::exp(-T / p.lag_s), rest = std::exp(-T * (1.0 - (late - whole)) / p.lag_s);
  return {all, p.gain * (rest - all), p.gain * (1.0 - rest), whole};
}

PidnGains simc(const LagPlant& p, double closed_loop_s, double T, bool derivative) {
  const double delay = p.delay_s + 0.5 * T;
  const double kc = p.lag_s / (p.gain * (closed_loop_s + delay));
  const double ti = std::min(p.lag_s, 4 * (closed_loop_s + delay)), td = derivative ? delay / 3 : 0.0;
  PidnGains g;
  g.kp = kc * (1 + td / ti);
  g.ki = kc / ti;
  g.kd = kc * td;
  g.n = derivative ? std::min(kFilterOfDerivative / td, 0.5 / T) : 0.0;
  return g;
}

LagPlant mean_of(const std::vector<LagPlant>& plants) {
  LagPlant mean;
  const double share = 1.0 / static_cast<double>(plants.size());
  for (const LagPlant& p : plants) {
    mean.gain += share * p.gain;
    mean.lag_s += share * p.lag_s;
    mean.delay_s += share * p.delay_s;
  }
  return mean;
}

std::vector<LagPlant> spread(const std::vector<LagPlant>& plants, double share) {
  std::vector<LagPlant> out;
  for (const LagPlant& p : plants)
    for (const double factor : {1.0 - share, 1.0, 1.0 + share}) {
      out.push_back(p);
      out.back().gain *= factor;
    }
  return out;
}

Margins worst_of(const PidnGains& gains, const std::vector<LagPlant>& plants, double T) {
  Margins worst;
  worst.stable = true;
  worst.gain_margin = worst.phase_margin_rad = worst.delay_margin_s = std::numeric_limits<double>::infinity();
  for (const LagPlant& p : plants) {
    const Margins m = margins(gains, p, T);
    worst.max_sensitivity = std::max(worst.max_sensitivity, m.max_sensitivity);
    worst.crossover_radps = std::max(worst.crossover_radps, m.crossover_radps);
    worst.gain_margin = std::min(worst.gain_margin, m.gain_margin);
    worst.phase_margin_rad = std::min(worst.phase_margin_rad, m.phase_margin_rad);
    worst.delay_margin_s = std::min(worst.delay_margin_s, m.delay_margin_s);
    worst.stable = worst.stable && m.stable;
  }
  return worst;
}

}  // namespace

Status check(const std::vector<LagPlant>& plants, const TuningOptions& o) {
  if (plants.empty()) return bad_input("there is no motor to tune", "plants");
  if (!(o.control_period_s >= 1e-5 && o.control_period_s <= 0.1))
    return bad_input("is " + std::to_string(o.control_period_s) + " s, 0.00001 to 0.1 s are possible",
                     "control period");
  if (!(o.max_sensitivity >= 1.2 && o.max_sensitivity <= 3))
    return bad_input("is " + std::to_string(o.max_sensitivity) + ", 1.2 to 3 are possible",
                     "max sensitivity");
  if (!(o.gain_spread >= 0 && o.gain_spread < 0.9)) return bad_input("must lie in 0 to 0.9", "gain spread");
  for (const LagPlant& p : plants) {
    if (!(p.gain > 0) || !std::isfinite(p.gain))
      return bad_input("is " + std::to_string(p.gain) + ", must be positive", "gain",
                       "Identify the motor again");
    if (!(p.lag_s > 0) || p.lag_s > 10 || !(p.delay_s >= 0) || p.delay_s > 1)
      return bad_input("lag [s] must lie in 0 to 10 and delay [s] in 0 to 1", "motor",
                       "Identify the motor again");
    if (p.lag_s < 0.5 * o.control_period_s)
      return bad_input("a lag of " + std::to_string(1000 * p.lag_s) +
                           " ms is shorter than half a control period of " +
                           std::to_string(1000 * o.control_period_s) + " ms",
                       "control period", "Close the loop faster");
  }
  return {};
}

std::complex<double> response(const PidnGains& g, double T, double w) {
  const std::complex<double> back = std::exp(std::complex<double>(0, -w * T));  // z^-1
  // backward Euler: s becomes (1 - z^-1) / T
  const std::complex<double> s = (1.0 - back) / T;
  return g.kp + g.ki / s + (g.kd > 0 ? g.kd * g.n * s / (s + g.n) : 0.0);
}

std::complex<double> response(const LagPlant& p, double T, double w) {
  const SampledLag d = sampled(p, T);
  const std::complex<double> back = std::exp(std::complex<double>(0, -w * T));
  return std::pow(back, d.whole + 1) * (d.now + d.old * back) / (1.0 - d.all * back);
}

std::vector<double> closed_loop_step(const PidnGains& g, const LagPlant& p, double T, int samples) {
  const SampledLag d = sampled(p, T);
  std::vector<double> y(static_cast<std::size_t>(samples), 0.0), u = y;
  const auto past = [&](int t) { return t >= 0 ? u[static_cast<std::size_t>(t)] : 0.0; };
  double integral = 0, filtered = 0, before = 0;
  for (int t = 0; t < samples; ++t) {
    const auto k = static_cast<std::size_t>(t);
    if (t > 0) y[k] = d.all * y[k - 1] + d.now * past(t - 1 - d.whole) + d.old * past(t - 2 - d.whole);
    const double error = 1.0 - y[k];
    integral += g.ki * T * error;
    if (g.kd > 0) filtered = (filtered + g.kd * g.n * (error - before)) / (1.0 + g.n * T);
    before = error;
    u[k] = g.kp * error + integral + filtered;
  }
  return y;
}

Margins margins(const PidnGains& gains, const LagPlant& plant, double T) {
  Margins m;
  m.gain_margin = m.phase_margin_rad = m.delay_margin_s = std::numeric_limits<double>::infinity();
  const double top = kPi / T, bottom = 1e-3 / (plant.lag_s + plant.delay_s + T);
  std::complex<double> before = 0;
  double w_before = 0;
  for (int k = 0; k < kFrequencies; ++k) {
    const double w = bottom * std::pow(top / bottom, k / (kFrequencies - 1.0));
    const std::complex<double> L = response(gains, T, w) * response(plant, T, w);
    m.max_sensitivity = std::max(m.max_sensitivity, 1.0 / std::abs(1.0 + L));
    if (k > 0) {
      if (std::abs(before) >= 1 && std::abs(L) < 1) {  // crossover
        const double phase =
            std::abs(kPi + std::remainder(std::arg(L), 2 * kPi) - (std::arg(L) > 0 ? 2 * kPi : 0.0));
        m.phase_margin_rad = std::min(m.phase_margin_rad, phase);
        m.crossover_radps = 0.5 * (w + w_before);
        m.delay_margin_s = std::min(m.delay_margin_s, phase / m.crossover_radps);
      }
      if (before.imag() < 0 && L.imag() >= 0 && L.real() < 0)  // the negative real axis
        m.gain_margin = std::min(m.gain_margin, 1.0 / std::abs(L.real()));
    }
    before = L;
    w_before = w;
  }
  const int samples = static_cast<int>(std::min(2e5, 200 * (plant.lag_s + plant.delay_s) / T + 100));
  const std::vector<double> y = closed_loop_step(gains, plant, T, samples);
  double late = 0;
  for (std::size_t k = y.size() - y.size() / 10; k < y.size(); ++k)
    late = std::max(late, std::abs(y[k] - 1.0));
  m.stable = late < 0.01;
  return m;
}

Result<Tuning> assessed(const PidnGains& gains, const std::vector<LagPlant>& plants,
                        const TuningOptions& options) {
  if (auto ok = check(plants, options); !ok) return Failure(ok.error());
  const double T = options.control_period_s;
  const LagPlant nominal = mean_of(plants);
  const std::vector<LagPlant> all = spread(plants, options.gain_spread);
  Tuning out;
  out.gains = gains;
  out.nominal = margins(out.gains, nominal, T);
  out.worst = worst_of(out.gains, all, T);
  const int samples = static_cast<int>(std::min(2e5, 20 * (nominal.lag_s + nominal.delay_s) / T + 100));
  const std::vector<double> y = closed_loop_step(out.gains, nominal, T, samples);
  out.overshoot = std::max(0.0, *std::max_element(y.begin(), y.end()) - 1.0);
  const auto risen = std::find_if(y.begin(), y.end(), [](double v) { return v >= 0.9; });
  out.rise_s = T * static_cast<double>(risen - y.begin());
  return out;
}

Result<Tuning> tune_pidn(const std::vector<LagPlant>& plants, const TuningOptions& options) {
  if (auto ok = check(plants, options); !ok) return Failure(ok.error());
  const double T = options.control_period_s;
  const LagPlant nominal = mean_of(plants);
  const std::vector<LagPlant> all = spread(plants, options.gain_spread);
  const auto keeps = [&](const PidnGains& gains) {
    for (const LagPlant& p : all) {
      const Margins m = margins(gains, p, T);
      if (!m.stable || !(m.max_sensitivity <= options.max_sensitivity)) return false;
    }
    return true;
  };
  const double slowest = 20 * (nominal.lag_s + nominal.delay_s + T),
               fastest = 0.1 * (nominal.delay_s + 0.5 * T);
  Tuning best;
  best.closed_loop_s = std::numeric_limits<double>::infinity();
  for (const bool derivative : {false, true}) {
    if (!keeps(simc(nominal, slowest, T, derivative))) continue;
    double slow = slowest, fast = fastest;  // slow keeps the margins
    for (int k = 0; k < 40; ++k) {
      const double middle = std::sqrt(slow * fast);
      (keeps(simc(nominal, middle, T, derivative)) ? slow : fast) = middle;
    }
    if (slow < 0.9 * best.closed_loop_s) {
      best.closed_loop_s = slow;
      best.gains = simc(nominal, slow, T, derivative);
    }
  }
  if (!std::isfinite(best.closed_loop_s))
    return fail(
        ErrorCode::incomplete,
        "no gains keep the sensitivity within " + std::to_string(options.max_sensitivity) + " for all motors",
        "max sensitivity", "Allow more, shorten the control period, or tune the rotors apart");
  Tuning out = *assessed(best.gains, plants, options);
  out.closed_loop_s = best.closed_loop_s;
  return out;
}

}  // namespace omniflight::identification
