// What the page of a design says first: the answer, and the hulls of what the vehicle can exert.
#pragma once

#include <string>

#include "omniflight_allocation/feasible_set.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::cli {

/// Whether, and from which tilt on, the vehicle hovers in every attitude; `words` on its actuation below.
void design_verdict(report::Page& page, const allocation::DesignResult& design, const std::string& words);

/// Hulls of force at zero torque, with the weight as a circle, and of torque at zero force, from above and
/// from the side; at most six tilts.
void design_hulls(report::Page& page, const allocation::DesignResult& design);

}  // namespace omniflight::cli
