#include "omniflight_physics/neighbour_track.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::physics {

Status validate(const NeighbourTrack& track) {
  if (track.t_s.empty()) return bad_input("has no sample", "neighbour track");
  if (track.t_s.size() != track.p_WN.size())
    return bad_input("has " + std::to_string(track.t_s.size()) + " times and " +
                         std::to_string(track.p_WN.size()) + " positions",
                     "neighbour track");
  for (std::size_t i = 0; i < track.t_s.size(); ++i) {
    if (!std::isfinite(track.t_s[i]) || !track.p_WN[i].allFinite())
      return bad_input("sample " + std::to_string(i + 1) + " is not finite (s, m)", "neighbour track");
    if (i > 0 && track.t_s[i] <= track.t_s[i - 1])
      return bad_input("time " + std::to_string(track.t_s[i]) + " s of sample " + std::to_string(i + 1) +
                           " is not later than the one before",
                       "neighbour track");
  }
  return {};
}

void set_neighbours(std::span<const NeighbourTrack> tracks, double t, Situation& s) {
  s.neighbour_count = 0;
  for (const NeighbourTrack& track : tracks) {
    if (s.neighbour_count == kMaxNeighbours) return;
    const auto& times = track.t_s;
    Neighbour& n = s.neighbours[static_cast<std::size_t>(s.neighbour_count)];
    if (times.size() == 1) {
      n.p_WN = track.p_WN.front();
    } else {
      if (times.empty() || !(t >= times.front() && t <= times.back())) continue;
      const auto after = std::upper_bound(times.begin(), times.end(), t);
      const auto k = std::min(static_cast<std::size_t>(after - times.begin()), times.size() - 1);
      const double share = (t - times[k - 1]) / (times[k] - times[k - 1]);
      n.p_WN = track.p_WN[k - 1] + share * (track.p_WN[k] - track.p_WN[k - 1]);
    }
    ++s.neighbour_count;
  }
}

}  // namespace omniflight::physics
