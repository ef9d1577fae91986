#include "gap.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

constexpr double kLeastGapRoom = 3e-4;  // m, a little more than a valid pose must have
constexpr double kApart = 0.3;          // m, between two gaps of a way
constexpr double kBalance = 0.03;       // m beyond the margin within which spheres count
constexpr int kRandomAttitudes = 40;
constexpr std::size_t kImproved = 6;  // of the attitudes
constexpr double kCrawlStep = 0.03;   // m, of the crawl
constexpr int kMostSteps = 60;

/// How well a pose fits: valid ones by their room, the others by what their spheres miss.
struct Fit {
  double room = -1.0;    // m; negative: invalid
  double missing = 0.0;  // m^2
  bool better_than(const Fit& other) const {
    if (room >= 0.0 || other.room >= 0.0) return room > other.room;
    return missing < other.missing;
  }
};

class Fitter {
 public:
  Fitter(const StateCheck& check, bool must_hold, Random& random, const Deadline& deadline)
      : check_(check), must_hold_(must_hold), random_(random), deadline_(deadline) {}

  bool allowed(const Quat& q) const { return !must_hold_ || check_.hoverable(q); }

  double missing(const Pose& pose) const {
    const Mat3 R = pose.q_WB.toRotationMatrix();
    double sum = 0.0;
    for (const SphereGroup& group : check_.spheres().groups) {
      const double near = check_.map().coarse_distance(pose.p_WB + R * group.bound.p_BS);
      if (near >= group.bound.radius + check_.margin() + kBalance) continue;
      for (const BodySphere& s : group.spheres) {
        const double lack =
            check_.margin() + kBalance + s.radius - check_.map().distance(pose.p_WB + R * s.p_BS);
        if (lack > 0.0) sum += lack * lack;
      }
    }
    return sum;
  }

  Fit fit(const Pose& pose) const {
    Fit out;
    const double room = check_.room(pose);
    if (room > kLeastGapRoom)
      out.room = room;
    else
      out.missing = missing(pose);
    return out;
  }

  /// Random steps across `along` that fit better; the steps become smaller from `reach` [m] and `turn` [rad]
  /// on.
  Fit improve(Pose& pose, const Vec3& along, int trials, double reach, double turn) {
    Fit best = fit(pose);
    for (int i = 0; i < trials && !deadline_.passed(); ++i) {
      const double scale = std::pow(0.05, static_cast<double>(i) / trials);
      Vec3 step = scale * reach * Vec3(random_.normal(), random_.normal(), random_.normal());
      step -= along * along.dot(step);
      const Vec3 rotation = scale * turn * Vec3(random_.normal(), random_.normal(), random_.normal());
      const Pose next{pose.p_WB + step, (pose.q_WB * exp_rotation(rotation)).normalized()};
      if (!allowed(next.q_WB)) continue;
      if (const Fit found = fit(next); found.better_than(best)) {
        best = found;
        pose = next;
      }
    }
    return best;
  }

