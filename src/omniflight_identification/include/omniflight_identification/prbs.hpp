// Pseudo-random binary signals: making them, and finding the part of a recorded one that is white.
#pragma once

#include <cstdint>
#include <optional>

#include "omniflight_identification/data.hpp"

namespace omniflight::identification {

struct PrbsConfig {
  double low = 0.0, high = 0.0;  ///< the two levels, in the unit of the command; low < high
  double band_hz = 5.0;          ///< half the power is lost here: the bit lasts 0.443 / band_hz
  double period_s = 0.01;        ///< between commands; a bit is a whole number of them
  double duration_s = 30.0;      ///< s, at most 3600
  double lead_s = 2.0;           ///< at the mean of the levels, before and after
  double max_slope = 0.0;        ///< unit of the command per s; 0: no limit
  std::uint32_t seed = 1;        ///< state the shift register begins with, not 0
};

struct Prbs {
  Eigen::VectorXd values;  ///< a row a period, lead included
  int bit_samples = 1;
  int register_bits = 5;  ///< the sequence would repeat after 2^register_bits - 1 bits
  double bit_s = 0.0;
};

/// A sequence of maximal length (shift register). Errors name the field: levels, band against the command
/// period (at least two periods a bit), slope against the levels and the band.
Result<Prbs> make_prbs(const PrbsConfig& config);

/// Where a signal is a white binary sequence.
struct WhitePart {
  Eigen::Index from = 0, to = 0;  ///< samples, to excluded
  double bit_samples = 1;         ///< a bit lasts
  Eigen::Index bits = 0;
  Eigen::VectorXd correlation;  ///< of its bits, lags 0..
  double bound = 0.0;           ///< 99 % of a single correlation of white bits
};
/// The longest stretch whose bits are white by their autocorrelation; nothing when there is none of at least
/// 31 bits, so for instance for every signal that is not binary.
std::optional<WhitePart> white_part(const Eigen::VectorXd& u);

/// Share of a first-order lag's steady response that is reached within a bit: 1 - exp(-bit / lag). Below 0.1
/// the motor does not follow: the signal lies beyond its band.
double followed_share(double bit_s, double lag_s);

}  // namespace omniflight::identification
