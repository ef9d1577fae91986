// The page of one flight: how it ended, how it tracked, what the rotors had to give, and what to do next.
#pragma once

#include "flight.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::cli {

/// Writes one self-contained page. options and result as fly() has them, the recording of the flight, and the
/// vehicle that was to be flown.
Status write_flight_page(const FlightOptions& options, const FlightResult& result,
                         const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                         const std::string& path);

}  // namespace omniflight::cli
