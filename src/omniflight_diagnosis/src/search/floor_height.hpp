// How far below a standing vehicle its floor is.
#pragma once

#include <optional>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// A recording shows where the vehicle stood, not how far the floor is below that, and the ground effect
/// depends on it. The distance [m], between 0.3 and 1.6 radii of a rotor and the same in all flights, under
/// which the ground effect explains them best; empty where none was seen standing, where the floor is told,
/// or where none explains them clearly better than the 0.3 radii that a flight is prepared with.
std::optional<double> hub_height(const std::vector<Flight>& flights, const vehicle::Vehicle& vehicle,
                                 const Options& options);

/// Moves the floor that far below where the vehicle stood, and notes it; a flight that never stood, or was
/// told its floor, stays as it is.
void set_floor_height(double hub_height, Flight& flight);

}  // namespace omniflight::diagnosis
