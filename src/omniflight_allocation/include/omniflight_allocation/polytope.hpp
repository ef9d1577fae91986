// Convex bodies in three dimensions, given by half spaces.
#pragma once

#include <array>
#include <vector>

#include "omniflight_core/frames.hpp"

namespace omniflight::allocation {

/// The points x with normal . x <= offset; |normal| = 1.
struct HalfSpace {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;
};

/// A bounded convex body, possibly flat: a polygon, a segment, a point or nothing at all.
struct Polytope {
  int dimension = -1;             ///< -1: empty
  std::vector<HalfSpace> facets;  ///< of a body of dimension 3: one for each facet, coplanar ones merged
  std::vector<Vec3> vertices;     ///< corners only: no points inside edges or facets
  bool empty() const { return dimension < 0; }
};

/// An affine part of space: origin plus the span of the orthonormal columns of basis (3 x dimension).
struct Flat {
  Vec3 origin = Vec3::Zero();
  Eigen::Matrix<double, 3, Eigen::Dynamic> basis = Mat3::Identity();
};

/// The part of the flat inside all half spaces, which must bound it. Lengths below tolerance are taken as
/// zero, so that facets which agree to within it become one. radius: of a ball about flat.origin that holds
/// the body.
Polytope intersect(const Flat& flat, std::vector<HalfSpace> half_spaces, double radius, double tolerance);

/// How far the boundary of a body is from the zero point.
struct SetMeasures {
  int dimension = -1;        ///< 3: every direction can be reached in some amount
  bool holds_zero = false;   ///< zero lies inside or on the boundary
  double d_min_surface = 0;  ///< radius of the largest ball about zero that fits; 0 unless dimension is 3
  double d_min_vertex = 0;   ///< nearest vertex
  double d_max = 0;          ///< farthest vertex
  double uniformity_surface = 0;  ///< d_min_surface / d_max, 1 for a ball
  double uniformity_vertex = 0;   ///< d_min_vertex / d_max; 0 unless dimension is 3 and zero lies inside
  int facets = 0, vertices = 0;
};
SetMeasures measure(const Polytope& body);

/// The surface as triangles of indices into vertices, counterclockwise from outside; of a polygon its one
/// side. Nothing for less than a polygon.
std::vector<std::array<int, 3>> triangles(const Polytope& body);

}  // namespace omniflight::allocation
