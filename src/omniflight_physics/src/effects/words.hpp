// Sizes in words, for what effects tell a pilot. Signs are left to words such as "more" and "less".
#pragma once

#include <string>

#include "omniflight_physics/pilot_words.hpp"

namespace omniflight::physics {

std::string two_digits(double x);      ///< significant ones: "0.12"
std::string hundredths(double x);      ///< "1.06"
std::string in_mass(double kg);        ///< "2.7 g", "0.28 kg"
std::string in_length(double m);       ///< "12 mm", "1.06 m"
std::string in_degrees(double rad);    ///< "3.2 deg"
std::string in_percent(double share);  ///< "12 %"

/// One of two words, by the sign; the second at 0.
const char* by_sign(double x, const char* when_positive, const char* otherwise);

/// Magnitude of the vector whose components have these names.
double norm_of(const KnownValues& v, const char* x, const char* y, const char* z);

/// "12 mm forward, 3 mm to the left": x, y, z along body axes (x forward, y left, z up); components below a
/// fifth of the whole are left out.
std::string along_body(const KnownValues& v);

/// " from 1.06 m up", where the `start_height` of a cable is known; else nothing.
std::string from_height(const KnownValues& v);

}  // namespace omniflight::physics
