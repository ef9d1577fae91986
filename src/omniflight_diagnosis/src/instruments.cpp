#include "instruments.hpp"

#include <cmath>

namespace omniflight::diagnosis {

std::optional<Flight> with_instruments(const Flight& flight, const Eigen::MatrixXd& wrench,
                                       const vehicle::Vehicle& vehicle, const Options& o,
                                       const Reflight& refly) {
  if (!refly || flight.size() < 2) return std::nullopt;
  const auto flown = refly(wrench, flight.t.front(), flight.rate_hz);
  if (!flown) return std::nullopt;
  Options same = o;
  same.grid_origin_s = flight.t.front();
  const auto again = prepare_flight(*flown, vehicle, same);
  if (!again) return std::nullopt;
  std::vector<char> flying(static_cast<std::size_t>(again->size()), 0);
  for (const Segment& s : again->segments)
    for (int i = s.begin; i < s.end; ++i) flying[static_cast<std::size_t>(i)] = 1;
  const int shift = static_cast<int>(std::lround((flight.t.front() - again->t.front()) * flight.rate_hz));
  Flight out = flight;
  out.instrument = flight.smooth;
  out.segments.clear();
  for (const Segment& s : flight.segments) {
    Segment open{s.begin, s.begin};
    for (int i = s.begin; i <= s.end; ++i) {
      const int k = i + shift;
      const bool known = i < s.end && k >= 0 && k < again->size() && flying[static_cast<std::size_t>(k)] != 0;
      if (known) {
        out.instrument[static_cast<std::size_t>(i)] = again->smooth[static_cast<std::size_t>(k)];
        open.end = i + 1;
        continue;
      }
      if (open.end - open.begin >= static_cast<int>(flight.rate_hz)) out.segments.push_back(open);
      open = {i + 1, i + 1};
    }
  }
  if (out.usable() < 2 * flight.rate_hz) return std::nullopt;
  return out;
}

}  // namespace omniflight::diagnosis
