// The HTML of each kind of block. A failure names what is wrong; the page adds where.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "omniflight_core/result.hpp"
#include "omniflight_report/blocks.hpp"

namespace omniflight::report {

inline constexpr std::size_t kMaxSamples = 3000;  ///< of one series, about three a pixel

const char* tone_class(Tone tone);

/// A symbol in plain letters, typeset: "eps_kappa" with Greek letters and a subscript. Anything else is shown
/// as it is, escaped.
std::string symbol_html(std::string_view symbol);

Result<std::string> render(const Table& table);
Result<std::string> render(const Bars& bars);
Result<std::string> render(const Matrix& matrix);
Result<std::string> render(const Outlines& outlines);
Result<std::string> render(const Surfaces& surfaces);
Result<std::string> render(const Space& space);

/// Checks the lengths, sorts by x, drops samples without x.
Status prepare(TimePlot& plot);
Status prepare(PathPlot& plot);
/// Numbers a plot will write, when no series keeps more than `samples`.
std::size_t number_count(const TimePlot& plot, std::size_t samples);
std::size_t number_count(const PathPlot& plot, std::size_t samples);
std::string render(const TimePlot& plot, std::size_t samples);
std::string render(const PathPlot& plot, std::size_t samples);

}  // namespace omniflight::report
