#include "instruments.hpp"

#include <algorithm>
#include <cmath>

#include "repair.hpp"
#include "segments.hpp"

namespace omniflight::diagnosis {
namespace {

/// s: for so long the low passes carry what a rotor does while it reverses. It is quicker then than its
/// telemetry, which cannot read a rotor at rest, and the flight again reverses it at another moment.
constexpr double kAroundReversal = 0.2;
constexpr double kMostLeftOut = 0.2;   ///< of a flight; of one that reverses more often nothing at once
constexpr double kLeastSteady = 0.35;  ///< of such a flight, to judge by what is left

/// Samples within kAroundReversal of one at which a rotor has changed its direction.
std::vector<char> reversing(const Flight& f) {
  std::vector<char> out(static_cast<std::size_t>(f.size()), 0);
  const int margin = static_cast<int>(std::lround(kAroundReversal * f.rate_hz));
  for (int i = 1; i < f.size(); ++i)
    if ((f.rotor_speed.row(i).array() * f.rotor_speed.row(i - 1).array() < 0).any())
      std::fill(out.begin() + std::max(0, i - margin), out.begin() + std::min(f.size(), i + margin), 1);
  return out;
}

}  // namespace

std::optional<Flight> with_instruments(const Flight& flight, const Eigen::MatrixXd& wrench,
                                       const std::vector<physics::ActiveEffect>& motors,
                                       const vehicle::Vehicle& vehicle, const Options& o,
                                       const Reflight& refly) {
  if (!refly || flight.size() < 2) return std::nullopt;
  const auto flown = refly(wrench, flight.t.front(), flight.rate_hz, motors);
  if (!flown) return std::nullopt;
  Options same = o;
  same.grid_origin_s = flight.t.front();
  // a simulated flight without noise repeats itself rightly
  const auto again = prepare_repaired(as_it_is(*flown), vehicle, same);
  if (!again) return std::nullopt;
  const std::vector<char> flying = samples_in(again->segments, again->size()),
                          used = samples_in(flight.segments, flight.size());
  const int shift = static_cast<int>(std::lround((flight.t.front() - again->t.front()) * flight.rate_hz));
  Flight out = flight;
  out.instrument = flight.smooth;
  std::vector<char> known(static_cast<std::size_t>(flight.size()), 0), steady = known;
  const std::vector<char> here = reversing(flight), there = reversing(*again);
  for (int i = 0; i < flight.size(); ++i) {
    const int k = i + shift;
    if (k < 0 || k >= again->size() || !flying[static_cast<std::size_t>(k)]) continue;
    const auto at = static_cast<std::size_t>(i), other = static_cast<std::size_t>(k);
    out.instrument[at] = again->smooth[other];
    known[at] = 1;
    steady[at] = !here[at] && !there[other];
  }
  const auto runs = [&](std::vector<char> good) {
    for (std::size_t i = 0; i < good.size(); ++i) good[i] = good[i] && used[i];
    return long_runs(good, flight.rate_hz);
  };
  out.segments = runs(known);
  const std::vector<Segment> without = runs(steady);
  const double share = samples(without) / std::max(1.0, static_cast<double>(samples(out.segments)));
  if (share >= kLeastSteady)
    for (int i = 0, from = 0; i < flight.size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      const bool left_out = known[at] && !steady[at];
      if (left_out && (i + 1 == flight.size() || !known[at + 1] || steady[at + 1]))
        out.reversals.push_back({flight.t[static_cast<std::size_t>(from)], flight.t[at], "a rotor reverses"});
      if (!left_out) from = i + 1;
    }
  if (!out.reversals.empty()) out.between_reversals = without;
  if (share >= 1 - kMostLeftOut) leave_out_reversals(out);
  if (out.usable() < 2 * flight.rate_hz) return std::nullopt;
  return out;
}

bool leave_out_reversals(Flight& f) {
  if (f.between_reversals.empty()) return false;
  f.segments = std::move(f.between_reversals);
  f.excluded.insert(f.excluded.end(), f.reversals.begin(), f.reversals.end());
  f.between_reversals.clear();
  f.reversals.clear();
  return true;
}

}  // namespace omniflight::diagnosis
