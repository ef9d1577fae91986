// Check of the controller: gains estimated from the logged command against the told gains.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Regresses, per axis and below 4 Hz, the logged command `qddr` minus the reference acceleration on error,
/// its rate and its integral: position in world, attitude in body axes. Adds controller_mismatch with the
/// gains that differ from the told ones by more than four standard errors and 15 % (integral: 50 %; more
/// where the fit is worse or signals are late), and sets Diagnosis::controller to the estimated gains. Adds
/// nothing where reference, command or state is not logged, or where less than 80 % of the command's variance
/// is explained (another control law). `attitude_free`: the recorded reference alone commands the attitude.
/// An underactuated vehicle takes it from its position loop instead, so that its attitude gains cannot be
/// estimated here.
void add_control(const recording::Recording& recording, const ToldController& told, Diagnosis& diagnosis,
                 bool attitude_free = true);

/// add_control() for every recording, equal findings merged. Diagnosis::controller is that of the first
/// recording, which is the one that the closed-loop simulation repeats.
void add_controls(const std::vector<const recording::Recording*>& recordings, const ToldController& told,
                  Diagnosis& diagnosis, bool attitude_free = true);

}  // namespace omniflight::diagnosis
