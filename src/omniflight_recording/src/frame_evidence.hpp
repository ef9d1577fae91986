// Whether the signals of a log are in the axes that they are said to be in, by what must hold between them.
#pragma once

#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

/// Adds a note where signals contradict each other in their axes:
///   - the mean specific force, turned into the world by the attitude, must point up (it carries the weight),
///   - the velocity must be the derivative of the position, axis by axis,
///   - the gyro must be the rate of the attitude, axis by axis.
/// Nothing is changed: a map says what is right. Signals that hardly move are not judged.
void note_frame_evidence(Recording& recording);

}  // namespace omniflight::recording
