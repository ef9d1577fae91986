#include "ride_leg.hpp"

namespace omniflight::planning {
namespace {

constexpr const char* kBlocked = "curve_blocked: the timed curve does not keep the clearance of the path";

/// Each motion of a path cut into `parts`, so that a spline through it hugs the path more closely.
Path subdivided(const Path& path, int parts) {
  Path out{path.front()};
  for (std::size_t i = 0; i + 1 < path.size(); ++i)
    for (int k = 1; k <= parts; ++k)
      out.push_back(interpolate(path[i], path[i + 1], static_cast<double>(k) / parts));
  return out;
}

/// Corners cut (Chaikin): a quarter of each motion before and after an inner corner replaces it.
Path cut_corners(const Path& path, int times) {
  Path out = path;
  for (int i = 0; i < times && out.size() > 2; ++i) {
    Path next{out.front()};
    for (std::size_t k = 0; k + 1 < out.size(); ++k) {
      if (k > 0) next.push_back(interpolate(out[k], out[k + 1], 0.25));
      if (k + 2 < out.size()) next.push_back(interpolate(out[k], out[k + 1], 0.75));
    }
    next.push_back(out.back());
    out = std::move(next);
  }
  return out;
}

Result<Knots> ride_through(const Path& poses, const AtTilt& tilt, const MotionLimits& limits,
                           const Deadline& deadline) {
  if (tilt.flat) return ride(FlatCurve(poses, *tilt.flat), *tilt.flat, *tilt.rotors, limits, deadline);
  return ride(PoseCurve(poses), *tilt.rotors, limits, deadline);
}

/// See ride_leg, at the limits as they are.
Result<Ridden> ride_at(const std::vector<Path>& paths, const AtTilt& tilt, const MotionLimits& limits,
                       const Deadline& deadline) {
  const auto joined = [&](auto shape) {
    Path all{paths.front().front()};
    for (const Path& path : paths) {
      const Path shaped = shape(path);
      all.insert(all.end(), shaped.begin() + 1, shaped.end());
    }
    return all;
  };
  const Path corners = joined([](const Path& p) { return p; });
  std::vector<Path> shapes{corners};
  if (corners.size() > 2) {
    for (const int times : {1, 2})
      shapes.push_back(joined([&](const Path& p) { return cut_corners(p, times); }));
    for (const int parts : {3, 6})
      shapes.push_back(joined([&](const Path& p) { return subdivided(p, parts); }));
  }
  Ridden best;
  std::optional<Error> problem;
  const auto offer = [&](Knots knots, bool stops) {
    if (!best.knots.empty() && knots.back().t >= best.knots.back().t) return;
    const auto trajectory = Trajectory::create(knots);
    if (trajectory && tilt.check.curve(*trajectory, deadline).free) best = {std::move(knots), stops};
  };
  for (const Path& shape : shapes) {
    if (deadline.passed()) return out_of_time(deadline, "timing a ride");
    auto knots = ride_through(shape, tilt, limits, deadline);
    if (knots)
      offer(std::move(*knots), false);
    else
      problem = knots.error();
  }
  if (corners.size() > 2) {
    Knots knots;
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
      auto part = ride_through({corners[i], corners[i + 1]}, tilt, limits, deadline);
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
                        const Deadline& deadline) {
  auto ridden = ride_at(paths, tilt, limits, deadline);
  MotionLimits slower = limits;
  for (int halvings = 0; tilt.flat && !ridden && ridden.error().message == kBlocked && halvings < 4;
       ++halvings) {
    slower.acceleration *= 0.5;
    ridden = ride_at(paths, tilt, slower, deadline);
  }
  return ridden;
}

}  // namespace omniflight::planning
