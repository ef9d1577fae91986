#include "leg_shapes.hpp"

namespace omniflight::planning {
namespace {

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

}  // namespace

std::vector<Path> shapes_of(const std::vector<Path>& paths) {
  const auto joined = [&](auto shape) {
    Path all{paths.front().front()};
    for (const Path& path : paths) {
      const Path shaped = shape(path);
      all.insert(all.end(), shaped.begin() + 1, shaped.end());
    }
    return all;
  };
  std::vector<Path> shapes{joined([](const Path& p) { return p; })};
  if (shapes.front().size() == 2) return shapes;
  for (const int times : {1, 2})
    shapes.push_back(joined([&](const Path& p) { return cut_corners(p, times); }));
  for (const int parts : {3, 6})
    shapes.push_back(joined([&](const Path& p) { return subdivided(p, parts); }));
  return shapes;
}

}  // namespace omniflight::planning
