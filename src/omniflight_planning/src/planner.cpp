#include "omniflight_planning/planner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "connect_search.hpp"
#include "convex_scene.hpp"
#include "gap_path.hpp"
#include "ompl_search.hpp"
#include "portfolio.hpp"
#include "text.hpp"

namespace omniflight::planning {
namespace {

constexpr std::size_t kCellsBetweenLooks = 4096;  // about 0.2 ms of flood fill

constexpr std::size_t kFirstSamples = 300;            // before the gaps are looked at
constexpr std::size_t kFirstSamplesOfParts = 30'000;  // their poses cost less, and their gaps are longer
constexpr std::size_t kFirstSamplesOfMany = 4'000;  // of bodies of many parts: the gaps cost relatively less
constexpr int kSearches = 4;                        // where the first one is quick
constexpr std::uint64_t kNextSearch =
    2'971'215'073;                          // between their seeds: far from missions, restarts, threads
constexpr std::size_t kMoreSamples = 2000;  // before a gap counts as too narrow
constexpr double kTooNarrow = 0.02;         // m

std::string place(const Vec3& p) { return text("(%.2f, %.2f, %.2f) m", p.x(), p.y(), p.z()); }

tl::unexpected<PathProblem> problem(PathFailure failure, std::string message) {
  return tl::unexpected<PathProblem>(PathProblem{failure, std::move(message)});
}

}  // namespace

const char* to_string(PathFailure failure) {
  switch (failure) {
    case PathFailure::not_finite:
      return "not_finite";
    case PathFailure::outside_map:
      return "outside_map";
    case PathFailure::start_occupied:
      return "start_occupied";
    case PathFailure::goal_occupied:
      return "goal_occupied";
    case PathFailure::start_unhoverable:
      return "start_unhoverable";
    case PathFailure::goal_unhoverable:
      return "goal_unhoverable";
    case PathFailure::tether_too_short:
      return "tether_too_short";
    case PathFailure::tether_blocked:
      return "tether_blocked";
    case PathFailure::tether_blocks_way:
      return "tether_blocks_way";
    case PathFailure::gap_too_narrow:
      return "gap_too_narrow";
    case PathFailure::no_path_in_time:
      return "no_path_in_time";
    case PathFailure::proven_impossible:
      return "proven_impossible";
  }
  return "unknown";
}

tl::expected<void, PathProblem> check_end(const StateCheck& check, const Pose& pose, bool is_start,
                                          const PathOptions& options) {
  const std::string what = is_start ? "the start" : "the goal";
  if (!is_finite(pose))
    return problem(PathFailure::not_finite, what + " is not finite or its quaternion is not a unit one");
  if (!check.map().contains(pose.p_WB))
    return problem(PathFailure::outside_map,
                   what + " " + place(pose.p_WB) + " lies outside the map, which reaches from " +
                       place(check.map().lower()) + " to " + place(check.map().upper()));
  if (const auto conflict = check.tether_conflict(pose))
    return problem(conflict->too_short ? PathFailure::tether_too_short : PathFailure::tether_blocked,
                   what + " " + place(pose.p_WB) + ": " + conflict->words);
  if (!check.valid(pose) && check.hoverable(pose.q_WB)) {
    const Clearance c = check.clearance(pose);
    std::string solid = options.name_of ? options.name_of(c.p_W) : std::string();
    if (!solid.empty()) solid = " of '" + solid + "'";
    const std::string how = c.distance < 0.0 ? text("%.3f m inside the voxels", -c.distance)
                                             : text("%.3f m from the voxels", c.distance);
    return problem(is_start ? PathFailure::start_occupied : PathFailure::goal_occupied,
                   what + " " + place(pose.p_WB) + " puts the vehicle " + how + solid + " near " +
                       place(c.p_W) + text(", and %.3f m of clearance are asked for", check.margin()));
  }
  if (!check.hoverable(pose.q_WB)) {
    const Vec3 rpy = roll_pitch_yaw(pose.q_WB);
    return problem(
        is_start ? PathFailure::start_unhoverable : PathFailure::goal_unhoverable,
        what + text(" attitude (roll %.1f, pitch %.1f, yaw %.1f deg) cannot be hovered with the rotors "
                    "tilted by %.1f deg",
                    to_degrees(rpy.x()), to_degrees(rpy.y()), to_degrees(rpy.z()),
                    to_degrees(check.alpha())));
  }
  return {};
}

bool proven_disconnected(const StateCheck& check, const Vec3& a, const Vec3& b, const Deadline& deadline) {
  const DistanceMap& map = check.map();
  // A cell may hold a free place of the ball unless its centre is nearer to an obstacle than the ball's
  // radius less half the cell's diagonal.
  const double needed =
      check.spheres().inscribed_radius + check.margin() - 0.5 * std::sqrt(3.0) * map.resolution();
  // nothing of a mesh is solid, and voxels stand out of the triangles that they hold
  if (check.space() || !map.contains(a) || !map.contains(b) || needed >= map.max_distance()) return false;
  const auto [nx, ny, nz] = map.size();
  const auto index = [nx = nx, ny = ny](int x, int y, int z) {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(ny) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(nx) +
           static_cast<std::size_t>(x);
  };
  std::vector<bool> seen(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) *
                         static_cast<std::size_t>(nz));
  const auto from = map.voxel_of(a), to = map.voxel_of(b);
  std::vector<std::array<int, 3>> stack{from};
  seen[index(from[0], from[1], from[2])] = true;
  for (std::size_t cells = 0; !stack.empty(); ++cells) {
    if (cells % kCellsBetweenLooks == 0 && deadline.passed()) return false;
    const auto cell = stack.back();
    stack.pop_back();
    if (cell == to) return false;
    // a way through an edge or corner of cells passes all cells that share it, so faces are enough
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        auto next = cell;
        next[axis] += step;
        if (next[axis] < 0 || next[axis] >= map.size()[axis]) continue;
        const std::size_t i = index(next[0], next[1], next[2]);
        if (seen[i]) continue;
        seen[i] = true;
        // an occupied voxel (distance 0) never lets the origin through, however large the voxels are
        const double d = map.voxel_distance(next[0], next[1], next[2]);
        if (next == to || (d > 0.0 && d >= needed)) stack.push_back(next);
      }
  }
  return true;
}

