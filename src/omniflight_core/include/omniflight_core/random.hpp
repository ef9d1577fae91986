// Random numbers that are the same with every compiler and standard library: results must repeat to the bit.
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

namespace omniflight {

/// SplitMix64-seeded xoshiro256** (Blackman and Vigna, 2018). Each consumer owns its stream.
class Random {
 public:
  /// Streams with the same seed and different names are independent.
  explicit Random(std::uint64_t seed, std::string_view stream = {});

  /// 64 random bits.
  std::uint64_t next();
  /// Uniform in [0, 1), and in [low, high).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Standard normal (polar method).
  double normal();

 private:
  std::uint64_t s_[4];
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace omniflight
