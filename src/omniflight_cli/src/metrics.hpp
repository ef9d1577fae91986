// How well a flight followed its reference, as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "omniflight_report/flight_metrics.hpp"

namespace omniflight::cli {

using report::assess;
using report::FlightMetrics;
using report::kLeftReference;
using report::kTurnedAway;
using report::mechanical_power;
using report::PowerCurve;
using report::Tracking;

nlohmann::json to_json(const FlightMetrics& metrics);

}  // namespace omniflight::cli
