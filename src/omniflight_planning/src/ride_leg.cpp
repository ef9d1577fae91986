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
  bool judged = false;        // at all places; else at few of them, so that the bound is a lower one
};

/// Times of a candidate; where `rough`, such as are no longer than those, in an eighth of the time.
Status judge(Candidate& c, const AtTilt& tilt, const MotionLimits& limits, Timing timing, bool rough,
             const Deadline& deadline) {
  constexpr int kRoughSteps = 50;    // enough to tell which is quicker
  constexpr int kRoughSamples = 50;  // of the 400: they ask for no more than all do
  c.least.clear();
  c.total = 0.0;
  for (const PoseCurve& curve : c.curves) {
    const auto least =
        least_time(curve, *tilt.rotors, limits, deadline, rough ? kRoughSamples : kShapeSamples);
    if (!least) return Failure(least.error());
    c.least.push_back(*least);
    double lower_bound = rough ? *least - kKnotPeriod : *least;  // it is found to half a period
    if (timing == Timing::shortest)
      if (const auto fastest = time_optimal(curve, tilt.rotors->load(), limits, kRoughSteps, deadline))
        lower_bound = fastest->duration();
    c.total += lower_bound;
  }
  c.judged = !rough;
  return {};
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

/// See ride_leg. The quickest whose curve is free is the best; what is slower even by a rough look is not
/// looked at closely.
Result<Ridden> ride_attitude(const std::vector<Path>& paths, const AtTilt& tilt, const MotionLimits& limits,
                             Timing timing, const Deadline& deadline) {
  const std::vector<Path> shapes = shapes_of(paths);
  std::vector<Candidate> candidates;
  std::optional<Error> problem;
  const bool rough = shapes.size() > 1 && timing == Timing::minimum_jerk && tilt.rotors->load().rank() == 6;
  const auto offer = [&](Candidate c, bool roughly) {
    if (deadline.passed()) return;
    if (auto ok = judge(c, tilt, limits, timing, roughly, deadline); ok)
      candidates.push_back(std::move(c));
    else
      problem = ok.error();
  };
  const auto through = [](const std::vector<Path>& parts) {
    Candidate out;
    for (const Path& part : parts) out.curves.emplace_back(part);
    return out;
  };
  for (const Path& shape : shapes) offer(through({shape}), rough);
  if (shapes.size() > 1) offer(through(motions_of(shapes.front())), rough);
  while (!candidates.empty() && !deadline.passed()) {
    const auto quickest =
        std::min_element(candidates.begin(), candidates.end(),
                         [](const Candidate& a, const Candidate& b) { return a.total < b.total; });
    Candidate c = std::move(*quickest);
    candidates.erase(quickest);
    if (!c.judged) {
      offer(std::move(c), false);
      continue;
    }
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