  /// The best pose across the gap.
  Pose best_pose(const Gap& gap, const std::vector<Quat>& attitudes, Fit& best) {
    struct Candidate {
      Pose pose;
      Fit fit;
    };
    std::vector<Candidate> candidates;
    const auto offer = [&](const Quat& q) {
      if (allowed(q)) candidates.push_back({{gap.p_W, q}, fit({gap.p_W, q})});
    };
    for (const Quat& q : attitudes) offer(q);
    for (const Quat& q : frames_of(gap.along_W)) offer(q);
    for (int i = 0; i < kRandomAttitudes; ++i)
      offer(Quat(random_.normal(), random_.normal(), random_.normal(), random_.normal()).normalized());
    const std::size_t count = std::min(kImproved, candidates.size());
    std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count),
                      candidates.end(),
                      [](const Candidate& a, const Candidate& b) { return a.fit.better_than(b.fit); });
    Pose out{gap.p_W, attitudes.front()};
    best = {-1.0, HUGE_VAL};
    for (std::size_t i = 0; i < count && !deadline_.passed(); ++i) {
      Candidate& c = candidates[i];
      c.fit = improve(c.pose, gap.along_W, 80, 0.05, 0.3);
      if (c.fit.better_than(best)) {
        best = c.fit;
        out = c.pose;
      }
    }
    if (best.room >= 0.0) best = improve(out, gap.along_W, 40, 0.01, 0.05);
    return out;
  }

  /// Appends the poses of a crawl from `from` until there is room for any attitude; false when it gets stuck.
  bool crawl(const Pose& from, Vec3 along, std::vector<Pose>& out) {
    const double open = check_.spheres().bounding_radius + check_.margin();
    Pose now = from;
    for (int i = 0; i < kMostSteps && !deadline_.passed(); ++i) {
      if (check_.map().distance(now.p_WB) > open) return true;
      bool moved = false;
      for (const double reach : {0.004, 0.012}) {
        Pose next{now.p_WB + kCrawlStep * along, now.q_WB};
        if (improve(next, along, 16, reach, 3.0 * reach).room < 0.0 || !check_.motion_valid(now, next))
          continue;
        along = (0.8 * along + 0.2 * (next.p_WB - now.p_WB).normalized()).normalized();
        out.push_back(now = next);
        moved = true;
        break;
      }
      if (!moved) return false;
    }
    return check_.map().distance(now.p_WB) > open;
  }

 private:
  /// The 24 right-angled attitudes in a frame with one axis along the gap and one level.
  static std::vector<Quat> frames_of(const Vec3& along) {
    Vec3 level = Vec3::UnitZ().cross(along);
    level = level.norm() > 1e-3 ? level.normalized() : Vec3(Vec3::UnitY());
    Mat3 frame;
    frame << along, level, along.cross(level);
    std::vector<Quat> out;
    for (int x = 0; x < 6; ++x)
      for (int y = 0; y < 6; ++y) {
        if (x / 2 == y / 2) continue;
        Mat3 turn;
        turn.col(0) = (x % 2 ? -1.0 : 1.0) * Vec3::Unit(x / 2);
        turn.col(1) = (y % 2 ? -1.0 : 1.0) * Vec3::Unit(y / 2);
        turn.col(2) = turn.col(0).cross(turn.col(1));
        out.push_back(Quat(Mat3(frame * turn)).normalized());
      }
    return out;
  }

  const StateCheck& check_;
  bool must_hold_;
  Random& random_;
  Deadline deadline_;
};

}  // namespace

std::vector<Gap> gaps_of(const std::vector<WayPlace>& way, double wide) {
  std::vector<Gap> out;
  constexpr std::size_t kReach = 4;  // blocks before and after that tell the direction
  for (std::size_t i = 1; i + 1 < way.size(); ++i) {
    if (way[i].distance >= wide) continue;
    const std::size_t first = i - std::min(i, kReach), last = std::min(i + kReach, way.size() - 1);
    bool narrowest = true;
    for (std::size_t k = first; k <= last; ++k)
      narrowest &= k < i ? way[k].distance > way[i].distance : way[k].distance >= way[i].distance;
    const Vec3 along = way[last].p_W - way[first].p_W;
    if (!narrowest || along.norm() < 1e-6) continue;
    if (!out.empty() && (way[i].p_W - out.back().p_W).norm() < kApart) continue;
    out.push_back({way[i].p_W, way[i].distance, along.normalized()});
  }
  return out;
}

Crossing cross(const StateCheck& check, const Gap& gap, const std::vector<Quat>& attitudes, Random& random,
               const Deadline& deadline) {
  Crossing out;
  Fit best;
  Fitter fitter(check, true, random, deadline);
  const Pose pose = fitter.best_pose(gap, attitudes, best);
  if (best.room < 0.0) {
    out.lack = check.margin() - check.clearance(pose).distance;
    Fit whatever;
    Fitter(check, false, random, deadline).best_pose(gap, attitudes, whatever);
    out.unholdable = whatever.room >= 0.0;
    return out;
  }
  std::vector<Pose> back, forth;
  if (!fitter.crawl(pose, -gap.along_W, back) || !fitter.crawl(pose, gap.along_W, forth)) return out;
  out.poses.assign(back.rbegin(), back.rend());
  out.poses.push_back(pose);
  out.poses.insert(out.poses.end(), forth.begin(), forth.end());
  return out;
}

}  // namespace omniflight::planning
