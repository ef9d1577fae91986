#include "case_shape.hpp"

#include <cmath>

namespace omniflight::proof {

Vec3 Shape::direction(int k, bool flat) const {
  const double azimuth = between(k, 0, 2 * kPi), z = flat ? 0.0 : between(k + 1, -1, 1);
  const double across = std::sqrt(std::max(0.0, 1 - z * z));
  return {across * std::cos(azimuth), across * std::sin(azimuth), z};
}

Shape draw_shape(Random& random, bool sealed) {
  Shape s;
  for (double& u : s.u) {
    const double in = random.uniform(0, 4);  // four of eight strips, every other one
    u = (2 * std::floor(in) + (in - std::floor(in)) + (sealed ? 1 : 0)) / 8;
  }
  return s;
}

}  // namespace omniflight::proof
