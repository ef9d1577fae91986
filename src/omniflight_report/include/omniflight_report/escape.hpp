// Text and numbers on their way into a page. All input may be hostile.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace omniflight::report {

/// Safe as element content and inside a double-quoted attribute. Invalid UTF-8 and control characters become
/// U+FFFD.
std::string escape_html(std::string_view text);
/// A quoted JSON string that is safe inside a script element.
std::string json_string(std::string_view text);
/// A JSON array. Numbers are rounded to 1e-6 of their range; what is not finite becomes null.
std::string json_array(std::span<const double> values);
/// A number for people, as HTML: significant digits, powers of ten beyond 1e-3..1e6, an en dash when not a
/// number.
std::string number_html(double value, int significant_digits = 4);

}  // namespace omniflight::report
