#include "gap_path.hpp"

#include <algorithm>
#include <cmath>

#include "connect_search.hpp"

namespace omniflight::planning {
namespace {

constexpr int kWays = 16;                // that are tried, each without the gaps that nothing fitted before
constexpr double kClosed = 0.6;          // m, how far a gap reaches that nothing was found to fit
constexpr int kSearchIterations = 3000;  // of the search from one gap to the next
constexpr double kBeyondWide = 0.02;     // m

bool connect(const StateCheck& check, std::vector<Pose>& path, const Pose& to, const PathOptions& options) {
  if (check.motion_valid(path.back(), to)) {
    path.push_back(to);
    return true;
  }
  ConnectSearch rrt(check, path.back(), to, options.seed);
  const auto part = rrt.solve(options.deadline, kSearchIterations);
  if (!part) return false;
  path.insert(path.end(), part->begin() + 1, part->end());
  return true;
}

}  // namespace

GapPath path_through_gaps(const StateCheck& check, const Pose& start, const Pose& goal,
                          const PathOptions& options) {
  GapPath out;
  const DistanceMap& map = check.map();
  Passages passages(map);
  if (const auto& space = check.space()) passages.keep_to(space->lower, space->upper);
  const double wide = check.spheres().bounding_radius + check.margin() + kBeyondWide;
  const double ball =
      check.spheres().inscribed_radius + check.margin() - 0.5 * std::sqrt(3.0) * map.resolution();
  // voxels stand out of the triangles that they hold, and nothing of a mesh is solid: no proof
  if (!check.space() && ball < map.max_distance() &&
      !passages.may_pass(start.p_WB, goal.p_WB, ball, options.deadline)) {
    out.impossible = true;
    if (const auto way = passages.widest_way(start.p_WB, goal.p_WB, 0.0, wide, options.deadline))
      for (const Gap& gap : gaps_of(*way, wide))
        if (!out.narrowest || gap.distance < out.narrowest->distance) out.narrowest = gap;
    return out;
  }
  const std::vector<Quat> attitudes{start.q_WB, goal.q_WB, start.q_WB.slerp(0.5, goal.q_WB).normalized()};
  Random random(options.seed, "gaps");
  for (int i = 0; i < kWays && !options.deadline.passed(); ++i) {
    const auto way = passages.widest_way(start.p_WB, goal.p_WB, ball, wide, options.deadline);
    if (!way) {
      out.exhausted = !options.deadline.passed() && out.narrowest.has_value();
      return out;
    }
    std::vector<Pose> path{start};
    bool through = true;
    const std::vector<Gap> gaps = gaps_of(*way, wide);
    for (std::size_t k = 0; k < gaps.size() && through; ++k) {
      const Crossing crossing = cross(check, gaps[k], attitudes, random, options.deadline);
      through = !crossing.poses.empty();
      if (through) {
        if (!connect(check, path, crossing.poses.front(), options)) return out;
        path.insert(path.end(), crossing.poses.begin() + 1, crossing.poses.end());
        continue;
      }
      if (options.deadline.passed()) return out;
      if (!out.narrowest || crossing.lack < out.lack) {
        out.narrowest = gaps[k];
        out.lack = crossing.lack;
        out.unholdable = crossing.unholdable;
      }
      passages.close(gaps[k].p_W, kClosed, gaps[k].distance + 0.5 * map.resolution());
    }
    if (!through) continue;
    if (connect(check, path, goal, options)) out.poses = std::move(path);
    return out;
  }
  return out;
}

}  // namespace omniflight::planning
