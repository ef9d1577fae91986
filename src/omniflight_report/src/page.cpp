#include "omniflight_report/page.hpp"

#include <algorithm>

#include "assets.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_report/escape.hpp"
#include "render.hpp"

namespace omniflight::report {
namespace {

constexpr std::size_t max_numbers = 300'000;  // about 3 MB at ten characters each
constexpr std::size_t min_samples = 200;

// Even a mistake in this library could not load anything: the browser is told to refuse all of it.
constexpr const char* head =
    "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
    "<meta name=\"color-scheme\" content=\"light dark\">\n"
    "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
    "script-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'\">\n";

std::string anchor(std::size_t number) { return "section-" + std::to_string(number); }

std::string script(std::string_view code) { return "<script>" + std::string(code) + "</script>\n"; }

const char* tone_word(Tone tone) {
  switch (tone) {
    case Tone::ok:
      return "\u2713";
    case Tone::warn:
      return "!";
    case Tone::bad:
      return "\u2715";
    default:
      return "?";
  }
}

}  // namespace

const char* tone_class(Tone tone) {
  switch (tone) {
    case Tone::ok:
      return "ok";
    case Tone::warn:
      return "warn";
    case Tone::bad:
      return "bad";
    default:
      return "unknown";
  }
}

Page::Page(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

void Page::refuse(std::string what, std::string where) {
  errors_.push_back(
      Error{ErrorCode::bad_input, std::move(what), "report '" + title_ + "', " + std::move(where), {}});
}

void Page::add(Result<std::string> html) {
  if (html) {
    blocks_.emplace_back(std::move(*html));
  } else {
    const std::string section = sections_.empty() ? "the top" : "section '" + sections_.back() + "'";
    refuse(html.error().message,
           html.error().where.empty() ? section : html.error().where + " in " + section);
  }
}

Page& Page::verdict(Tone tone, const std::string& headline, const std::string& paragraph) {
  add("<div class=\"verdict " + std::string(tone_class(tone)) +
      "\"><span class=\"sign\" aria-hidden=\"true\">" + tone_word(tone) + "</span><div><h2>" +
      escape_html(headline) + "</h2><p>" + escape_html(paragraph) + "</p></div></div>\n");
  return *this;
}

Page& Page::section(const std::string& title) {
  if (depth_ > 0) {
    refuse("a section cannot start inside details", "section '" + title + "'");
    return *this;
  }
  sections_.push_back(title);
  add("<h2 class=\"section\" id=\"" + anchor(sections_.size()) + "\">" + escape_html(title) + "</h2>\n");
  return *this;
}

Page& Page::paragraph(const std::string& text) {
  add("<p class=\"text\">" + escape_html(text) + "</p>\n");
  return *this;
}

Page& Page::facts(const std::vector<Fact>& facts) {
  std::string out = "<dl class=\"facts\">";
  for (const Fact& fact : facts) {
    out += "<div><dt>" + escape_html(fact.key) + "</dt><dd>" + escape_html(fact.value);
    if (!fact.unit.empty()) out += " <span class=\"unit\">" + escape_html(fact.unit) + "</span>";
    out += "</dd></div>";
  }
  add(out + "</dl>\n");
  return *this;
}

Page& Page::table(const Table& table) {
  add(render(table).map_error([&](Error e) { return e.where = "table '" + table.caption + "'", e; }));
  return *this;
}

Page& Page::bars(const Bars& bars) {
  add(render(bars).map_error([&](Error e) { return e.where = "bars '" + bars.title + "'", e; }));
  return *this;
}

Page& Page::matrix(const Matrix& matrix) {
  add(render(matrix).map_error([&](Error e) { return e.where = "matrix '" + matrix.title + "'", e; }));
  return *this;
}

Page& Page::outlines(const Outlines& outlines) {
  add(render(outlines).map_error([&](Error e) { return e.where = "outlines '" + outlines.title + "'", e; }));
  return *this;
}

Page& Page::surfaces(const Surfaces& surfaces) {
  has_surfaces_ = true;
  add(render(surfaces).map_error([&](Error e) { return e.where = "surfaces '" + surfaces.title + "'", e; }));
  return *this;
}

Page& Page::space(const Space& space) {
  has_surfaces_ = true;
  add(render(space).map_error([&](Error e) { return e.where = "space '" + space.title + "'", e; }));
  return *this;
}

Page& Page::filter(const std::string& label) {
  if (depth_ > 0 || has_filter_) {
    refuse(depth_ > 0 ? "a filter cannot be inside details" : "a page has one filter",
           "filter '" + label + "'");
    return *this;
  }
  has_filter_ = true;
  add("<div class=\"filter\"><label for=\"filter\">" + escape_html(label) +
      "</label><input id=\"filter\" type=\"search\" autocomplete=\"off\"><output "
      "for=\"filter\"></output></div>\n");
  return *this;
}

Page& Page::equation(const std::string& latex) {
  has_equation_ = true;
  add("<div class=\"equation\">" + escape_html(latex) + "</div>\n");
  return *this;
}

Page& Page::plot(TimePlot plot) {
  if (const Status ready = prepare(plot); !ready) {
    refuse(ready.error().message, "plot '" + plot.title + "'");
  } else {
    blocks_.emplace_back(std::move(plot));
  }
  return *this;
}

Page& Page::path_plot(PathPlot plot) {
  if (const Status ready = prepare(plot); !ready) {
    refuse(ready.error().message, "path plot '" + plot.title + "'");
  } else {
    blocks_.emplace_back(std::move(plot));
  }
  return *this;
}

Page& Page::details(const std::string& summary, const std::string& text) {
  return details(summary, [&](Page& page) { page.paragraph(text); });
}

Page& Page::details(const std::string& summary, const std::function<void(Page&)>& content) {
  add("<details><summary>" + escape_html(summary) + "</summary>\n");
  ++depth_;
  content(*this);
  --depth_;
  add("</details>\n");
  return *this;
}

Result<std::string> Page::html() const {
  if (!errors_.empty()) return Failure(errors_.front());
  const auto count = [&](std::size_t samples) {
    std::size_t numbers = 0;
    for (const Block& block : blocks_) {
      if (const auto* plot = std::get_if<TimePlot>(&block)) numbers += number_count(*plot, samples);
      if (const auto* path = std::get_if<PathPlot>(&block)) numbers += number_count(*path, samples);
    }
    return numbers;
  };
  std::size_t samples = kMaxSamples;
  while (samples > min_samples && count(samples) > max_numbers)
    samples = std::max(min_samples, samples * 4 / 5);

  std::string body;
  bool plots = false, paths = false;
  for (const Block& block : blocks_) {
    if (const auto* html = std::get_if<std::string>(&block)) {
      body += *html;
    } else if (const auto* plot = std::get_if<TimePlot>(&block)) {
      plots = true;
      body += render(*plot, samples);
    } else if (const auto* path = std::get_if<PathPlot>(&block)) {
      paths = true;
      body += render(*path, samples);
    }
  }
  std::string out = head;
  out += "<title>" + escape_html(title_) + "</title>\n<style>";
  if (plots) out += assets::dygraphs_css();
  out += std::string(assets::report_css()) + "</style>\n</head>\n<body>\n<div class=\"layout\">\n";
  if (sections_.size() > 1) {
    out +=
        "<a class=\"skip\" href=\"#content\">To the content</a><nav class=\"toc\" "
        "aria-label=\"Contents\"><ol>";
    for (std::size_t i = 0; i < sections_.size(); ++i) {
      out += "<li><a href=\"#" + anchor(i + 1) + "\">" + escape_html(sections_[i]) + "</a></li>";
    }
    out += "</ol></nav>\n";
  }
  out += "<main id=\"content\">\n<header><h1>" + escape_html(title_) + "</h1><p class=\"subtitle\">" +
         escape_html(subtitle_) + "</p></header>\n";
  if (plots || paths || has_surfaces_)
    out += "<noscript><p class=\"footnote\">The plots of this page need JavaScript.</p></noscript>\n";
  out += body + "</main>\n</div>\n";
  if (plots) out += script(assets::dygraphs_js());
  if (has_equation_) out += script(assets::katex_js());
  if (has_surfaces_) out += script(assets::three_js());
  out += script(assets::report_js());
  if (plots) out += script(assets::plot_js());
  if (paths) out += script(assets::path_js());
  if (has_surfaces_) out += script(assets::surfaces_js());
  return out + "</body>\n</html>\n";
}

Status Page::write(const std::filesystem::path& path) const {
  const auto content = html();
  if (!content) return Failure(content.error());
  return files::write_file_atomic(path, *content);
}

}  // namespace omniflight::report
