#include "ride_leg.hpp"

#include <algorithm>
#include <optional>

#include "leg_shapes.hpp"
#include "omniflight_planning/time_optimal.hpp"

namespace omniflight::planning {
namespace {

/// One way of riding a leg: a curve, or several with a stop between two.
struct Candidate {
  std::vector<PoseCurve> curves;
  std::vector<double> least;  // s, of each, by the minimum-jerk law
  double total = 0.0;         // s, by the law that is asked for: a lower bound
};

Result<Candidate> candidate(const std::vector<Path>& parts, const AtTilt& tilt, const MotionLimits& limits,
                            Timing timing, const Deadline& deadline) {
  constexpr int kRoughSteps = 50;  // enough to tell which is quicker
  Candidate out;
  for (const Path& part : parts) {
    out.curves.emplace_back(part);
    const auto least = least_time(out.curves.back(), *tilt.rotors, limits, deadline);
    if (!least) return Failure(least.error());
    out.least.push_back(*least);
    double lower_bound = *least;
    if (timing == Timing::shortest)
      if (const auto fastest =
              time_optimal(out.curves.back(), tilt.rotors->load(), limits, kRoughSteps, deadline))
        lower_bound = fastest->duration();
    out.total += lower_bound;
  }
  return out;
}

std::vector<Path> motions_of(const Path& path) {
  std::vector<Path> out;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) out.push_back({path[i], path[i + 1]});
  return out;
}

bool is_free(const Knots& knots, const AtTilt& tilt, const Deadline& deadline) {
  const auto trajectory = Trajectory::create(knots);
  return trajectory && tilt.check.advance_along(*trajectory, deadline).free;
}

/// The curves of a candidate ridden by the shortest timing that is found in a share of what is left of the
/// time; empty where there is not enough of it.
Knots ridden_fast(const Candidate& c, const AtTilt& tilt, const MotionLimits& limits,
                  const Deadline& deadline) {
  constexpr double kShare = 0.3;
  const Deadline end = deadline.within(kShare * deadline.left());
  Knots knots;
  for (const PoseCurve& curve : c.curves) {
    const auto part = ride_shortest(curve, *tilt.rotors, limits, end);
    if (!part) return {};
    append(knots, *part);
  }
  return knots;
}

/// See ride_leg. The times of all candidates are cheap; the quickest whose curve is free is the best.
Result<Ridden> ride_attitude(const std::vector<Path>& paths, const AtTilt& tilt, const MotionLimits& limits,
                             Timing timing, const Deadline& deadline) {
  const std::vector<Path> shapes = shapes_of(paths);
  std::vector<Candidate> candidates;
  std::optional<Error> problem;
  const auto offer = [&](const std::vector<Path>& parts) {
    if (deadline.passed()) return;
    if (auto made = candidate(parts, tilt, limits, timing, deadline))
      candidates.push_back(std::move(*made));
    else
      problem = made.error();
  };
  for (const Path& shape : shapes) offer({shape});
  if (shapes.size() > 1) offer(motions_of(shapes.front()));
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.total < b.total; });
  for (const Candidate& c : candidates) {
    if (deadline.passed()) break;
    Knots knots;
    for (std::size_t i = 0; i < c.curves.size(); ++i) {
      auto part = ride_from(c.least[i], c.curves[i], *tilt.rotors, limits, deadline);
      if (!part) return Failure(part.error());
      append(knots, *part);
    }
    if (!is_free(knots, tilt, deadline)) continue;
    if (timing == Timing::shortest) {
      auto faster = ridden_fast(c, tilt, limits, deadline);
      if (is_free(faster, tilt, deadline)) knots = std::move(faster);
    }
    return Ridden{std::move(knots), c.curves.size() > 1};
  }
  if (deadline.passed()) return out_of_time(deadline, "timing a ride");
  if (problem) return Failure(*problem);
  return fail(ErrorCode::incomplete, kBlocked);
}

/// See ride_leg, for vehicles that lean into their motion, at the limits as they are.
Result<Ridden> ride_leaning(const std::vector<Path>& paths, const AtTilt& tilt, const MotionLimits& limits,
                            const Deadline& deadline) {
  Ridden best;
  std::optional<Error> problem;
  const auto offer = [&](Knots knots, bool stops) {
    if (!best.knots.empty() && knots.back().t >= best.knots.back().t) return;
    if (is_free(knots, tilt, deadline)) best = {std::move(knots), stops};
  };
  const auto through = [&](const Path& poses) {
    return ride(FlatCurve(poses, *tilt.flat), *tilt.flat, *tilt.rotors, limits, deadline);
  };
  const std::vector<Path> shapes = shapes_of(paths);
  for (const Path& shape : shapes) {
    if (deadline.passed()) return out_of_time(deadline, "timing a ride");
    auto knots = through(shape);
    if (knots)
      offer(std::move(*knots), false);
    else
      problem = knots.error();
  }
  if (shapes.size() > 1) {
    Knots knots;
    for (const Path& motion : motions_of(shapes.front())) {
      auto part = through(motion);
      if (!part) return Failure(part.error());
      append(knots, *part);
    }
    offer(std::move(knots), true);
  }
  if (deadline.passed()) return out_of_time(deadline, "timing a ride");
  if (!best.knots.empty()) return best;
  if (problem) return Failure(*problem);
  return fail(ErrorCode::incomplete, kBlocked);
}

}  // namespace

void append(Knots& all, const Knots& more) {
  const double t0 = all.empty() ? 0.0 : all.back().t;
  for (std::size_t i = all.empty() ? 0 : 1; i < more.size(); ++i) {
    all.push_back(more[i]);
    all.back().t += t0;
  }
}

Result<Ridden> ride_leg(const std::vector<Path>& paths, const AtTilt& tilt, const MotionLimits& limits,
                        Timing timing, const Deadline& deadline) {
  if (!tilt.flat) return ride_attitude(paths, tilt, limits, timing, deadline);
  auto ridden = ride_leaning(paths, tilt, limits, deadline);
  MotionLimits slower = limits;
  for (int halvings = 0; !ridden && ridden.error().message == kBlocked && halvings < 4; ++halvings) {
    slower.acceleration *= 0.5;
    ridden = ride_leaning(paths, tilt, slower, deadline);
  }
  return ridden;
}

}  // namespace omniflight::planning
