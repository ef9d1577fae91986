// Two flights side by side, laid out as Table 7.1 of the thesis.
#pragma once

#include "metrics.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::cli {

using report::compare;
using report::ComparedRow;

report::Table comparison_table(const std::vector<ComparedRow>& rows, const std::string& caption);
nlohmann::json to_json(const std::vector<ComparedRow>& rows);
/// Lines for a terminal.
std::string to_text(const std::vector<ComparedRow>& rows);
/// What a reader should know first: how far the recorded flight strays beyond the simulated one, in the
/// axis that differs most, and what power it takes.
void add_headline(report::Page& page, const std::vector<ComparedRow>& rows);
/// Tracking errors of one flight over time, thinned by the page.
void plot_tracking(report::Page& page, const FlightMetrics& metrics, const std::string& name);

}  // namespace omniflight::cli
