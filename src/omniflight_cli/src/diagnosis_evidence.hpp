// The chain of evidence of a diagnosis, a line a question, and the flight that it proposes, as a picture.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::cli {

struct Evidence {
  std::string question, answer;
};

/// What differs most, what is left of it with what is named, whether that holds on data that no fit has
/// touched, whether it predicts the motion, and what else was asked. Questions without an answer in this
/// diagnosis are left out; all are where nothing differs, and of
/// an answer that is not finished or names no model.
std::vector<Evidence> evidence(const diagnosis::Diagnosis& d);

/// Every effect that was asked, with the outcome; kept ones first, then the nearest to being kept.
report::Table asked_effects(const diagnosis::Diagnosis& d);

/// Way of the proposed flight in the world, coloured by how far the vehicle leans from level [deg]; none
/// without a proposal.
std::optional<report::PathPlot> next_flight_path(const diagnosis::NextFlight& next);

/// What to fly next, with its picture and what it would separate; nothing without manoeuvres.
void add_next_flight(report::Page& page, const diagnosis::NextFlight& next);

}  // namespace omniflight::cli