namespace {

/// The gap that no pose was found to fit, for messages; empty where there is none.
std::string bottleneck(const GapPath& gaps, const StateCheck& check, const PathOptions& options) {
  if (!gaps.narrowest) return {};
  const Gap& gap = *gaps.narrowest;
  std::string solid = options.name_of ? options.name_of(gap.p_W) : std::string();
  if (!solid.empty()) solid = " beside '" + solid + "'";
  std::string out =
      text("; the widest way narrows to %.2f m at ", 2.0 * gap.distance) + place(gap.p_W) + solid;
  if (gaps.impossible) return out;
  if (gaps.unholdable)
    return out + text(", which fits the vehicle at attitudes that the rotors cannot hold at alpha %.1f deg",
                      to_degrees(check.alpha()));
  return out + (gaps.lack > 0.0
                    ? text(", where the best attitude found lacks %.3f m of the %.3f m of clearance",
                           gaps.lack, check.margin())
                    : std::string(", where no motion through was found"));
}

tl::unexpected<PathProblem> disconnected(const StateCheck& check, const Pose& start, const Pose& goal,
                                         const std::string& where) {
  return problem(PathFailure::proven_impossible,
                 "no path exists from " + place(start.p_WB) + " to " + place(goal.p_WB) +
                     text(": not even the solid ball of %.3f m inside the vehicle can get there with "
                          "%.3f m of clearance",
                          check.spheres().inscribed_radius, check.margin()) +
                     where);
}

/// Shorter, and checked a second time: OMPL's word is not taken for it.
PathResult<std::vector<Pose>> finished(const StateCheck& check, const Pose& start, const Pose& goal,
                                       std::vector<Pose> path, const PathOptions& options) {
  auto shorter = shorten(check, std::move(path), options.seed, options.shortcuts, options.deadline);
  shorter.front() = start;
  shorter.back() = goal;
  for (std::size_t i = 0; i + 1 < shorter.size(); ++i)
    if (!check.motion_valid(shorter[i], shorter[i + 1]))
      return problem(PathFailure::no_path_in_time, "the path that was found did not pass its second check");
  return shorter;
}

/// Of a path that was found at once and those of a few more searches, the one that is the shortest without
/// its needless vertices. Round the frame that makes the path 6 % shorter once it is shortened, for half the
/// time more.
std::vector<Pose> best_of_searches(const StateCheck& check, const Pose& start, const Pose& goal,
                                   std::vector<Pose> first, const PathOptions& options) {
  std::vector<Pose> best = shorten(check, std::move(first), options.seed, 0, options.deadline);
  double least = path_length(best);
  for (int k = 1; k < kSearches && best.size() > 2; ++k) {
    const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(k) * kNextSearch;
    auto other = ConnectSearch(check, start, goal, seed).solve(options.deadline, kFirstSamples);
    if (!other) continue;
    auto path = shorten(check, std::move(*other), seed, 0, options.deadline);
    if (const double length = path_length(path); length < least) least = length, best = std::move(path);
  }
  return best;
}

/// By one planner alone, to the end of its time where it improves its path.
PathResult<std::vector<Pose>> find_path_by_name(const StateCheck& check, const Pose& start, const Pose& goal,
                                                const PathOptions& options) {
  OmplSearch search(options.planner, check, start, goal, options.seed);
  const Deadline end = options.deadline.within(options.budget_s);
  if (auto path = search.solve(end)) return finished(check, start, goal, std::move(*path), options);
  if (!options.brief && proven_disconnected(check, start.p_WB, goal.p_WB, options.deadline))
    return disconnected(check, start, goal, "");
  return problem(PathFailure::no_path_in_time, options.planner + " found no path from " + place(start.p_WB) +
                                                   " to " + place(goal.p_WB) +
                                                   text(" within %.0f ms", 1e3 * options.budget_s));
}

}  // namespace

