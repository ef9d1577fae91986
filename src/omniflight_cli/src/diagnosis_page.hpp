// The report of a diagnosis: what differs, where, why, how sure, before and after.
#pragma once

#include "compare.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::cli {

/// What was re-flown with the model found, when it was.
struct Refit {
  bool flown = false;
  std::vector<ComparedRow> before, after;  ///< simulation without and with the model, against the recording
};

/// One self-contained page. `flown` is the first recording: its path is drawn, coloured by what the model
/// does not explain.
Status write_page(const diagnosis::Diagnosis& d, const Refit& refit, const recording::Recording& flown,
                  const std::string& title, const std::string& path);

}  // namespace omniflight::cli
