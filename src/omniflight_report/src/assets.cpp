#include "assets.hpp"

#define OMNIFLIGHT_ASSET(name)                                                             \
  extern "C" const char omniflight_report_##name[];                                        \
  extern "C" const char omniflight_report_##name##_end[];                                  \
  std::string_view omniflight::report::assets::name() {                                    \
    return without_source_map({omniflight_report_##name, omniflight_report_##name##_end}); \
  }

namespace {

// A source map is a second file, which a page of one file does not have.
std::string_view without_source_map(std::string_view text) {
  const auto at = text.rfind("# sourceMappingURL=");
  if (at == std::string_view::npos || at < 2 || text.size() - at > 200) return text;
  return text.substr(0, at - 2);
}

}  // namespace

OMNIFLIGHT_ASSET(dygraphs_js)
OMNIFLIGHT_ASSET(dygraphs_css)
OMNIFLIGHT_ASSET(katex_js)
OMNIFLIGHT_ASSET(report_css)
OMNIFLIGHT_ASSET(report_js)
OMNIFLIGHT_ASSET(plot_js)
OMNIFLIGHT_ASSET(path_js)
OMNIFLIGHT_ASSET(three_js)
OMNIFLIGHT_ASSET(surfaces_js)
