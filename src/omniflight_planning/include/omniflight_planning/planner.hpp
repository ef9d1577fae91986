// From pose to pose: a straight motion when it is free, else RRT-Connect in SE(3) and shortcuts.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "omniflight_planning/deadline.hpp"
#include "omniflight_planning/state_check.hpp"

namespace omniflight::planning {

/// Why there is no path.
enum class PathFailure {
  not_finite,
  outside_map,
  start_occupied,
  goal_occupied,
  start_unhoverable,
  goal_unhoverable,
  tether_too_short,
  tether_blocked,     ///< at a waypoint
  tether_blocks_way,  ///< the vehicle alone has a path
  gap_too_narrow,
  no_path_in_time,
  proven_impossible,
};
const char* to_string(PathFailure failure);

struct PathProblem {
  PathFailure failure = PathFailure::no_path_in_time;
  std::string message;  ///< one sentence with values and units
};

inline constexpr int kMostPlannerThreads = 64;

struct PathOptions {
  std::uint64_t seed = 1;
  double budget_s = 1.0;   ///< s of wall time; RRTConnect stops at most one motion check later
  Deadline deadline = {};  ///< of the whole plan: nothing is shortened nor proven after it
  /// Attempts; a number and not a time, so that results repeat. 0: the first path as it is found.
  int shortcuts = 300;
  bool brief = false;  ///< gives up early, where another search with less margin will follow
  /// One of planner_names(), see check_planner(), alone instead of what find_path() tries one after the
  /// other; its result is checked and shortened likewise. Only rrtconnect repeats for a seed.
  std::string planner = {};
  /// Searches of RRTConnect side by side, at most kMostPlannerThreads; 1: everything in the caller's thread.
  /// The path depends on seed and number of threads, not on which of them is quicker (while the budget
  /// suffices).
  int threads = 1;
  /// Name of the solid nearest to a point, for messages; may be empty.
  std::function<std::string(const Vec3& p_W)> name_of = {};
};

template <class T>
using PathResult = tl::expected<T, PathProblem>;

/// OMPL's planners that PathOptions::planner may name.
std::vector<std::string> planner_names();
/// Refuses a name that none of them has; an empty one is none.
Status check_planner(const std::string& name);

/// Checks one pose before any planner sees it; `what` is "start" or "goal".
tl::expected<void, PathProblem> check_end(const StateCheck& check, const Pose& pose, bool is_start,
                                          const PathOptions& options);

/// Poses from start to goal, both included; every motion between neighbours has passed motion_valid. The same
/// seed gives the same path whenever the budget suffices. Tried one after the other: the straight motion,
/// RRTConnect for a few samples, the gaps of the widest way (gap.hpp), RRTConnect to the end of the budget.
/// A vehicle's path that the few samples give is the best of four such searches.
/// Where every way leads through a gap that lacks more than 2 cm for the best pose found in it, the answer
/// comes early: gap_too_narrow. Every answer without a path names the gap, if there is one.
PathResult<std::vector<Pose>> find_path(const StateCheck& check, const Pose& start, const Pose& goal,
                                        const PathOptions& options);

/// The shortest path (path_length) of `path` and those that find_path() finds with further seeds in
/// options.budget_s [s], all of which is used unless `path` is the straight motion. How many there are in
/// that time depends on the machine, so that results need not repeat.
std::vector<Pose> find_shorter_path(const StateCheck& check, std::vector<Pose> path,
                                    const PathOptions& options);

/// True when no attitude whatever lets the body origin get from a to b: a flood fill of the ball that is
/// solid vehicle at every attitude (inscribed_radius, plus the margin) does not connect them. Never true by
/// mistake, and never after the deadline.
bool proven_disconnected(const StateCheck& check, const Vec3& a, const Vec3& b,
                         const Deadline& deadline = {});

/// Fewer and shorter motions: replaces stretches by straight motions, in position, in attitude or in both.
/// Stops at the deadline with what it has.
std::vector<Pose> shorten(const StateCheck& check, std::vector<Pose> path, std::uint64_t seed, int attempts,
                          const Deadline& deadline = {});

/// Length [m] of a path: way of the origin plus 0.3 m a radian.
double path_length(const std::vector<Pose>& path);

}  // namespace omniflight::planning
