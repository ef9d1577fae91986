// The formats, one .cpp each; a new one is its file, a declaration here and a line in formats.cpp.
#pragma once

#include "omniflight_recording/formats.hpp"

namespace omniflight::recording {

const Format& mcap_format();
const Format& ulog_format();
const Format& rosbag1_format();
const Format& rosbag2_format();
const Format& microsd_format();
const Format& genom3_format();
const Format& csv_format();

}  // namespace omniflight::recording
