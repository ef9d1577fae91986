// What controller, allocator and rotors did in two flights: where along the chain they differ.
#pragma once

#include "metrics.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::cli {

/// One component of one stage, RMS over the window in which the reference moves.
struct ControlRow {
  std::string stage, channel, unit;
  double simulated = 0, real = 0;  ///< RMS
  double ratio() const { return simulated > 0 ? real / simulated : 0.0; }
};

/// A flight with what was measured on it.
struct Flown {
  const recording::Recording& recording;
  const FlightMetrics& metrics;
  const vehicle::Vehicle& vehicle;
};

/// Control: demand qddr [m/s2, rad/s2] and integral action; allocation: thrusts u [N], tilt alpha [deg],
/// demand not achieved; actuation: rotor speeds [rad/s]; power [W]. Only signals that both recordings have.
std::vector<ControlRow> compare_control(const Flown& simulated, const Flown& real);
report::Table control_table(const std::vector<ControlRow>& rows);
nlohmann::json to_json(const std::vector<ControlRow>& rows);
/// Both flights in each plot, time from the first motion of the reference.
void plot_control(report::Page& page, const Flown& simulated, const Flown& real);

}  // namespace omniflight::cli
