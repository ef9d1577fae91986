// The gallery page: what each effect does to wrench, rotor speeds, tracking and power against the nominal
// flight.
#include <fmt/format.h>

#include "omniflight_report/page.hpp"
#include "verb_effects.hpp"

namespace omniflight::cli {
namespace {

std::vector<double> column(const Eigen::MatrixXd& m, Eigen::Index k) {
  std::vector<double> out;
  if (k < m.cols()) out.assign(m.col(k).begin(), m.col(k).end());
  return out;
}

/// Largest norm of `size` columns from `first` on, rows that are not finite left out.
double peak(const Eigen::MatrixXd& m, Eigen::Index first, Eigen::Index size) {
  double largest = 0;
  if (first + size > m.cols()) return 0;
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    if (m.row(i).segment(first, size).allFinite())
      largest = std::max(largest, m.row(i).segment(first, size).norm());
  return largest;
}

std::string percent(double value, double nominal) {
  if (!(nominal > 0) || !std::isfinite(value)) return "-";
  const double change = 100 * (value / nominal - 1);
  return fmt::format("{:+.1f} %", std::abs(change) < 0.05 ? 0.0 : change);  // no "-0.0 %"
}

/// Rotor speeds less those of the nominal flight at the same time, over the time both have.
Eigen::MatrixXd speed_change(const GalleryFlight& f, const GalleryFlight& nominal) {
  const Eigen::Index n = std::min(f.rotor_speed.rows(), nominal.rotor_speed.rows());
  return f.rotor_speed.topRows(n) - nominal.rotor_speed.topRows(n);
}

std::string in_words(const GalleryFlight& f, const GalleryFlight& nominal) {
  if (f.t.empty()) return "No recording: " + f.reason;
  std::string out = fmt::format(
      "On this flight: force up to {:.3g} N, torque up to {:.3g} Nm; position RMSE {:.4f} m (nominal {:.4f} "
      "m), "
      "attitude RMSE {:.3f} deg ({:.3f} deg), mean power {:.1f} W ({}).",
      peak(f.wrench, 0, 3), peak(f.wrench, 3, 3), f.position_rmse, nominal.position_rmse, f.attitude_rmse,
      nominal.attitude_rmse, f.mean_power, percent(f.mean_power, nominal.mean_power));
  if (f.verdict != "flown") out += " " + f.verdict + ": " + f.reason + ".";
  return out;
}

report::TimePlot plot(const std::string& title, const std::string& label, const GalleryFlight& f) {
  return {.title = title, .y_label = label, .height_px = 200, .group = f.effect->info().id};
}

void add_columns(report::TimePlot& plot, const std::vector<double>& t, const Eigen::MatrixXd& m,
                 std::initializer_list<const char*> names, Eigen::Index first, const std::string& suffix = "",
                 bool dashed = false) {
  for (const char* name : names) {
    auto y = column(m, first++);
    if (y.empty()) continue;
    std::vector<double> x(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(std::min(t.size(), y.size())));
    plot.series.push_back({.name = name + suffix, .x = std::move(x), .y = std::move(y), .dashed = dashed});
  }
}

void plots(report::Page& page, const GalleryFlight& f, const GalleryFlight& nominal) {
  auto force = plot("Force of the effect on the vehicle, body axes", "force [N]", f);
  add_columns(force, f.t, f.wrench, {"Fx", "Fy", "Fz"}, 0);
  auto torque = plot("Torque of the effect, body axes", "torque [Nm]", f);
  add_columns(torque, f.t, f.wrench, {"Mx", "My", "Mz"}, 3);
  auto speed = plot("Rotor speeds less nominal", "speed difference [rad/s]", f);
  const Eigen::MatrixXd change = speed_change(f, nominal);
  for (Eigen::Index k = 0; k < change.cols(); ++k) {
    const std::string name = "rotor " + std::to_string(k + 1);
    add_columns(speed, f.t, change, {name.c_str()}, k);
  }
  auto position = plot("Tracking: true position less reference, world axes", "error [m]", f);
  add_columns(position, f.t, f.position, {"x", "y", "z"}, 0);
  add_columns(position, nominal.t, nominal.position, {"z"}, 2, " nominal", true);
  auto attitude = plot("Tracking: true attitude less reference, body axes", "error [deg]", f);
  add_columns(attitude, f.t, f.attitude, {"roll", "pitch", "yaw"}, 0);
  auto power = plot("Mechanical power of the rotors", "power [W]", f);
  power.series.push_back({.name = "with the effect", .x = f.t, .y = f.power});
  power.series.push_back({.name = "nominal", .x = nominal.t, .y = nominal.power, .dashed = true});
  const auto& info = f.effect->info();
  const bool sensing =
      info.stage == physics::Stage::sensing ||
      std::find(info.also.begin(), info.also.end(), physics::Stage::sensing) != info.also.end();
  if (!sensing || peak(f.wrench, 0, 6) > 0) page.plot(force).plot(torque);
  page.plot(speed).plot(position).plot(attitude).plot(power);
  if (sensing && f.sensed.cols() > 0) {
    auto sensed = plot("What motion capture shows less the true position, world axes", "difference [m]", f);
    add_columns(sensed, f.t, f.sensed, {"x", "y", "z"}, 0);
    page.plot(sensed);
  }
}

void overview(report::Page& page, const std::vector<GalleryFlight>& flights) {
  const GalleryFlight& nominal = flights.front();
  report::Table table;
  table.caption = "Each effect at its typical values; the colour compares with the nominal flight";
  table.columns = {{.name = "effect"},
                   {.name = "acts at"},
                   {.name = "force, peak", .unit = "N"},
                   {.name = "torque, peak", .unit = "Nm"},
                   {.name = "rotor speed change, RMS", .unit = "rad/s"},
                   {.name = "position RMSE", .unit = "m"},
                   {.name = "attitude RMSE", .unit = "deg"},
                   {.name = "mean power", .unit = "W"},
                   {.name = "flight"}};
  report::Bars force{.title = "Largest force of the effect", .unit = "N"};
  report::Bars power{
      .title = "Mean power", .unit = "W", .marker = nominal.mean_power, .marker_label = "nominal"};
  const auto compared = [](double value, double reference) {
    return reference > 0 && std::isfinite(value) ? report::Cell(value, value / reference)
                                                 : report::Cell(value);
  };
  for (const GalleryFlight& f : flights) {
    const std::string id = f.effect ? f.effect->info().id : "none (nominal)";
    const Eigen::MatrixXd change = speed_change(f, nominal);
    double square = 0;
    Eigen::Index used = 0;
    for (Eigen::Index i = 0; i < change.rows(); ++i)
      if (change.row(i).allFinite()) square += change.row(i).squaredNorm(), used += change.cols();
    table.rows.push_back(
        {report::Cell(id), report::Cell(f.effect ? to_string(f.effect->info().stage) : "-"),
         report::Cell(peak(f.wrench, 0, 3)), report::Cell(peak(f.wrench, 3, 3)),
         report::Cell(used > 0 ? std::sqrt(square / static_cast<double>(used)) : std::nan("")),
         compared(f.position_rmse, nominal.position_rmse), compared(f.attitude_rmse, nominal.attitude_rmse),
         compared(f.mean_power, nominal.mean_power),
         report::Cell(f.reason.empty() ? f.verdict : f.verdict + ": " + f.reason)});
    if (!f.effect) continue;
    if (peak(f.wrench, 0, 3) > 0) force.bars.push_back({.name = id, .value = peak(f.wrench, 0, 3)});
    if (std::isfinite(f.mean_power) && f.mean_power > 0)
      power.bars.push_back(
          {.name = id, .value = f.mean_power, .note = percent(f.mean_power, nominal.mean_power)});
  }
  page.section("All effects").table(table);
  if (!force.bars.empty()) page.bars(force);
  if (!power.bars.empty()) page.bars(power);
}

}  // namespace

Status write_gallery(const std::vector<GalleryFlight>& flights, const std::string& mission,
                     const std::string& path) {
  const GalleryFlight& nominal = flights.front();
  report::Page page(
      "Gallery of effects",
      fmt::format("{} flown once for each of {} effects at typical values, ideal sensors, simulated plant",
                  mission, flights.size() - 1));
  page.paragraph(fmt::format(
      "Controller and allocator know nothing of the effect. The wrench is what the plant applied, position "
      "and attitude "
      "are true ones. Nominal: position RMSE {:.4f} m, attitude RMSE {:.3f} deg, mean power {:.1f} W.",
      nominal.position_rmse, nominal.attitude_rmse, nominal.mean_power));
  page.filter("Filter by words: an effect, a stage, a signal (key /)");
  overview(page, flights);
  for (const GalleryFlight& f : flights) {
    if (!f.effect) continue;
    const auto& info = f.effect->info();
    page.section(info.id)
        .paragraph(fmt::format("{}. Acts at: {}. {}", info.term, to_string(info.stage), in_words(f, nominal)))
        .equation(info.latex);
    report::Table values;
    values.columns = {
        {.name = "parameter"}, {.name = "symbol", .symbols = true}, {.name = "flown with"}, {.name = "unit"}};
    for (const auto& p : info.parameters)
      values.rows.push_back({report::Cell(p.name), report::Cell(p.symbol), report::Cell(p.typical),
                             report::Cell(p.unit == "1" ? "-" : p.unit)});
    if (values.rows.size() > 8)
      page.details(fmt::format("{} parameters", values.rows.size()),
                   [&](report::Page& p) { p.table(values); });
    else if (!values.rows.empty())
      page.table(values);
    if (!f.t.empty())
      page.details("Wrench, rotor speeds, tracking and power",
                   [&](report::Page& p) { plots(p, f, nominal); });
    page.paragraph("Source: " + info.source + ". Separated from what looks like it by: " + info.separated_by +
                   ".");
  }
  return page.write(path);
}

}  // namespace omniflight::cli
