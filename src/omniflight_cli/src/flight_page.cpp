#include "flight_page.hpp"

#include <fmt/format.h>

#include "compare.hpp"
#include "omniflight_report/page.hpp"
#include "verdict.hpp"

namespace omniflight::cli {
namespace {

using recording::Signal;

report::Tone tone_of(const std::string& verdict) {
  if (verdict == kFlown) return report::Tone::ok;
  return verdict == kFlownBadly ? report::Tone::warn : report::Tone::bad;
}

const char* headline_of(const std::string& verdict) {
  if (verdict == kFlown) return "Flown to the end, within its bounds";
  if (verdict == kFlownBadly) return "Flown to the end, and outside its bounds";
  return verdict == kLost ? "The vehicle was lost" : "Not flown to the end";
}

report::Series line(std::string name, const std::vector<double>& t, const Eigen::VectorXd& y,
                    bool dashed = false) {
  report::Series s;
  s.name = std::move(name);
  s.x = t;
  s.y.assign(y.data(), y.data() + y.size());
  s.dashed = dashed;
  return s;
}

void add_path(report::Page& page, const recording::Recording& r, const Tracking& tracking) {
  const Signal* p = r.find("position") ? r.find("position") : r.find("est_position");
  const Signal* ref = r.find("ref_position");
  if (!p || !ref || tracking.t.empty()) return;
  const Eigen::MatrixXd flown = recording::resample(*p, tracking.t),
                        asked = recording::resample(*ref, tracking.t);
  report::PathPlot plot{.title = "Flight path", .value_label = "position error [m]", .t = tracking.t};
  for (Eigen::Index i = 0; i < flown.rows(); ++i) {
    plot.x.push_back(flown(i, 0)), plot.y.push_back(flown(i, 1)), plot.z.push_back(flown(i, 2));
    plot.value.push_back(tracking.error.row(i).head<3>().norm());
    plot.reference_x.push_back(asked(i, 0)), plot.reference_y.push_back(asked(i, 1));
    plot.reference_z.push_back(asked(i, 2));
  }
  page.path_plot(std::move(plot));
}

void add_rotors(report::Page& page, const recording::Recording& r, const vehicle::Vehicle& vehicle) {
  const Signal* speed = r.find("rotor_speed");
  if (!speed) return;
  report::TimePlot loads{
      .title = "Rotors: thrust against its limit", .y_label = "share of the limit [%]", .group = "flight"};
  for (Eigen::Index k = 0; k < std::min<Eigen::Index>(speed->width(), vehicle.rotor_count()); ++k) {
    const vehicle::Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(k)];
    const Eigen::VectorXd load = speed->values.col(k).unaryExpr(
        [&](double w) { return 100 * std::abs(rotor.thrust(w)) / rotor.max_thrust; });
    loads.series.push_back(line(fmt::format("rotor {}", k + 1), speed->t_s, load));
  }
  page.plot(std::move(loads));
  const auto power = report::mechanical_power(r, vehicle);
  page.plot({.title = "Power, mechanical",
             .y_label = "power [W]",
             .series = {{.name = "all rotors", .x = power.t, .y = power.W}},
             .group = "flight"});
  if (const Signal* alpha = r.find("alpha")) {
    report::TimePlot tilt{.title = "Tilt of the rotors", .y_label = "tilt [deg]", .group = "flight"};
    tilt.series.push_back(line("measured", alpha->t_s, (180 / kPi) * alpha->values.col(0)));
    if (const Signal* asked = r.find("alpha_command"))
      tilt.series.push_back(line("commanded", asked->t_s, (180 / kPi) * asked->values.col(0), true));
    page.plot(std::move(tilt));
  }
}

std::string next_steps(const FlightOptions& o, const std::string& vehicle) {
  const std::string name = o.vehicle.empty() ? vehicle : o.vehicle;
  return fmt::format(
      "omniflight view {0}/flight.mcap\nomniflight diagnose {0}/flight.mcap --vehicle {1} --out diagnosis\n"
      "omniflight compare SIMULATED {0}/flight.mcap --vehicle {1} --out comparison",
      o.out, name);
}

}  // namespace

Status write_flight_page(const FlightOptions& o, const FlightResult& result, const recording::Recording& r,
                         const vehicle::Vehicle& vehicle, const std::string& path) {
  const FlightMetrics& m = result.metrics;
  const Tracking& t = m.has_truth ? m.truth : m.measured;
  report::Page page("Flight of " + result.json.value("mission", o.mission),
                    fmt::format("{}, {} plant, seed {}", vehicle.name, o.plant, o.seed));
  page.verdict(tone_of(result.verdict), headline_of(result.verdict), result.reason);
  page.facts({{"position error, RMSE", fmt::format("{:.1f}", 1e3 * t.position_rmse.norm()), "mm"},
              {"largest position error", fmt::format("{:.1f}", 1e3 * t.worst_position), "mm"},
              {"attitude error, RMSE", fmt::format("{:.2f}", t.attitude_rmse.norm()), "deg"},
              {"mean power, mechanical", fmt::format("{:.1f}", m.mean_power), "W"},
              {"duration", fmt::format("{:.1f}", r.duration_s), "s"}});
  if (!o.effects.empty() || !o.world.empty())
    page.paragraph("The plant flew physics that the controller did not know: " + o.effects + o.world);
  page.section("Tracking");
  add_path(page, r, t);
  if (!t.t.empty()) plot_tracking(page, m, "flight");
  page.section("Rotors");
  add_rotors(page, r, vehicle);
  page.section("Events");
  report::Table events{.columns = {{.name = "what was said"}}};
  for (const std::string& remark : result.remarks) events.rows.push_back({report::Cell(remark)});
  if (!result.monitor.empty()) events.rows.push_back({report::Cell(result.monitor)});
  report::Table unread{.columns = {{.name = "of the recording"}}};  // says nothing of the flight
  for (const auto& note : r.notes) {
    const bool lost = note.kind == recording::Note::Kind::loss || note.kind == recording::Note::Kind::damage;
    (lost ? events : unread).rows.push_back({report::Cell(note.text)});
  }
  if (events.rows.empty())
    page.paragraph("Nothing beside the plan.");
  else
    page.table(events);
  if (!unread.rows.empty())
    page.details("What else the recording says of itself", [&](report::Page& p) { p.table(unread); });
  page.section("What next");
  page.details("Look at it, find what the model lacks, put it beside another flight",
               next_steps(o, vehicle.name));
  return page.write(path);
}

}  // namespace omniflight::cli
