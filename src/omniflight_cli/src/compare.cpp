#include "compare.hpp"

#include <fmt/format.h>

namespace omniflight::cli {

report::Table comparison_table(const std::vector<ComparedRow>& rows, const std::string& caption) {
  report::Table t;
  t.caption = caption;
  t.columns = {{.name = "channel"},
               {.name = "unit"},
               {.name = "simulated"},
               {.name = "recorded"},
               {.name = "ratio", .significant_digits = 3}};
  for (const auto& r : rows) {
    const report::Cell ratio =
        r.ratio() > 0 ? report::Cell(r.ratio(), r.ratio()) : report::Cell(std::string("-"));
    t.rows.push_back({report::Cell(r.channel), report::Cell(r.unit), report::Cell(r.simulated),
                      report::Cell(r.real), ratio});
  }
  return t;
}

nlohmann::json to_json(const std::vector<ComparedRow>& rows) {
  nlohmann::json out = nlohmann::json::array();
  for (const auto& r : rows)
    out.push_back({{"channel", r.channel},
                   {"unit", r.unit},
                   {"simulated", r.simulated},
                   {"real", r.real},
                   {"ratio", r.ratio()}});
  return out;
}

std::string to_text(const std::vector<ComparedRow>& rows) {
  std::string out = fmt::format("  {:32} {:>11} {:>12} {:>12} {:>8}\n", "channel", "unit", "simulated",
                                "recorded", "ratio");
  for (const auto& r : rows)
    out += fmt::format("  {:32} {:>11} {:>12.5f} {:>12.5f} {:>8.3f}\n", r.channel, r.unit, r.simulated,
                       r.real, r.ratio());
  return out;
}

void plot_tracking(report::Page& page, const FlightMetrics& m, const std::string& name) {
  const auto series = [&](const std::vector<std::string>& names, int first) {
    std::vector<report::Series> out;
    for (int k = 0; k < 3; ++k) {
      report::Series s;
      s.name = names[static_cast<std::size_t>(k)];
      s.x = m.measured.t;
      s.y.assign(m.measured.error.col(first + k).data(),
                 m.measured.error.col(first + k).data() + m.measured.error.rows());
      out.push_back(std::move(s));
    }
    return out;
  };
  page.plot({.title = "Position error, " + name,
             .y_label = "error [m]",
             .series = series({"x", "y", "z"}, 0),
             .group = name});
  page.plot({.title = "Attitude error, " + name,
             .y_label = "error [deg]",
             .series = series({"roll", "pitch", "yaw"}, 3),
             .group = name});
}

}  // namespace omniflight::cli
