// One HTML page in one file: no network, no files beside it. Scripts (dygraphs, KaTeX, three.js) are inside
// when they are needed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_report/blocks.hpp"

namespace omniflight::report {

/// Builds a page from top to bottom. All text is escaped. Errors of use (vectors of different lengths, a row
/// that is too short) are kept and returned by html() and write(), so that calls can be chained.
class Page {
 public:
  Page(std::string title, std::string subtitle);

  Page& verdict(Tone tone, const std::string& headline, const std::string& paragraph);
  /// Starts a section and adds it to the table of contents. Not inside details.
  Page& section(const std::string& title);
  /// A field that hides the sections behind it that do not have all words typed into it; one a page.
  Page& filter(const std::string& label);
  Page& paragraph(const std::string& text);
  Page& facts(const std::vector<Fact>& facts);
  Page& table(const Table& table);
  Page& bars(const Bars& bars);
  Page& matrix(const Matrix& matrix);
  Page& outlines(const Outlines& outlines);
  /// Drawn with three.js, which makes the page larger by 0.9 MB; what cannot be drawn in space is told in
  /// words.
  Page& surfaces(const Surfaces& surfaces);
  Page& space(const Space& space);
  /// LaTeX source as KaTeX reads it, shown as MathML; what cannot be read is shown as it is written.
  Page& equation(const std::string& latex);
  /// Zoomable plot. At most 3000 samples a series are kept, extremes and gaps among them; the page says so.
  Page& plot(TimePlot plot);
  Page& path_plot(PathPlot plot);
  /// Folded content.
  Page& details(const std::string& summary, const std::string& text);
  Page& details(const std::string& summary, const std::function<void(Page&)>& content);

  /// The whole page. Plots are thinned further when the page would grow beyond about 4 MB.
  /// Errors: bad_input naming the block that cannot be shown.
  Result<std::string> html() const;
  /// html() into a file: written beside it, then renamed, so that the path holds the old page or the whole
  /// new one.
  Status write(const std::filesystem::path& path) const;

 private:
  using Block = std::variant<std::string, TimePlot, PathPlot>;
  void add(Result<std::string> html);
  void refuse(std::string what, std::string where);

  std::string title_, subtitle_;
  std::vector<Block> blocks_;
  std::vector<std::string> sections_;
  std::vector<Error> errors_;
  int depth_ = 0;  // of open details
  bool has_equation_ = false, has_filter_ = false, has_surfaces_ = false;
};

}  // namespace omniflight::report
