// What is drawn of a mechanism besides its amplitude, from boxes that tuning and sealed runs do not share.
#pragma once

#include <array>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::proof {

/// What is drawn besides the amplitude: directions, rotors, lengths. Numbers in [0, 1) of the chosen box.
struct Shape {
  std::array<double, 8> u{};
  double between(int k, double low, double high) const {
    return low + (high - low) * u[static_cast<std::size_t>(k)];
  }
  int whole(int k, int first, int last) const {
    return first + static_cast<int>(u[static_cast<std::size_t>(k)] * (last - first + 1));
  }
  double sign(int k) const { return u[static_cast<std::size_t>(k)] < 0.5 ? -1.0 : 1.0; }
  /// Unit vector from u[k], u[k + 1]; flat: across the vertical.
  Vec3 direction(int k, bool flat = false) const;
};
/// Numbers of the tuning box and of the sealed one never meet: each takes every other eighth of [0, 1).
Shape draw_shape(Random& random, bool sealed);

}  // namespace omniflight::proof
