// Logs in the axes of aviation: world north, east, down; body forward, right, down.
#pragma once

#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

/// Turns every vector and attitude of a recording from NED and FRD to east, north, up and forward, left, up
/// (REP-103), in place, and adds a note. Errors (bad_input), with nothing changed: a signal that its map has
/// converted already, or of another width than its name says.
Status turn_from_ned(Recording& recording);

}  // namespace omniflight::recording
