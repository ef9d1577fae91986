#include "connect_search.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

/// m, of one motion, by pose_distance(). From 0.2 to 0.3 the problems of `bench_planner rigid_body` take the
/// same time within a factor of two; with 1 the windows take seven to ten times as many poses.
constexpr double kBodyRange = 0.25;
constexpr double kVehicleRange = 1.0;
constexpr double kShareBetween = 0.75;            // of the attitudes of vehicles
constexpr std::size_t kSamplesBetweenLooks = 16;  // at the clock

}  // namespace

void ConnectSearch::Tree::add(const Pose& pose, std::size_t parent) {
  poses.push_back(pose);
  parents.push_back(parent);
  index.add(pose);
}

ConnectSearch::ConnectSearch(const StateCheck& check, const Pose& start, const Pose& goal, std::uint64_t seed)
    : check_(check),
      parts_(check.space() && check.space()->parts ? &*check.space() : nullptr),
      start_(start),
      goal_(goal),
      lower_(check.space() ? check.space()->lower : check.map().lower()),
      upper_(check.space() ? check.space()->upper : check.map().upper()),
      range_(check.space() ? kBodyRange : kVehicleRange),
      random_(seed, "rrt"),
      memory_(parts_ ? parts_->parts->memory() : SeparationMemory()) {
  trees_[0].add(start, 0);
  trees_[1].add(goal, 0);
}

Pose ConnectSearch::sample() {
  Pose out;
  for (int k = 0; k < 3; ++k) out.p_WB[k] = random_.uniform(lower_[k], upper_[k]);
  if (!check_.space() && random_.uniform() < kShareBetween) {
    out.q_WB = start_.q_WB.slerp(random_.uniform(), goal_.q_WB).normalized();
    return out;
  }
  do {
    for (int k = 0; k < 4; ++k) out.q_WB.coeffs()[k] = random_.normal();
  } while (out.q_WB.norm() < 1e-6);
  out.q_WB.normalize();
  return out;
}

bool ConnectSearch::motion_free(const Tree& tree, const Pose& from, const Pose& to) {
  if (parts_) return parts_->parts->motion_free(from, to, StateCheck::kLeastRoom, memory_);
  if (&tree == &trees_[0] || check_.space()) return check_.motion_valid(from, to);
  // the way that the path will go, of which the new pose is the beginning: motion_valid() looks at the end
  // first
  return check_.valid(to) && check_.motion_valid(to, from);
}

ConnectSearch::Extension ConnectSearch::extend(Tree& tree, std::size_t near, const Pose& to) {
  const Pose& from = tree.poses[near];
  const double distance = pose_distance(from, to);
  const bool far = distance > range_;
  const Pose aim = far ? interpolate(from, to, range_ / distance) : to;
  if (!motion_free(tree, from, aim)) return Extension::trapped;
  tree.add(aim, near);
  return far ? Extension::advanced : Extension::reached;
}

std::optional<std::vector<Pose>> ConnectSearch::solve(const Deadline& end, std::size_t samples) {
  std::optional<std::vector<Pose>> found;
  const std::uint64_t looks = memory_.looks;
  for (std::size_t i = 0; i < samples && !found; ++i) {
    if (i % kSamplesBetweenLooks == 0 && end.passed()) break;
    Tree &mine = trees_[turn_], &other = trees_[1 - turn_];
    turn_ = 1 - turn_;
    const Pose to = sample();
    if (extend(mine, mine.index.near(to), to) == Extension::trapped) continue;
    const Pose aim = mine.poses.back();
    Extension last = extend(other, other.index.near(aim), aim);
    while (last == Extension::advanced) last = extend(other, other.poses.size() - 1, aim);
    if (last == Extension::reached) found = path();
  }
  if (parts_ && parts_->looks) parts_->looks->fetch_add(memory_.looks - looks, std::memory_order_relaxed);
  return found;
}

std::vector<Pose> ConnectSearch::path() const {
  std::vector<Pose> out;
  const auto climb = [&out](const Tree& tree, std::size_t at) {
    for (out.push_back(tree.poses[at]); at != 0; out.push_back(tree.poses[at])) at = tree.parents[at];
  };
  climb(trees_[0], trees_[0].poses.size() - 1);
  std::reverse(out.begin(), out.end());
  out.pop_back();  // the pose that both trees have
  climb(trees_[1], trees_[1].poses.size() - 1);
  return out;
}

}  // namespace omniflight::planning
