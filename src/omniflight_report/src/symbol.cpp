// Symbols as the effect library writes them ("lambda", "h_0", "dm", "C_D d"), typeset for a table's cell.
#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "omniflight_report/escape.hpp"
#include "render.hpp"

namespace omniflight::report {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 18> kGreek{{{"alpha", "\u03b1"},
                                                                                {"beta", "\u03b2"},
                                                                                {"gamma", "\u03b3"},
                                                                                {"delta", "\u03b4"},
                                                                                {"eps", "\u03b5"},
                                                                                {"zeta", "\u03b6"},
                                                                                {"eta", "\u03b7"},
                                                                                {"theta", "\u03b8"},
                                                                                {"kappa", "\u03ba"},
                                                                                {"lambda", "\u03bb"},
                                                                                {"mu", "\u03bc"},
                                                                                {"rho", "\u03c1"},
                                                                                {"sigma", "\u03c3"},
                                                                                {"tau", "\u03c4"},
                                                                                {"chi", "\u03c7"},
                                                                                {"psi", "\u03c8"},
                                                                                {"omega", "\u03c9"},
                                                                                {"Omega", "\u03a9"}}};

/// A name without its subscript. "dm", "dJ" and "dr" are changes of m, J and r.
std::string letter(std::string_view name) {
  for (const auto& [spelt, greek] : kGreek)
    if (name == spelt) return std::string(greek);
  if (name == "dm" || name == "dJ" || name == "dr") return "\u0394" + std::string(name.substr(1));
  return escape_html(name);
}

std::string factor(std::string_view name) {
  const std::size_t at = name.find('_');
  const std::string_view base = name.substr(0, at);
  const bool number = base.find_first_not_of("0123456789.") == std::string_view::npos;
  std::string out = number || base == "-" ? letter(base) : "<i>" + letter(base) + "</i>";
  if (at != std::string_view::npos) out += "<sub>" + letter(name.substr(at + 1)) + "</sub>";
  return out;
}

}  // namespace

std::string symbol_html(std::string_view symbol) {
  std::string out;
  for (std::size_t begin = 0; begin <= symbol.size();) {
    const std::size_t end = std::min(symbol.find(' ', begin), symbol.size());
    if (end > begin) out += (out.empty() ? "" : " ") + factor(symbol.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

}  // namespace omniflight::report
