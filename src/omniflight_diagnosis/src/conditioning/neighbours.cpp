#include "neighbours.hpp"

#include <algorithm>

namespace omniflight::diagnosis {
namespace {

bool names_neighbour(const std::string& signal) { return signal.rfind("neighbour", 0) == 0; }

}  // namespace

std::vector<physics::NeighbourTrack> neighbours_of(const recording::Recording& recording, const Options& o) {
  std::vector<physics::NeighbourTrack> out = o.neighbours;
  for (const auto& [name, signal] : recording.signals) {
    if (!names_neighbour(name) || signal.width() != 3) continue;
    physics::NeighbourTrack track;
    track.t_s = signal.t_s;
    for (Eigen::Index i = 0; i < signal.size(); ++i) track.p_WN.push_back(signal.values.row(i).transpose());
    if (physics::validate(track)) out.push_back(std::move(track));
  }
  return out;
}

bool has_neighbour(const Flight& f) {
  return std::any_of(f.signals.begin(), f.signals.end(), names_neighbour);
}

}  // namespace omniflight::diagnosis
