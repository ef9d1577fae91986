// Sweeps of a thrust stand, from CSV as stands write it.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <string_view>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::identification {

struct SweepOptions {
  std::string thrust_unit;  ///< N, g, gf or kg where the header has none; empty: the header must have it
};

/// Rows with speed and thrust. A stand with several rotors has a speed for each and the thrust of all.
struct BenchSweep {
  std::string file;
  Eigen::MatrixXd speed_radps;  ///< a column a rotor, magnitudes
  Eigen::VectorXd thrust_N;     ///< of all rotors, positive
  Eigen::VectorXd torque_Nm;    ///< of all rotors, positive; empty when not recorded
  Eigen::VectorXd time_s;       ///< empty when not recorded
  Eigen::Index dropped = 0;     ///< rows at rest, incomplete, or where a rotor's speed cannot be right
};

/// Reads a table with a header: columns "name[unit]" or "name (unit)", comma or semicolon, a byte order mark
/// is passed over. Speed: names that begin with rpm, or contain speed, in RPM (the electrical one before the
/// optical); thrust: thrust or weight in N, g, gf, kg; torque in N m. Thrust of a stand that pushes is
/// turned. Rows in which the speeds of the rotors differ by more than a third, or one stands while others
/// turn, are dropped. At most 200000 rows. Errors name file, line, column and unit.
Result<BenchSweep> read_sweep(std::string_view text, const std::string& file,
                              const SweepOptions& options = {});

}  // namespace omniflight::identification
