#include "omniflight_identification/prbs.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_identification/residual_tests.hpp"

namespace omniflight::identification {
namespace {

// Taps of maximal-length registers of 5 to 16 bits (Horowitz and Hill, The Art of Electronics, table 9.9):
// the new bit is the exclusive or of bits n and m.
struct Taps {
  int n, m;
};
constexpr Taps kRegisters[] = {{5, 3}, {6, 5}, {7, 6}, {9, 5}, {10, 7}, {11, 9}, {15, 14}};
constexpr double kHalfPower = 0.4429;  // band * bit where sinc^2 is one half
constexpr Eigen::Index kFewestBits = 31;
constexpr int kLags = 20;

Eigen::Index bits_of(const Prbs& p, double duration_s) {
  return std::max<Eigen::Index>(1, static_cast<Eigen::Index>(std::floor(duration_s / p.bit_s)));
}

Status check(const PrbsConfig& c) {
  for (const double x : {c.low, c.high, c.band_hz, c.period_s, c.duration_s, c.lead_s, c.max_slope})
    if (!std::isfinite(x)) return bad_input("has a value that is not finite", "prbs");
  if (!(c.low < c.high))
    return bad_input("the low level is " + std::to_string(c.low) + ", must be below the high one of " +
                         std::to_string(c.high),
                     "levels");
  if (!(c.period_s >= 1e-4) || c.period_s > 1)
    return bad_input("is " + std::to_string(c.period_s) + " s, 0.0001 to 1 s are possible", "period");
  if (!(c.duration_s > 0) || c.duration_s > 3600 || c.lead_s < 0 || c.lead_s > 60)
    return bad_input("up to 3600 s, with a lead of up to 60 s, are possible", "duration");
  const double highest = kHalfPower / (2 * c.period_s);
  if (!(c.band_hz > 0) || c.band_hz > highest)
    return bad_input("is " + std::to_string(c.band_hz) + " Hz, up to " + std::to_string(highest) +
                         " Hz are possible with commands every " + std::to_string(c.period_s) +
                         " s (a bit lasts at least two of them)",
                     "band", "Lower the band or command faster");
  if (c.max_slope < 0) return bad_input("is negative", "slope");
  if (c.seed == 0)
    return bad_input("is 0, with which the register stands still", "seed", "Choose another number");
  return {};
}

}  // namespace

Result<Prbs> make_prbs(const PrbsConfig& c) {
  if (auto ok = check(c); !ok) return Failure(ok.error());
  Prbs out;
  out.bit_samples = std::max(2, static_cast<int>(std::lround(kHalfPower / c.band_hz / c.period_s)));
  out.bit_s = out.bit_samples * c.period_s;
  const double ramp = c.max_slope > 0 ? (c.high - c.low) / c.max_slope : 0.0;
  if (ramp > 0.5 * out.bit_s)
    return bad_input("a change of level takes " + std::to_string(ramp) + " s, more than half a bit of " +
                         std::to_string(out.bit_s) + " s",
                     "slope", "Lower the band, bring the levels together or allow a larger slope");
  const Eigen::Index bits = bits_of(out, c.duration_s);
  Taps taps = kRegisters[0];
  for (const Taps& longer : kRegisters)
    if ((Eigen::Index{1} << taps.n) - 1 < bits) taps = longer;
  out.register_bits = taps.n;
  const auto lead = static_cast<Eigen::Index>(std::lround(c.lead_s / c.period_s));
  const Eigen::Index n = bits * out.bit_samples;
  const double middle = 0.5 * (c.low + c.high);
  out.values.setConstant(n + 2 * lead, middle);
  std::uint32_t state = c.seed & ((1u << taps.n) - 1);
  if (state == 0) state = 1;
  for (Eigen::Index k = 0; k < bits; ++k) {
    const std::uint32_t bit = ((state >> (taps.n - 1)) ^ (state >> (taps.m - 1))) & 1u;
    state = ((state << 1) | bit) & ((1u << taps.n) - 1);
    out.values.segment(lead + k * out.bit_samples, out.bit_samples).setConstant(bit ? c.high : c.low);
  }
  if (c.max_slope > 0) {
    double now = middle;
    for (double& value : out.values)
      now = value = now + std::clamp(value - now, -c.max_slope * c.period_s, c.max_slope * c.period_s);
  }
  return out;
}

namespace {

/// A stretch at one side of the middle of the levels.
struct Run {
  Eigen::Index from, to;
  double level;  // -1 or 1
  bool stray;    // more than half of it is at neither level
};

std::vector<Run> runs_of(const Eigen::VectorXd& u, double low, double high) {
  const double near = 0.05 * (high - low), middle = 0.5 * (low + high);
  std::vector<Run> runs;
  Eigen::Index stray = 0, from = 0;
  for (Eigen::Index t = 0; t < u.size(); ++t) {
    stray += u[t] > low + near && u[t] < high - near;
    if (t + 1 < u.size() && (u[t + 1] > middle) == (u[t] > middle)) continue;
    runs.push_back({from, t + 1, u[t] > middle ? 1.0 : -1.0, 2 * stray > t + 1 - from});
    from = t + 1;
    stray = 0;
  }
  return runs;
}

/// Samples a bit: what a tenth of the runs do not exceed, then made finer by counting bits over all of them.
double bit_of(const std::vector<Run>& runs) {
  std::vector<Eigen::Index> lengths;
  for (const Run& r : runs) lengths.push_back(r.to - r.from);
  const auto tenth = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 10);
  std::nth_element(lengths.begin(), tenth, lengths.end());
  const double coarse = static_cast<double>(*tenth);
  double samples = 0, bits = 0;
  for (const Run& r : runs) {
    const double length = static_cast<double>(r.to - r.from);
    if (length > 20 * coarse) continue;
    samples += length;
    bits += std::max(1.0, std::round(length / coarse));
  }
  return bits > 0 ? samples / bits : 1.0;
}

/// The bits of runs first .. last - 1, and how many of these runs are stray.
std::pair<Eigen::VectorXd, int> bits_of(const std::vector<Run>& runs, std::size_t first, std::size_t last,
                                        double bit) {
  std::vector<double> bits;
  int stray = 0;
  for (std::size_t k = first; k < last; ++k) {
    const double length = static_cast<double>(runs[k].to - runs[k].from);
    bits.insert(bits.end(), static_cast<std::size_t>(std::max(1.0, std::round(length / bit))), runs[k].level);
    stray += runs[k].stray;
  }
  return {Eigen::Map<Eigen::VectorXd>(bits.data(), static_cast<Eigen::Index>(bits.size())), stray};
}

double whiteness_statistic(const Eigen::VectorXd& bits, int lags) {
  return static_cast<double>(bits.size()) * autocorrelation(bits, lags).tail(lags).squaredNorm();
}

}  // namespace