PathResult<std::vector<Pose>> find_path(const StateCheck& check, const Pose& start, const Pose& goal,
                                        const PathOptions& options) {
  for (const bool is_start : {true, false})
    if (auto ok = check_end(check, is_start ? start : goal, is_start, options); !ok)
      return tl::unexpected<PathProblem>(ok.error());
  if (check.motion_valid(start, goal)) return std::vector<Pose>{start, goal};
  if (!options.planner.empty()) return find_path_by_name(check, start, goal, options);

  PathOptions part = options;
  part.deadline = options.deadline.within(options.budget_s);
  Portfolio rrt(check, start, goal, options);
  const auto parts = check.space() ? check.space()->parts : nullptr;
  const std::size_t first_samples = !parts                                    ? kFirstSamples
                                    : parts->parts() > ConvexScene::kFewParts ? kFirstSamplesOfMany
                                                                              : kFirstSamplesOfParts;
  auto path = rrt.solve(part.deadline, first_samples);
  if (path && !check.space()) {
    if (options.shortcuts <= 0) return *path;
    path = best_of_searches(check, start, goal, std::move(*path), part);
  }
  GapPath gaps;
  if (!path) {
    rrt.meanwhile(part.deadline, [&] { gaps = path_through_gaps(check, start, goal, part); });
    if (!gaps.poses.empty()) path = gaps.poses;
  }
  const std::string where = path ? std::string() : bottleneck(gaps, check, options);
  if (gaps.impossible) return disconnected(check, start, goal, where);
  if (!path && !options.brief) path = rrt.solve(part.deadline, kMoreSamples);
  if (!path && !check.space() && gaps.exhausted && gaps.lack > kTooNarrow && !part.deadline.passed())
    return problem(PathFailure::gap_too_narrow,
                   "no path was found from " + place(start.p_WB) + " to " + place(goal.p_WB) + where);
  if (!path && !options.brief) {
    if (proven_disconnected(check, start.p_WB, goal.p_WB, part.deadline))
      return disconnected(check, start, goal, where);
    path = rrt.solve(part.deadline, std::numeric_limits<std::size_t>::max());
  }
  if (!path)
    return problem(PathFailure::no_path_in_time, "no path was found from " + place(start.p_WB) + " to " +
                                                     place(goal.p_WB) +
                                                     text(" within %.0f ms", 1e3 * options.budget_s) + where);
  return finished(check, start, goal, std::move(*path), options);
}

std::vector<Pose> find_shorter_path(const StateCheck& check, std::vector<Pose> path,
                                    const PathOptions& options) {
  constexpr std::uint64_t kNextSeed = 1'000'003;  // missions count theirs from 1
  const Deadline end = options.deadline.within(options.budget_s);
  PathOptions again = options;
  again.brief = true;
  again.deadline = end;
  double best = path_length(path);
  while (path.size() > 2 && !end.passed()) {
    again.seed += kNextSeed;
    again.budget_s = end.left();
    auto found = find_path(check, path.front(), path.back(), again);
    if (!found) continue;
    if (const double length = path_length(*found); length < best) best = length, path = std::move(*found);
  }
  return path;
}

}  // namespace omniflight::planning
