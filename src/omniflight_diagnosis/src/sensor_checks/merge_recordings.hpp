// What each of several recordings says of its own sensors, told once.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// File, hash, duration and signals; what was cut out is added by whoever cut it.
Input input_of(const recording::Recording& recording);

/// Adds findings, mismatches and the pairs to separate that one recording shows. What another one has shown
/// already becomes the same finding, with both named and the words of both; its effects join the model once.
void merge_recording(const Diagnosis& one, const std::string& file, Diagnosis& all);

/// The answer about a recording that cannot be believed.
Diagnosis unusable(const recording::Recording& recording, const std::vector<std::string>& against);

}  // namespace omniflight::diagnosis
