#include "pulsations.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

#include "patterns.hpp"

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured.
constexpr double kPeriods = 8;   ///< least periods in the longest flight; fewer are drift
constexpr double kHighest = 10;  ///< Hz, half of the Nyquist frequency of the 40 Hz grid
constexpr int kFiner = 4;        ///< zero padding: frequencies per resolution 1 / duration

using Spectrum = std::vector<std::complex<double>>;

/// Axis of a pulsation: wrench channel in body axes, or force along a world axis.
struct BeatAxis {
  int channel = 0;
  bool world = false;
};

/// Component of the unit wrench along `axis` in a body channel at a sample.
double share_of(const RegressionProblem& problem, const BeatAxis& axis, int channel, int sample) {
  if (!axis.world) return channel == axis.channel ? 1.0 : 0.0;
  return channel < 3 ? problem.situation(sample).R_WB(axis.channel, channel) : 0.0;
}

/// First and last sample of a flight.
std::vector<Stretch> spans(const RegressionProblem& problem) {
  std::vector<Stretch> out(static_cast<std::size_t>(problem.flights()), {problem.samples(), 0, 0});
  for (const Stretch& s : problem.stretches()) {
    Stretch& flight = out[static_cast<std::size_t>(s.flight)];
    flight = {std::min(flight.begin, s.begin), std::max(flight.end, s.end), s.flight};
  }
  return out;
}

}  // namespace

std::vector<Pulsation> make_pulsations(const RegressionProblem& problem, const NoiseModel& noise) {
  std::vector<Pulsation> out;
  const int n = problem.samples();
  const std::vector<Stretch> flights = spans(problem);
  double longest = 0;  // s
  for (const Stretch& f : flights)
    if (f.size() > 1)
      longest = std::max(longest, problem.measured(f.end - 1).t - problem.measured(f.begin).t);
  const double highest = std::min(kHighest, 0.25 / problem.period()),
               lowest = kPeriods / std::max(1e-9, longest);
  if (!(lowest < highest)) return out;
  int length = kFiner * static_cast<int>(std::ceil(longest / problem.period()) + 1);
  while (transform_length(length) != length) ++length;  // lengths with fast transforms
  const double step = 1 / (length * problem.period());  // Hz
  const Eigen::VectorXd weighted = noise.weigh(noise.residual());
  Eigen::FFT<double> fft;
  for (int k = 0; k < 9; ++k) {
    const BeatAxis axis{k < 6 ? k : k - 6, k >= 6};
    if (problem.forces_only() && !axis.world && axis.channel >= 3) continue;
    // gain in log-likelihood of a cosine and a sine, treated as orthogonal (periodogram)
    const auto bins = static_cast<std::size_t>(highest / step) + 1;
    std::vector<double> gain(bins, 0.0);
    for (const Stretch& f : flights) {
      Spectrum in(static_cast<std::size_t>(length), 0.0), spectrum;
      std::array<double, 6> square{};
      for (int i = f.begin; i < f.end; ++i) {
        const double at = (problem.measured(i).t - problem.measured(f.begin).t) / problem.period();
        auto& x = in[std::min(static_cast<std::size_t>(std::lround(at)), in.size() - 1)];
        for (int c = 0; c < 6; ++c) {
          const double share = share_of(problem, axis, c, i);
          x += share * weighted[c * n + i];
          square[static_cast<std::size_t>(c)] += share * share;
        }
      }
      fft.fwd(spectrum, in);
      const auto first = static_cast<std::size_t>(std::ceil(lowest / step));
      if (first >= bins) continue;
      const auto count = static_cast<Eigen::Index>(bins - first);
      const Eigen::ArrayXd frequencies =
          step * (static_cast<double>(first) + Eigen::ArrayXd::LinSpaced(count, 0, count - 1));
      Eigen::ArrayXd information = Eigen::ArrayXd::Zero(count);
      for (int c = 0; c < 6; ++c)
        if (square[static_cast<std::size_t>(c)] > 0 && !noise.spectrum(f.flight, c).silent())
          information +=
              0.5 * square[static_cast<std::size_t>(c)] / noise.spectrum(f.flight, c).densities(frequencies);
      for (std::size_t b = first; b < bins; ++b)
        if (const double known = information[static_cast<Eigen::Index>(b - first)]; known > 0)
          gain[b] += 0.5 * std::norm(spectrum[b]) / known;
    }
    const auto best = std::max_element(gain.begin(), gain.end());
    if (!(*best > 0)) continue;
    Pulsation p;
    p.distinct = std::max(1.0, (highest - lowest) * longest);
    p.pattern.channel = axis.channel;
    p.pattern.world = axis.world;
    p.pattern.variable = "time";
    p.pattern.unit = "s";
    p.pattern.frequency_hz = static_cast<double>(best - gain.begin()) * step;
    p.pattern.raw = Eigen::MatrixXd::Zero(problem.rows(), 2 * static_cast<Eigen::Index>(flights.size()));
    const double size = kPatternShare * problem.scale(axis.channel);
    for (const Stretch& f : flights)
      for (int i = f.begin; i < f.end; ++i) {
        const double phase = 2 * kPi * p.pattern.frequency_hz * problem.measured(i).t;
        for (int c = 0; c < 6; ++c) {
          const double share = size * share_of(problem, axis, c, i);
          if (share == 0) continue;
          p.pattern.raw(c * n + i, 2 * f.flight) = share * std::cos(phase);
          p.pattern.raw(c * n + i, 2 * f.flight + 1) = share * std::sin(phase);
        }
      }
    out.push_back(std::move(p));
  }
  return out;
}

}  // namespace omniflight::diagnosis
