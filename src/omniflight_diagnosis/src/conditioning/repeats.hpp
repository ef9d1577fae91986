// Samples that say the same again: copies, sensors that freeze in flight, and values that stay at a limit.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Rows [begin, end) of a signal that are equal bit for bit.
struct Rows {
  Eigen::Index begin = 0, end = 0;
};
/// s, of sample `i`
inline double time_of(const recording::Signal& s, Eigen::Index i) {
  return s.t_s[static_cast<std::size_t>(i)];
}
std::vector<Rows> equal_rows(const Eigen::MatrixXd& values);

/// At which samples of `s` the rotors work, by measured speed, command or drive: a vehicle on the ground may
/// well repeat itself. All of them where no rotor signal tells.
std::vector<char> driven(const recording::Recording& recording, const recording::Signal& s);

/// Runs that are no holding of a slow or coarse signal: .15 s or longer, five times as long as its longest
/// usual ones, in flight, and the signal jumps into or out of them as it otherwise moves from sample to
/// sample.
std::vector<Rows> frozen(const recording::Signal& s, const std::vector<char>& in_flight);

/// Rows in which a component stands at its largest or smallest value.
struct Clipped {
  std::vector<Rows> runs;
  double low = 0, high = 0;  ///< limits reached, in the unit of the signal; 0 where none is
};

/// Three samples in a row or longer at exactly the same extreme, twice or more, and more samples there than
/// in the last twentieth of the range before it. Samples held from a slower clock count once.
Clipped clipped(const recording::Signal& s);

/// Rows that repeat the one before within a fifth of the usual period: written twice.
std::vector<Eigen::Index> written_twice(const recording::Signal& s);

}  // namespace omniflight::diagnosis
