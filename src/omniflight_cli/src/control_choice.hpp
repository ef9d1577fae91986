// The control law of a flight: by the vehicle's actuation, or as asked.
#pragma once

#include "flight_setup.hpp"

namespace omniflight::cli {

/// Parameters of the controller that follow from the vehicle and the plan: law, thrust axis, lean limit, and
/// the gains of laws that lean. What the operator gives with -p comes on top.
std::map<std::string, std::string> control_parameters(const FlightOptions& options, const Setup& setup);

/// A vector as YAML in brackets, to ten digits.
std::string in_brackets(const Vec3& v);

/// Refuses dynamic weights with gains that are too soft for them.
Status check_weights(const FlightOptions& options, const Setup& setup);
/// Refuses a law that is not known or cannot fly the plan's vehicle.
Status check_law(const FlightOptions& options, const Setup& setup);

/// The gains that a diagnosis is told, as YAML in braces: of `kp e + kv de/dt + ki integral(e)`, and likewise
/// of the attitude. Empty for a law that is none of these.
Result<std::string> told_gains(const FlightOptions& options, const Setup& setup);

}  // namespace omniflight::cli
