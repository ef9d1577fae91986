// Two designs beside each other: their figures with differences, their hulls in one drawing.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "omniflight_allocation/actuation.hpp"
#include "omniflight_allocation/feasible_set.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::cli {

/// One of the two, at the tilts at which it is compared.
struct ComparedDesign {
  allocation::DesignResult result;
  allocation::ActuationClass actuation;
  std::vector<double> thrust_to_weight;  ///< one a point of `result`
};

/// One line of the table; `unit` is empty for counts and ratios.
struct ComparedFigure {
  std::string name, unit;
  double first = 0, second = 0;
  bool known =
      true;  ///< false: one of the two has no such figure (a tilt from which on it hovers everywhere)
};

/// The vehicle with the mass [kg] and the largest thrust [N] that were asked for; 0 keeps its own.
vehicle::Vehicle loaded(vehicle::Vehicle vehicle, double mass, double f_max);

/// The design at `alphas` [rad]; a vehicle that does not tilt is taken as it is, once for each. Without
/// alphas at the tilt at which its force in the weakest direction is largest, or, where it has none, at which
/// it lifts most. Refuses what allocation::design refuses.
Result<ComparedDesign> design_to_compare(const vehicle::Vehicle& vehicle, const std::vector<double>& alphas,
                                         double f_max, double mass);

/// What is printed of point `k` of both, in the order of the table.
std::vector<ComparedFigure> compared_figures(const ComparedDesign& first, const ComparedDesign& second,
                                             std::size_t k);

/// "omnimorph at 30 deg", or the name alone where nothing tilts.
std::string compared_name(const ComparedDesign& design, std::size_t k);

/// Schema omniflight.design_comparison/1.
nlohmann::json comparison_json(const ComparedDesign& first, const ComparedDesign& second);

/// Lines for the terminal.
std::vector<std::string> comparison_lines(const ComparedDesign& first, const ComparedDesign& second);

/// Tables and hulls: force at zero torque in newtons and over each one's weight, torque at zero force.
report::Page comparison_page(const ComparedDesign& first, const ComparedDesign& second);

}  // namespace omniflight::cli
