// What a recording's signals allow, and what those it lacks cost.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// How far a diagnosis can go.
enum class AnalysisScope {
  wrench,  ///< forces and torques against the rotors
  motors,  ///< no attitude or no force: the balance of the motors in steady flight
  sensors  ///< no motor signal: sensors and motion alone
};
AnalysisScope scope_of(const recording::Recording& recording);

/// The signals that would tell more, the most telling first.
std::vector<MissingSignal> missing_signals(const recording::Recording& recording);

}  // namespace omniflight::diagnosis
