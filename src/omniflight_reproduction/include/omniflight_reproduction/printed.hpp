// The numbers that the OmniMorph thesis prints, each typed once.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace omniflight::reproduction {

/// One printed number, and how close ours must come to count as the same.
struct Printed {
  const char* key;   ///< "5.3/force_uniformity_30": figure or table, then the quantity
  const char* what;  ///< in words
  const char* unit;  ///< of value and tolerance; empty for shares and ratios
  double value;
  double tolerance;     ///< largest difference that counts as the same; with `factor` the largest ratio, >= 1
  bool factor;          ///< the tolerance is a ratio either way
  const char* because;  ///< why this tolerance
  const char* source;   ///< place in A. T. S. Abdo Ali, MSc thesis, University of Twente, 054RaM2024
};

const std::vector<Printed>& printed_numbers();
/// nullptr when the thesis prints no such number.
const Printed* find_printed(std::string_view key);
/// Whether `ours` is the printed number, within its tolerance. A number that is not finite is not.
bool agrees(const Printed& printed, double ours);

}  // namespace omniflight::reproduction
