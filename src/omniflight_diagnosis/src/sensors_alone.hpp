// Recordings in which no wrench can be judged: what their sensors are worth, and what to record next time.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Everything that one recording tells of its sensors without a model of the rotors: signals, clocks, noise,
/// gaps, what freezes, what is read at rest, signals that tell of one motion against each other, and the
/// force the motion needs.
Diagnosis judge_sensors_of(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                           const Options& options);

/// The answer for such recordings: unusable for physics, sensors judged. `why` says what stands in the way.
Diagnosis diagnose_sensors(std::span<const recording::Recording> flown, const vehicle::Vehicle& vehicle,
                           const Options& options, const std::string& why);

/// What hinders a wrench analysis of signals like these, in words.
std::string missing_reason(const recording::Recording& recording);

}  // namespace omniflight::diagnosis
