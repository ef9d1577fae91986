#include "convex_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace omniflight::planning {
namespace {

constexpr std::uint32_t kObstaclesOfLeaf = 2;  // obstacles at most
constexpr std::size_t kNodesWaiting = 128;     // nodes that wait: the tree is balanced
constexpr int kMostMotionSteps = 48;           // along one motion, of one pair
constexpr double kLeastMotionStep = 1e-4;      // m: a pair that allows less counts as in contact
constexpr double kLongMotion = 0.1;            // m and rad: of longer motions the middle is looked at first
constexpr double kBoxRounding = 1e-9;          // m, of boxes

using PartCoordinates = std::array<double, kMostPoints>;

}  // namespace

/// A part along a motion: x_i(s) = p + s d + fixed_i + cos(s angle) turning_i + sin(s angle) ahead_i.
struct ConvexScene::Sweep {
  std::uint32_t number = 0;
  int count = 0;
  Vec3 p = Vec3::Zero(), d = Vec3::Zero();  // m
  Vec3 axis = Vec3::UnitX();                // of the rotation, unit
  double angle = 0.0;                       // rad
  double arm = 0.0;                         // m, farthest of a point from the axis
  std::array<PartCoordinates, 3> fixed, turning, ahead;

  /// `R`: of the body where the motion begins.
  void take(std::uint32_t part, const PointsView& points, const Mat3& R) {
    number = part, count = points.count, arm = 0.0;
    for (int i = 0; i < count; ++i) {
      const Vec3 x = R * points[i], along = axis.dot(x) * axis, across = x - along,
                 ahead_i = axis.cross(across);
      arm = std::max(arm, across.norm() * (1.0 + 1e-12));
      for (int k = 0; k < 3; ++k) {
        const auto row = static_cast<std::size_t>(k), at = static_cast<std::size_t>(i);
        fixed[row][at] = along[k], turning[row][at] = across[k], ahead[row][at] = ahead_i[k];
      }
    }
  }

  struct Place {
    double s = 0.0;
    std::array<PartCoordinates, 3> at;    // m
    std::array<PartCoordinates, 3> rate;  // m a unit of s
    PointsView points(int count) const { return {at[0].data(), at[1].data(), at[2].data(), count}; }
  };
  void place(double s, Place& out) const {
    const double c = std::cos(s * angle), w = std::sin(s * angle);
    out.s = s;
    for (std::size_t k = 0; k < 3; ++k) {
      const double speed = d[static_cast<int>(k)], origin = p[static_cast<int>(k)] + s * speed;
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        out.at[k][i] = origin + fixed[k][i] + c * turning[k][i] + w * ahead[k][i];
        out.rate[k][i] = speed + angle * (c * ahead[k][i] - w * turning[k][i]);
      }
    }
  }
  /// How far s may grow until a point that has h [m] to go along -n may have gone it: h + s v - s^2 k / 2 is
  /// a lower bound of what is left, with the speed v of the point and the most that its direction turns by.
  double until(const Place& now, const Vec3& n, double from, double rest) const {
    const double k = angle * angle * arm * (n - n.dot(axis) * axis).norm();
    double out = rest;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      const double h = n.x() * now.at[0][i] + n.y() * now.at[1][i] + n.z() * now.at[2][i] - from;
      if (!(h > 0.0)) return 0.0;
      const double v = n.x() * now.rate[0][i] + n.y() * now.rate[1][i] + n.z() * now.rate[2][i];
      if (h + out * (v - 0.5 * k * out) >= 0.0) continue;  // concave: free at both ends is free
      out = std::min(out, 2.0 * h / (std::sqrt(v * v + 2.0 * k * h) - v));
    }
    return out;
  }
};

void ConvexScene::Hulls::add(const std::vector<Vec3>& points) {
  for (const Vec3& p : points) x.push_back(p.x()), y.push_back(p.y()), z.push_back(p.z());
  first.push_back(static_cast<int>(x.size()));
}

