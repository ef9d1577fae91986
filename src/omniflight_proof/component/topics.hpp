// Names of the topics of a flight, as every component knows them (test_independence.cpp holds them against
// omniflight_components, which this package must not link).
#pragma once

namespace omniflight::proof::topics {

inline constexpr const char* imu = "/omniflight/imu";
inline constexpr const char* mocap = "/omniflight/mocap";
inline constexpr const char* rotors = "/omniflight/rotors";
inline constexpr const char* battery = "/omniflight/battery";
inline constexpr const char* tick = "/omniflight/tick";
inline constexpr const char* truth = "/omniflight/truth";
inline constexpr const char* command = "/omniflight/command";
inline constexpr const char* recorder = "/omniflight/recorder";

}  // namespace omniflight::proof::topics
