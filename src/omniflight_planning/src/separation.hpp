// How far two convex polyhedra are apart: Gilbert, Johnson and Keerthi (1988) with a certified lower bound.
#pragma once

#include "omniflight_core/frames.hpp"

namespace omniflight::planning {

/// Points whose hull is meant, coordinate by coordinate; at least one.
struct PointsView {
  const double *x, *y, *z;  // m
  int count;
  Vec3 operator[](int i) const { return {x[i], y[i], z[i]}; }
};

/// Lower bound [m] of the distance between the hulls of a and b: the gap between them along the unit vector
/// `axis`, from b to a, which is the first one tried and becomes the best one found. Ends where it is at
/// least `enough`; where the hulls are no farther apart than `low`, in which case the answer is no more than
/// that; else within a tenth of the distance, or 1e-6 m of it where it is not above `low`. Whatever rounding
/// does to the search, the gap is one.
double separation(const PointsView& a, const PointsView& b, Vec3& axis, double low, double enough);

/// The point of b that reaches farthest along n, times n [m].
double reach_along(const PointsView& b, const Vec3& n);

}  // namespace omniflight::planning
