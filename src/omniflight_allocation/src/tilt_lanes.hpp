// The box programs of up to eight tilts at once, a tilt in each lane: which of them is cheapest.
#pragma once

#include <array>
#include <cstdint>

#include "omniflight_core/frames.hpp"

namespace omniflight::allocation {

inline constexpr int kTilts = 8;       ///< lanes
inline constexpr int kLaneInputs = 8;  ///< rotors
inline constexpr int kTriangle = kLaneInputs * (kLaneInputs + 1) / 2;

/// What stays from one period to the next. With c = cos alpha and s = sin alpha, the accelerations of the
/// thrusts are A(alpha) = A0 + c Ac + s As, and the matrix of the program is their weighted product.
struct TiltTerms {
  int n = 0;
  bool constant_part = false;  ///< A0 is not zero
  /// Lower triangle, row by row, of the products that go with cc, ss, cs, 1, c and s.
  std::array<std::array<double, 6>, kTriangle> quadratic{};
  /// Rows of A: factors of c, s and 1.
  std::array<std::array<std::array<double, 3>, kLaneInputs>, 6> rows{};
  std::array<double, 6> weight{};
  std::array<double, kLaneInputs> lower{}, upper{};  ///< N
  double primal_tolerance = 0;                       ///< N
};

struct TiltPrograms {
  // in
  alignas(64) std::array<double, kTilts> c{}, s{};
  int count = 0;                                                ///< lanes that are asked for
  std::array<double, kLaneInputs> diagonal{};                   ///< added to that of the matrix
  std::array<std::array<double, 3>, kLaneInputs> linear{};      ///< minus g: factors of c, s and 1
  std::array<double, 6> target{};                               ///< acceleration wanted
  std::array<double, kLaneInputs> rate{}, input{}, previous{};  ///< weights of (u - previous)^2 and u^2
  double dual_tolerance = 0;
  // in and out: a bit for each lane
  std::array<std::uint8_t, kLaneInputs> at_low{}, at_high{};
  // out
  alignas(64) std::array<double, kTilts> cost{};  ///< value of equation 4.3
  std::uint8_t solved = 0;                        ///< a bit for each lane; the others need another solver
  int sweeps = 0;                                 ///< systems solved in each lane
};

/// Block principal pivoting in every lane, started at at_low and at_high; a lane that has not settled after a
/// few exchanges is not solved. Pure; allocates nothing; the same bits on every processor.
void solve_tilts(const TiltTerms& terms, TiltPrograms& programs);

}  // namespace omniflight::allocation