ConvexScene::ConvexScene(const MeshParts& body, const MeshParts& obstacles) {
  const auto add_all = [](const MeshParts& from, Hulls& to) {
    for (const ConvexPart& part : from.solids) to.add(part.points);
    for (const Triangle& t : from.triangles) to.add({t.begin(), t.end()});
  };
  add_all(body, body_);
  Hulls given;
  add_all(obstacles, given);
  const auto count = static_cast<std::uint32_t>(given.first.size() - 1);
  std::vector<Box> boxes;
  for (std::uint32_t i = 0; i < count; ++i) boxes.push_back(box_of(given[i]));
  boxes_ = boxes;
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(2 * count);
  split(order, 0, count);
  for (std::uint32_t i = 0; i < count; ++i) {  // as the leaves have them
    boxes_[i] = boxes[order[i]];
    const PointsView points = given[order[i]];
    std::vector<Vec3> moved;
    for (int k = 0; k < points.count; ++k) moved.push_back(points[k]);
    obstacles_.add(moved);
  }
}

void ConvexScene::split(std::vector<std::uint32_t>& order, std::uint32_t first, std::uint32_t count) {
  const std::size_t here = nodes_.size();
  Node node{boxes_[order[first]], first, count, 0};
  Eigen::Array3d low = node.box.low + node.box.high, high = low;  // twice the middles
  for (std::uint32_t i = first; i < first + count; ++i) {
    const Box& box = boxes_[order[i]];
    node.box = {node.box.low.min(box.low), node.box.high.max(box.high)};
    low = low.min(box.low + box.high), high = high.max(box.low + box.high);
  }
  nodes_.push_back(node);
  if (count <= kObstaclesOfLeaf) return;
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::uint32_t half = count / 2;
  std::nth_element(order.begin() + first, order.begin() + first + half, order.begin() + first + count,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double middle_a = boxes_[a].low[axis] + boxes_[a].high[axis];
                     const double middle_b = boxes_[b].low[axis] + boxes_[b].high[axis];
                     return middle_a < middle_b || (middle_a == middle_b && a < b);
                   });
  nodes_[here].count = 0;
  split(order, first, half);
  nodes_[here].second = static_cast<std::uint32_t>(nodes_.size());
  split(order, first + half, count - half);
}

template <class Visit>
bool ConvexScene::for_near(const Box& box, const Visit& visit) const {
  const auto touch = [&box](const Box& other) {
    return box.low[0] <= other.high[0] && other.low[0] <= box.high[0] && box.low[1] <= other.high[1] &&
           other.low[1] <= box.high[1] && box.low[2] <= other.high[2] && other.low[2] <= box.high[2];
  };
  std::uint32_t stack[kNodesWaiting];
  std::size_t waiting = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const std::uint32_t at = stack[--waiting];
    const Node& node = nodes_[at];
    if (!touch(node.box)) continue;
    if (node.count == 0) {
      stack[waiting++] = node.second;
      stack[waiting++] = at + 1;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      if (touch(boxes_[i]) && !visit(i)) return false;
  }
  return true;
}

SeparationMemory::Entry& ConvexScene::recall(std::uint32_t part, std::uint32_t obstacle, const Box& box,
                                             SeparationMemory& memory) const {
  auto& entry = memory.entries[(part * 61u + obstacle) % memory.entries.size()];
  if (entry.part == part && entry.obstacle == obstacle) return entry;
  entry.part = part, entry.obstacle = obstacle;
  // the way from box to box, or between their middles where they overlap
  const Box& other = boxes_[obstacle];
  Vec3 way = ((box.low - other.high).max(0.0) - (other.low - box.high).max(0.0)).matrix();
  if (way.isZero(0.0)) way = (box.low + box.high - other.low - other.high).matrix();
  const double length = way.norm();
  entry.axis = length > 0.0 ? Vec3(way / length) : Vec3(Vec3::UnitX());
  return entry;
}

ConvexScene::Box ConvexScene::box_of(const PointsView& points) {
  Box out{points[0].array(), points[0].array()};
  for (int i = 1; i < points.count; ++i)
    out = {out.low.min(points[i].array()), out.high.max(points[i].array())};
  return out;
}

bool ConvexScene::apart(std::uint32_t number, const PointsView& part, const Box& box, std::uint32_t obstacle,
                        double least, SeparationMemory& memory) const {
  Vec3& axis = recall(number, obstacle, box, memory).axis;
  return separation(part, obstacles_[obstacle], axis, least, std::nextafter(least, HUGE_VAL)) > least;
}

