// What chapter 7 reads out of recordings.
#pragma once

#include <optional>

#include "omniflight_report/flight_metrics.hpp"
#include "omniflight_reproduction/figure.hpp"

namespace omniflight::reproduction {

/// A recording with its figures.
struct Flown {
  const recording::Recording* recording = nullptr;
  report::FlightMetrics metrics;
};
/// nullopt: it was not flown. An error: it cannot be assessed.
Result<std::optional<Flown>> flown(const Inputs& inputs, const std::string& name);

/// Step that thins so many samples to the points that a curve of the page has.
std::size_t step_of_curve(std::size_t samples);

/// Columns `first`... of a signal over time from the first motion on, one series a name.
std::vector<report::Series> curves(const Flown& flight, const std::string& signal,
                                   const std::vector<std::string>& names, int first, double scale,
                                   bool dashed);
/// RMS of a column while the reference moves; NaN when it was not recorded.
double rms(const Flown& flight, const std::string& signal, int column);

}  // namespace omniflight::reproduction
