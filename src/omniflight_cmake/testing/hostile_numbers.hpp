// Numbers that break arithmetic, among sound ones: for tests that feed them to what runs in flight.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <limits>

namespace hostile {

/// How many inputs a test takes; OMNIFLIGHT_RUNS tells the long tests.
inline long samples(long usual = 200'000) {
  const char* told = std::getenv("OMNIFLIGHT_RUNS");
  return told ? std::max(1L, std::atol(told)) : usual;
}

/// Four of five times a normal number of standard deviation 10, otherwise zeros, NaN, infinities, the
/// largest, denormal and tiny numbers, and ones that overflow when they are squared or are only too large to
/// be true.
template <class Random>
double any_number(Random& random) {
  using Limits = std::numeric_limits<double>;
  constexpr double kHostile[] = {0.0,
                                 -0.0,
                                 Limits::quiet_NaN(),
                                 Limits::infinity(),
                                 -Limits::infinity(),
                                 Limits::max(),
                                 -Limits::max(),
                                 Limits::denorm_min(),
                                 1e-300,
                                 1e154,
                                 -1e9,
                                 1e6};
  const double roll = random.uniform();
  if (roll < 0.8) return 10.0 * random.normal();
  return kHostile[static_cast<std::size_t>(random.uniform() * std::size(kHostile))];
}

}  // namespace hostile