std::optional<WhitePart> white_part(const Eigen::VectorXd& u) {
  if (u.size() < kFewestBits || !u.allFinite() || !(u.maxCoeff() > u.minCoeff())) return std::nullopt;
  const std::vector<Run> runs = runs_of(u, u.minCoeff(), u.maxCoeff());
  const double bit = bit_of(runs);
  std::size_t first = 0, last = runs.size();
  while (last - first >= static_cast<std::size_t>(kFewestBits) / 4) {
    const auto [bits, stray] = bits_of(runs, first, last, bit);
    if (bits.size() < kFewestBits) return std::nullopt;
    const int lags = static_cast<int>(std::min<Eigen::Index>(kLags, bits.size() / 4));
    if (stray == 0 && chi_squared_tail(whiteness_statistic(bits, lags), lags) >= 0.01) {
      WhitePart part;
      part.from = runs[first].from;
      part.to = runs[last - 1].to;
      part.bit_samples = bit;
      part.bits = bits.size();
      part.correlation = autocorrelation(bits, lags);
      part.bound = kTwoSided99 / std::sqrt(static_cast<double>(bits.size()));
      return part;
    }
    // the end whose half is less white goes, a thirty-second at a time
    const std::size_t middle = (first + last) / 2, drop = std::max<std::size_t>(1, (last - first) / 32);
    const auto [head, head_stray] = bits_of(runs, first, middle, bit);
    const auto [tail, tail_stray] = bits_of(runs, middle, last, bit);
    const int half_lags = std::max(1, lags / 2);
    const bool head_goes = head_stray != tail_stray
                               ? head_stray > tail_stray
                               : whiteness_statistic(head, half_lags) > whiteness_statistic(tail, half_lags);
    if (head_goes)
      first += drop;
    else
      last -= drop;
  }
  return std::nullopt;
}

double followed_share(double bit_s, double lag_s) { return 1.0 - std::exp(-bit_s / lag_s); }

}  // namespace omniflight::identification
