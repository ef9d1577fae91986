#include "convex_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace omniflight::planning {
namespace {

constexpr int kMostMotionSteps = 48;       // along one motion, of one pair
constexpr double kLeastMotionStep = 1e-4;  // m: a pair that allows less counts as in contact
constexpr double kLongMotion = 0.1;        // m and rad: of longer motions the middle is looked at first
constexpr double kBoxRounding = 1e-9;      // m, of boxes
constexpr std::size_t kEntriesOfManyParts = 4096;
/// Motions of bodies of many parts are followed piece by piece: along a long one, boxes tell few pairs apart.
constexpr double kLongestPiece = 0.06;  // m, that a point moves
constexpr int kMostPieces = 16;

using PartCoordinates = std::array<double, kMostPoints>;

}  // namespace

/// A part along a motion: x_i(s) = p + s d + fixed_i + cos(s angle) turning_i + sin(s angle) ahead_i.
struct ConvexScene::Sweep {
  std::uint32_t number = SeparationMemory::kNone;
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

/// Where the body is, and how far it may be moved and turned from there.
struct ConvexScene::Placement {
  Vec3 p;                                                 // m
  Mat3 R, size;                                           // and the sizes of its entries
  Vec3 beyond_W = Vec3::Zero(), beyond_B = Vec3::Zero();  // m, along the axes of world and body
  double turn = 0.0;                                      // rad, about axis_B
  Vec3 axis_B = Vec3::UnitX();                            // unit
  Vec3 across_W = Vec3::Zero(), across_B = Vec3::Zero();  // sines of the axes' angles to it

