// Reference to controller: what the told gains would have asked for on the recorded state.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Fits, axis by axis below 4 Hz, the gains on error, its rate and its integral that the logged command
/// `qddr` follows beyond the reference's own acceleration: position in the world, attitude in the body. Names
/// controller_mismatch with the gains that differ from the told ones by more than 10 % and four standard
/// errors, and sets Diagnosis::controller to what was flown. Adds nothing where the reference, the command or
/// the state is not logged, or where the command follows another law (less than 80 % of it is explained).
/// `attitude_free`: the attitude is commanded by the recorded reference alone. That of a vehicle whose rotors
/// push along one axis follows from its position loop instead, so that its attitude gains cannot be replayed.
void add_control(const recording::Recording& recording, const ToldController& told, Diagnosis& diagnosis,
                 bool attitude_free = true);
/// At the tilts that were flown, where they were recorded.
bool attitude_is_free(const vehicle::Vehicle& vehicle,
                      const std::vector<const recording::Recording*>& recordings);

/// The same of every recording: what several show is one finding. Diagnosis::controller is that of the first,
/// which is flown again.
void add_controls(const std::vector<const recording::Recording*>& recordings, const ToldController& told,
                  Diagnosis& diagnosis, bool attitude_free = true);

}  // namespace omniflight::diagnosis
