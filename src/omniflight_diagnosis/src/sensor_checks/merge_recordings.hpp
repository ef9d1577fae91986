// Merging of per-recording findings.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// File, hash, duration and signals; `excluded` is left empty.
Input input_of(const recording::Recording& recording);

/// Adds findings, mismatches, effects and pairs to separate of the recording `file` to `all`. A finding that
/// another recording has already is merged: both files are listed, sentences concatenated, the larger
/// probability kept.
void merge_recording(const Diagnosis& one, const std::string& file, Diagnosis& all);

/// The answer (verdict unusable) about a recording with these objections.
Diagnosis unusable(const recording::Recording& recording, const std::vector<std::string>& against);

}  // namespace omniflight::diagnosis
