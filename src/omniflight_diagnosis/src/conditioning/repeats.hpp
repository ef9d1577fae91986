// Detection of repeated samples: duplicates, sensors that freeze in flight, clipping.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Rows [begin, end) of a signal.
struct Rows {
  Eigen::Index begin = 0, end = 0;
};
/// Time [s] of sample i.
inline double time_of(const recording::Signal& s, Eigen::Index i) {
  return s.t_s[static_cast<std::size_t>(i)];
}
/// Partition into runs of rows that are equal bit for bit.
std::vector<Rows> equal_rows(const Eigen::MatrixXd& values);

/// Flags of the samples of `s` during which the rotors run (speed, command, duty cycle or power); a vehicle
/// on the ground repeats samples legitimately. All set without a rotor signal.
std::vector<char> driven(const recording::Recording& recording, const recording::Signal& s);

/// Freezes: equal samples for at least 0.15 s and five times the 99 % quantile of the time for which the
/// signal holds a value, in flight, entered or left by a jump.
std::vector<Rows> frozen(const recording::Signal& s, const std::vector<char>& in_flight);

/// Rows in which a component is at the limit of the sensor.
struct Clipped {
  std::vector<Rows> runs;
  double low = 0, high = 0;  ///< limits reached, in the unit of the signal; 0: none
};

/// Detects clipping: at least two runs of three samples, or ten samples in five runs, at exactly the same
/// extreme, and at least half as many samples there as in the adjacent 5 % of the range. Held samples of a
/// slower clock count once.
Clipped clipped(const recording::Signal& s);

/// Rows equal to the one before, at a distance below a fifth of the usual period: logged twice.
std::vector<Eigen::Index> written_twice(const recording::Signal& s);

}  // namespace omniflight::diagnosis
