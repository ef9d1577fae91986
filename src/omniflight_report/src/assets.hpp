// Files that were put into the library when it was built (CMakeLists.txt, assets.S).
#pragma once

#include <string_view>

namespace omniflight::report::assets {

std::string_view dygraphs_js();
std::string_view dygraphs_css();
std::string_view katex_js();
std::string_view report_css();
std::string_view report_js();
std::string_view plot_js();
std::string_view path_js();
std::string_view three_js();
std::string_view surfaces_js();

}  // namespace omniflight::report::assets
