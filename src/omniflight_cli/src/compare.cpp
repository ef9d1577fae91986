#include "compare.hpp"

#include <fmt/format.h>

#include <cmath>

namespace omniflight::cli {
namespace {

// Ratios that two flights of one vehicle and one model have of themselves, by their noise and their battery.
constexpr double kAlikeError = 1.25, kAlikePower = 1.05;

}  // namespace

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

void add_headline(report::Page& page, const std::vector<ComparedRow>& rows) {
  const ComparedRow *axis = nullptr, *power = nullptr;
  for (const ComparedRow& r : rows) {
    if (!(r.ratio() > 0) || !std::isfinite(r.ratio())) continue;
    if (r.channel.starts_with("RMSE ") &&
        (!axis || std::abs(std::log(r.ratio())) > std::abs(std::log(axis->ratio()))))
      axis = &r;
    if (r.channel == "mean power") power = &r;
  }
  if (!axis) return;
  const double strays = axis->ratio(), takes = power ? power->ratio() : 1.0;
  const bool same_error = strays < kAlikeError && strays > 1 / kAlikeError,
             same_power = takes < kAlikePower && takes > 1 / kAlikePower;
  const std::string name = axis->channel.substr(5);
  std::string words = same_error
                          ? "Both flights track alike"
                          : fmt::format("The recorded flight strays {:.2g} times as far in {}", strays, name);
  words += same_power ? (same_error ? " and take the same power" : ", at the same power")
                      : fmt::format("{} takes {:.2f} times the power",
                                    same_error ? ", and the recorded one" : " and", takes);
  std::string figures = fmt::format("{}: RMSE {:.3g} {} simulated, {:.3g} {} recorded.", name,
                                    axis->simulated, axis->unit, axis->real, axis->unit);
  if (power)
    figures +=
        fmt::format(" Mean power: {:.4g} W simulated, {:.4g} W recorded.", power->simulated, power->real);
  if (!same_error || !same_power) figures += " omniflight diagnose looks for the physics behind it.";
  page.verdict(same_error && same_power ? report::Tone::ok : report::Tone::warn, words, figures);
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