  Placement(const Pose& pose, double least) : p(pose.p_WB), R(pose.q_WB.toRotationMatrix()) {
    size = R.cwiseAbs();
    beyond_W = beyond_B = Vec3::Constant(least + kBoxRounding);
  }
  /// The same and every pose that is reached from there by up to `share` of a motion, each way.
  void widen(const Sweep& sweep, double share) {
    turn = share * sweep.angle;
    axis_B = R.transpose() * sweep.axis;
    beyond_W += share * sweep.d.cwiseAbs();
    beyond_B += share * (R.transpose() * sweep.d).cwiseAbs();
    const auto sine = [](double cosine) { return std::sqrt(std::max(0.0, 1.0 - cosine * cosine)); };
    across_W = sweep.axis.unaryExpr(sine);
    across_B = axis_B.unaryExpr(sine);
  }
  /// Whether an axis of world or body separates the boxes, whatever the motion (Gottschalk, Lin and Manocha
  /// 1996, without the products of edges).
  bool tells_apart(const Cell& b, const Cell& o) const {
    const Vec3 way = p + R * b.middle - o.middle;
    const double arm = turn > 0.0 ? turn * (axis_B.cross(b.middle).norm() + b.radius) : 0.0;
    const Vec3 reach_W = o.half + size * b.half + beyond_W + arm * across_W;
    if ((way.cwiseAbs() - reach_W).maxCoeff() > 0.0) return true;
    const Vec3 reach_B = b.half + size.transpose() * o.half + beyond_B + arm * across_B;
    return ((R.transpose() * way).cwiseAbs() - reach_B).maxCoeff() > 0.0;
  }
};

void ConvexScene::Hulls::add(const std::vector<Vec3>& points) {
  for (const Vec3& p : points) x.push_back(p.x()), y.push_back(p.y()), z.push_back(p.z());
  first.push_back(static_cast<int>(x.size()));
}

ConvexScene::Cell::Cell(const BoxTree::Node& node)
    : middle(0.5 * (node.box.low + node.box.high)),
      half(0.5 * (node.box.high - node.box.low)),
      radius(half.norm()),
      first(node.first),
      count(node.count),
      second(node.second) {}

ConvexScene::ConvexScene(const MeshParts& body, const MeshParts& obstacles) {
  const auto take = [](const MeshParts& from, Hulls& to, std::vector<Cell>& cells) {
    std::vector<std::vector<Vec3>> given;
    for (const ConvexPart& part : from.solids) given.push_back(part.points);
    for (const Triangle& t : from.triangles) given.push_back({t.begin(), t.end()});
    std::vector<AlignedBox> boxes;
    for (const auto& points : given) {
      AlignedBox box{points[0].array(), points[0].array()};
      for (const Vec3& p : points) box = {box.low.min(p.array()), box.high.max(p.array())};
      boxes.push_back(box);
    }
    const BoxTree tree(boxes, 1);
    for (const BoxTree::Node& node : tree.nodes) cells.emplace_back(node);
    for (const auto i : tree.order) to.add(given[i]);
  };
  take(body, body_, body_tree_);
  take(obstacles, obstacles_, world_tree_);
  for (std::size_t i = 0; i + 1 < obstacles_.first.size(); ++i) boxes_.push_back(box_of(obstacles_[i]));
}

SeparationMemory ConvexScene::memory() const {
  SeparationMemory out;
  if (parts() > kFewParts) out.entries.resize(kEntriesOfManyParts);
  return out;
}

template <class Visit>
bool ConvexScene::for_near_pairs(const Placement& at, const Visit& visit) const {
  struct Pair {
    std::uint32_t b, o;
  };
  Pair stack[BoxTree::kMostWaiting];
  std::size_t waiting = 0;
  stack[waiting++] = {0, 0};
  while (waiting > 0) {
    const auto [b, o] = stack[--waiting];
    const Cell &body = body_tree_[b], &obstacle = world_tree_[o];
    if (at.tells_apart(body, obstacle)) continue;
    if (body.count > 0 && obstacle.count > 0) {
      if (!visit(body.first, obstacle.first)) return false;
    } else if (obstacle.count > 0 || (body.count == 0 && body.radius > obstacle.radius)) {
      stack[waiting++] = {body.second, o};
      stack[waiting++] = {b + 1, o};
    } else {
      stack[waiting++] = {b, obstacle.second};
      stack[waiting++] = {b, o + 1};
    }
  }
  return true;
}

SeparationMemory::Entry& ConvexScene::recall(std::uint32_t number, const PointsView& part,
                                             std::uint32_t obstacle, SeparationMemory& memory) const {
  auto& entry = memory.entries[(number * 61u + obstacle) & (memory.entries.size() - 1)];
  if (entry.part == number && entry.obstacle == obstacle) return entry;
  entry.part = number, entry.obstacle = obstacle;
  // the way from box to box, or between their middles where they overlap
  const AlignedBox box = box_of(part), &other = boxes_[obstacle];
  Vec3 way = ((box.low - other.high).max(0.0) - (other.low - box.high).max(0.0)).matrix();
  if (way.isZero(0.0)) way = (box.low + box.high - other.low - other.high).matrix();
  const double length = way.norm();
  entry.axis = length > 0.0 ? Vec3(way / length) : Vec3(Vec3::UnitX());
  return entry;
}

AlignedBox ConvexScene::box_of(const PointsView& points) {
  AlignedBox out{points[0].array(), points[0].array()};
  for (int i = 1; i < points.count; ++i)
    out = {out.low.min(points[i].array()), out.high.max(points[i].array())};
  return out;
}

bool ConvexScene::apart(std::uint32_t number, const PointsView& part, std::uint32_t obstacle, double least,
                        SeparationMemory& memory) const {
  Vec3& axis = recall(number, part, obstacle, memory).axis;
  return separation(part, obstacles_[obstacle], axis, least, std::nextafter(least, HUGE_VAL)) > least;
}

bool ConvexScene::free(const Pose& pose, double least, SeparationMemory& memory) const {
  ++memory.looks;
  const Placement at(pose, least);
  std::array<PartCoordinates, 3> placed;
  std::uint32_t number = SeparationMemory::kNone;
  PointsView part{placed[0].data(), placed[1].data(), placed[2].data(), 0};
  const auto touches = [&](std::uint32_t of_body, std::uint32_t obstacle) {
    if (number != of_body) {
      number = of_body;
      const PointsView points = body_[number];
      part.count = points.count;
      for (int k = 0; k < 3; ++k)
        for (int i = 0; i < part.count; ++i)
          placed[static_cast<std::size_t>(k)][static_cast<std::size_t>(i)] =
              at.p[k] + at.R(k, 0) * points.x[i] + at.R(k, 1) * points.y[i] + at.R(k, 2) * points.z[i];
    }
    if (apart(number, part, obstacle, least, memory)) return false;
    memory.hit_part = number, memory.hit_obstacle = obstacle;
    return true;
  };
  // what was in the way last is likely to be so again
  if (memory.hit_part != SeparationMemory::kNone && touches(memory.hit_part, memory.hit_obstacle))
    return false;
  return for_near_pairs(
      at, [&](std::uint32_t of_body, std::uint32_t obstacle) { return !touches(of_body, obstacle); });
}

bool ConvexScene::stays_apart(const Sweep& sweep, std::uint32_t obstacle, double from, double to,
                              double least, SeparationMemory& memory) const {
  const PointsView other = obstacles_[obstacle];
  const double most = sweep.d.norm() + sweep.angle * sweep.arm;  // m, that a point can move
  Sweep::Place now;
  sweep.place(from, now);
  Vec3& axis = recall(sweep.number, now.points(sweep.count), obstacle, memory).axis;
  // the axis of last time first: it often tells the whole motion
  double step = sweep.until(now, axis, reach_along(other, axis) + least, to - from);
  for (int i = 0; now.s + step < to; ++i) {
    if (i == kMostMotionSteps || (i > 1 && step * most < kLeastMotionStep)) return false;
    if (i > 0) sweep.place(now.s + step, now);
    ++memory.looks;
    const double enough = most * (to - now.s) + 2.0 * least;
    if (separation(now.points(sweep.count), other, axis, least, enough) <= least) return false;
    step = sweep.until(now, axis, reach_along(other, axis) + least, to - now.s);
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
  // powers of two, so that the pieces' ends are exact
  int pieces = 1;
  if (parts() > kFewParts) {
    const Cell& all = body_tree_.front();
    const double most = sweep.d.norm() + sweep.angle * (all.middle.norm() + all.radius);
    while (pieces < kMostPieces && most > kLongestPiece * pieces) pieces *= 2;
    for (int level = 4; level <= pieces; level *= 2)
      for (int i = 1; i < level; i += 2)
        if (!free(interpolate(a, b, static_cast<double>(i) / level), least, memory)) return false;
  }
  for (int i = 0; i < pieces; ++i) {
    const double from = static_cast<double>(i) / pieces, to = (i + 1.0) / pieces;
    Placement at(interpolate(a, b, 0.5 * (from + to)), least);
    at.widen(sweep, 0.5 / pieces);
    const bool clear = for_near_pairs(at, [&](std::uint32_t number, std::uint32_t obstacle) {
      if (sweep.number != number) sweep.take(number, body_[number], R);
      return stays_apart(sweep, obstacle, from, to, least, memory);
    });
    if (!clear) return false;
  }
  return true;
}

}  // namespace omniflight::planning
