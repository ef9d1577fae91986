// `fly --tilt lookahead`: the tilt over the whole plan, before it is flown.
#pragma once

#include "flight_setup.hpp"

namespace omniflight::cli {

/// Fills setup.schedule where the options ask for it. Refuses plants and plans that cannot follow one.
Status find_schedule(const FlightOptions& options, Setup& setup);

}  // namespace omniflight::cli
