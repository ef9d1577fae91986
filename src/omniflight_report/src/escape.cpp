#include "omniflight_report/escape.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace omniflight::report {
namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";  // U+FFFD

// Length of the well-formed UTF-8 sequence at the start of text, 0 when there is none.
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return 0;
  std::uint32_t code = lead & (0xFFu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
    code = (code << 6) | (byte(i) & 0x3Fu);
  }
  const std::array<std::uint32_t, 5> smallest = {0, 0, 0x80, 0x800, 0x10000};
  if (code < smallest[length] || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF)) return 0;
  return length;
}

// Calls ascii(char) for each ASCII character that is text, and copies well-formed sequences.
template <class F>
std::string transform(std::string_view text, F&& ascii) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = sequence_length(text.substr(i));
    const auto c = static_cast<unsigned char>(text[i]);
    if (length > 1) {
      out.append(text.substr(i, length));
    } else if (length == 0 || (c < 0x20 && c != '\n' && c != '\t') || c == 0x7F) {
      out.append(replacement);
    } else {
      ascii(out, text[i]);
    }
    i += std::max<std::size_t>(length, 1);
  }
  return out;
}

std::string printed(double value, int digits) {
  std::array<char, 64> buffer{};
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, digits);
  return {buffer.data(), end.ptr};
}

}  // namespace

std::string escape_html(std::string_view text) {
  return transform(text, [](std::string& out, char c) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  });
}

std::string json_string(std::string_view text) {
  return '"' +
         transform(text,
                   [](std::string& out, char c) {
                     switch (c) {
                       case '"':
                         out += "\\\"";
                         break;
                       case '\\':
                         out += "\\\\";
                         break;
                       case '\n':
                         out += "\\n";
                         break;
                       case '\t':
                         out += "\\t";
                         break;
                       case '<':
                         out += "\\u003c";
                         break;  // no </script> and no <!-- in a script element
                       case '>':
                         out += "\\u003e";
                         break;
                       case '&':
                         out += "\\u0026";
                         break;
                       default:
                         out += c;
                     }
                   }) +
         '"';
}

std::string json_array(std::span<const double> values) {
  double low = INFINITY, high = -INFINITY;
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  // A large offset (a time since 1970) needs more digits for the same resolution of the range.
  const double range = high - low, magnitude = std::max(std::abs(low), std::abs(high));
  int digits = 7;
  if (std::isfinite(range) && range > 0.0)
    digits = 7 + static_cast<int>(std::ceil(std::log10(magnitude / range)));
  digits = std::clamp(digits, 6, 17);
  const double floor = range > 0.0 && std::isfinite(range) ? 1e-7 * range : 0.0;
  std::string out = "[";
  for (const double v : values) {
    if (out.size() > 1) out += ',';
    out += !std::isfinite(v) ? "null" : std::abs(v) < floor ? "0" : printed(v, digits);
  }
  return out + "]";
}

std::string number_html(double value, int significant_digits) {
  if (std::isnan(value)) return "<span class=\"missing\" title=\"not available\">\u2013</span>";
  if (std::isinf(value)) return value > 0 ? "\u221E" : "-\u221E";
  const int digits = std::clamp(significant_digits, 1, 15);
  if (value == 0.0) return "0";
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.*e", digits - 1,
                value);  // rounds before the magnitude is judged
  const std::string scientific = buffer.data();
  const auto e = scientific.find('e');
  const int exponent = std::stoi(scientific.substr(e + 1));
  if (exponent >= -3 && exponent < 6) {
    std::snprintf(buffer.data(), buffer.size(), "%.*f", std::max(0, digits - 1 - exponent), value);
    return buffer.data();
  }
  return scientific.substr(0, e) + "\u00D710<sup>" + std::to_string(exponent) + "</sup>";
}

}  // namespace omniflight::report
