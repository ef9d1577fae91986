// Which analysis the signals of a recording allow, and what the missing ones prevent.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Analyses that a recording allows.
enum class AnalysisScope {
  wrench,  ///< wrench residual: motor signal, attitude and a signal of the translation
  motors,  ///< motor signal without attitude or translation: balance of the motors in hover
  sensors  ///< no motor signal: sensors and kinematics only
};
AnalysisScope scope_of(const recording::Recording& recording);

/// Missing signals and the consequence of each, most informative first.
std::vector<MissingSignal> missing_signals(const recording::Recording& recording);

}  // namespace omniflight::diagnosis
