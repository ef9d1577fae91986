// The manoeuvres of the families, to the scale of each vehicle.
#pragma once

#include "case_path.hpp"
#include "family_vehicle.hpp"

namespace omniflight::proof {

/// Manoeuvre where.manoeuvre over `lead` + where.length seconds; what comes before `lead` is not recorded.
/// vigour scales speeds and excursions. A start "in flight" is lively before the recording begins.
Path family_path(const Coordinates& where, const FamilyVehicle& vehicle, double lead, double vigour,
                 BoxRandom& random);

}  // namespace omniflight::proof