bool ConvexScene::free(const Pose& pose, double least, SeparationMemory& memory) const {
  ++memory.looks;
  const Mat3 R = pose.q_WB.toRotationMatrix();
  std::array<PartCoordinates, 3> at;
  const auto placed = [&](std::uint32_t number) {
    const PointsView part = body_[number];
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < part.count; ++i)
        at[static_cast<std::size_t>(k)][static_cast<std::size_t>(i)] =
            pose.p_WB[k] + R(k, 0) * part.x[i] + R(k, 1) * part.y[i] + R(k, 2) * part.z[i];
    return PointsView{at[0].data(), at[1].data(), at[2].data(), part.count};
  };
  if (memory.hit_part != SeparationMemory::kNone) {  // what was in the way last is likely to be so again
    const PointsView part = placed(memory.hit_part);
    if (!apart(memory.hit_part, part, box_of(part), memory.hit_obstacle, least, memory)) return false;
  }
  const auto count = static_cast<std::uint32_t>(parts());
  for (std::uint32_t number = 0; number < count; ++number) {
    const PointsView part = placed(number);
    const Box box = box_of(part);
    const bool clear = for_near({box.low - least, box.high + least}, [&](std::uint32_t obstacle) {
      if (apart(number, part, box, obstacle, least, memory)) return true;
      memory.hit_part = number, memory.hit_obstacle = obstacle;
      return false;
    });
    if (!clear) return false;
  }
  return true;
}

bool ConvexScene::stays_apart(const Sweep& sweep, std::uint32_t obstacle, double least,
                              SeparationMemory& memory) const {
  const PointsView other = obstacles_[obstacle];
  const double most = sweep.d.norm() + sweep.angle * sweep.arm;  // m, that a point can move
  Sweep::Place now;
  sweep.place(0.0, now);
  Vec3& axis = recall(sweep.number, obstacle, box_of(now.points(sweep.count)), memory).axis;
  // the axis of last time first: it often tells the whole motion
  double step = sweep.until(now, axis, reach_along(other, axis) + least, 1.0);
  for (int i = 0; now.s + step < 1.0; ++i) {
    if (i == kMostMotionSteps || (i > 1 && step * most < kLeastMotionStep)) return false;
    if (i > 0) sweep.place(now.s + step, now);
    ++memory.looks;
    const double enough = most * (1.0 - now.s) + 2.0 * least;
    if (separation(now.points(sweep.count), other, axis, least, enough) <= least) return false;
    step = sweep.until(now, axis, reach_along(other, axis) + least, 1.0 - now.s);
  }
  return true;
}

bool ConvexScene::motion_free(const Pose& a, const Pose& b, double least, SeparationMemory& memory) const {
  // most motions that are not free are told by a pose or two
  if (!free(b, least, memory)) return false;
  Quat turn = a.q_WB.conjugate() * b.q_WB;
  if (a.q_WB.dot(b.q_WB) < 0.0) turn.coeffs() *= -1.0;  // the sign by which slerp takes the shorter way
  const double sine = turn.vec().norm();
  const Mat3 R = a.q_WB.toRotationMatrix();
  Sweep sweep;
  sweep.p = a.p_WB, sweep.d = b.p_WB - a.p_WB;
  sweep.angle = 2.0 * std::atan2(sine, turn.w());
  if (sine > 0.0) sweep.axis = R * (turn.vec() / sine);
  if (sweep.d.norm() + sweep.angle > kLongMotion && !free(interpolate(a, b, 0.5), least, memory))
    return false;
  const auto count = static_cast<std::uint32_t>(parts());
  for (std::uint32_t number = 0; number < count; ++number) {
    sweep.take(number, body_[number], R);
    // about its box half way, the box of the whole motion
    Sweep::Place half;
    sweep.place(0.5, half);
    const Box box = box_of(half.points(sweep.count));
    Eigen::Array3d beyond = 0.5 * sweep.d.array().abs() + least + kBoxRounding;
    for (int k = 0; k < 3; ++k)
      beyond[k] +=
          0.5 * sweep.angle * sweep.arm * std::sqrt(std::max(0.0, 1.0 - sweep.axis[k] * sweep.axis[k]));
    if (!for_near({box.low - beyond, box.high + beyond},
                  [&](std::uint32_t obstacle) { return stays_apart(sweep, obstacle, least, memory); }))
      return false;
  }
  return true;
}

}  // namespace omniflight::planning
