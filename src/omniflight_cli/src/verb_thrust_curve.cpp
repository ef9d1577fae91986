#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "folder.hpp"
#include "motor_verbs.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_identification/thrust_curve.hpp"
#include "omniflight_report/page.hpp"
#include "omniflight_vehicle/vehicle.hpp"
#include "vehicle_update.hpp"

namespace omniflight::cli {
namespace {

using namespace identification;
using nlohmann::json;

struct ThrustCurveOptions {
  std::vector<std::string> sweeps;
  std::string thrust_unit, update;
};

json to_json(const Estimate& e, const char* unit) {
  return {{"value", e.value}, {"interval95", {e.low(), e.high()}}, {"unit", unit}};
}

json to_json(const RotorCurve& c, const char* unit) {
  const std::string per = std::string(unit) + "/(rad/s)^";
  return {{"scale", to_json(c.scale, (per + "exponent").c_str())},
          {"exponent", to_json(c.exponent, "1")},
          {"offset", to_json(c.offset, unit)},
          {"coefficient", to_json(c.coefficient, (per + "2").c_str())},
          {"rms", c.rms},
          {"speeds_radps", {c.slowest, c.fastest}}};
}

json to_json(const ThrustCurveOptions& o, const std::vector<BenchSweep>& sweeps, const ThrustCurves& curves) {
  json files_list = json::array();
  for (const BenchSweep& s : sweeps)
    files_list.push_back({{"file", s.file}, {"rows", s.thrust_N.size()}, {"dropped", s.dropped}});
  json j{{"schema", "omniflight.thrust_curve/1"},
         {"sweeps", files_list},
         {"thrust", to_json(curves.thrust, "N")}};
  if (curves.has_torque) {
    j["torque"] = to_json(curves.torque, "N m");
    j["drag_ratio"] = to_json(curves.drag_ratio, "m");
  }
  if (!o.update.empty()) j["updated"] = o.update;
  return j;
}

std::string line(const char* name, const RotorCurve& c, const char* unit) {
  return fmt::format(
      "  {}: {:.4g} {}/(rad/s)^e +- {:.2g}, exponent e {:.3f} +- {:.3f}, offset {:.3g} +- {:.2g} {}; with "
      "exponent 2: "
      "{:.4g} +- {:.2g} {}/(rad/s)^2",
      name, c.scale.value, unit, 1.96 * c.scale.sigma, c.exponent.value, 1.96 * c.exponent.sigma,
      c.offset.value, 1.96 * c.offset.sigma, unit, c.coefficient.value, 1.96 * c.coefficient.sigma, unit);
}

void plot(report::Page& page, const char* title, const char* label, const std::vector<BenchSweep>& sweeps,
          const RotorCurve& curve, bool torque) {
  report::TimePlot p{.title = title, .x_label = "mean speed of the rotors [rad/s]", .y_label = label};
  const double rotors = static_cast<double>(sweeps.front().speed_radps.cols());
  for (const BenchSweep& s : sweeps) {
    report::Series points{.name = s.file, .points = true};
    const Eigen::VectorXd speed = s.speed_radps.rowwise().mean();
    const Eigen::VectorXd& load = torque ? s.torque_Nm : s.thrust_N;
    points.x.assign(speed.begin(), speed.end());
    points.y.assign(load.begin(), load.end());
    p.series.push_back(std::move(points));
  }
  report::Series fitted{.name = "curve"};
  for (int k = 0; k <= 100; ++k) {
    const double speed = curve.slowest + (curve.fastest - curve.slowest) * k / 100;
    fitted.x.push_back(speed);
    fitted.y.push_back(rotors * load_at(curve, speed) + curve.offset.value);
  }
  p.series.push_back(std::move(fitted));
  page.plot(std::move(p));
}

Status write_page(const std::string& out, const std::vector<BenchSweep>& sweeps, const ThrustCurves& curves) {
  report::Page page("Thrust curve", sweeps.front().file);
  page.section("Curves");
  report::Table t;
  t.caption = "load = sum over rotors of scale speed^exponent, + offset; intervals of 95 %";
  t.columns = {{.name = "load"},
               {.name = "scale"},
               {.name = "exponent"},
               {.name = "offset"},
               {.name = "coefficient at exponent 2"},
               {.name = "rms left"}};
  const auto row = [&](const char* name, const RotorCurve& c) {
    const auto pm = [](const Estimate& e) { return fmt::format("{:.4g} ± {:.2g}", e.value, 1.96 * e.sigma); };
    t.rows.push_back({name, pm(c.scale), pm(c.exponent), pm(c.offset), pm(c.coefficient), c.rms});
  };
  row("thrust [N]", curves.thrust);
  if (curves.has_torque) row("torque [N m]", curves.torque);
  page.table(t);
  plot(page, "Thrust of the stand", "thrust [N]", sweeps, curves.thrust, false);
  if (curves.has_torque) plot(page, "Torque of the stand", "torque [N m]", sweeps, curves.torque, true);
  return page.write(out + "/report.html");
}

Status update(const ThrustCurveOptions& o, const std::vector<BenchSweep>& sweeps, const ThrustCurves& curves,
              const Common& common) {
  const auto vehicle = vehicle::load_vehicle(o.update);
  if (!vehicle) return Failure(vehicle.error());
  const auto rotors = static_cast<std::size_t>(vehicle->rotor_count());
  const auto source = [&](const Estimate& e, const char* unit) {
    return fmt::format("omniflight thrust-curve: {} rows of {} sweep(s), first {}; +- {:.2g} {} (95 %)",
                       curves.rows, sweeps.size(), sweeps.front().file, 1.96 * e.sigma, unit);
  };
  std::vector<RotorField> fields{{"thrust_coefficient",
                                  std::vector<double>(rotors, curves.thrust.coefficient.value),
                                  source(curves.thrust.coefficient, "N/(rad/s)^2")}};
  if (curves.has_torque)
    fields.push_back(
        {"drag_ratio", std::vector<double>(rotors, curves.drag_ratio.value), source(curves.drag_ratio, "m")});
  const auto file = update_vehicle(o.update, fields);
  if (!file) return Failure(file.error());
  say(common, "updated: " + *file);
  return {};
}

Result<int> thrust_curve(const ThrustCurveOptions& o, const Common& common) {
  std::vector<BenchSweep> sweeps;
  for (const std::string& path : o.sweeps) {
    const auto text = files::read_gzip_or_plain(path, 64 * files::kMegabyte);
    if (!text) return Failure(text.error());
    auto sweep = read_sweep(*text, path, {.thrust_unit = o.thrust_unit});
    if (!sweep) return Failure(sweep.error());
    sweeps.push_back(std::move(*sweep));
  }
  const auto curves = fit_thrust_curves(sweeps);
  if (!curves) return Failure(curves.error());
  for (const BenchSweep& s : sweeps)
    say(common, fmt::format("{}: {} rows, {} dropped", s.file, s.thrust_N.size(), s.dropped));
  say(common, line("thrust", curves->thrust, "N"));
  if (curves->has_torque) {
    say(common, line("torque", curves->torque, "N m"));
    say(common, fmt::format("  torque per thrust: {:.4g} +- {:.2g} m", curves->drag_ratio.value,
                            1.96 * curves->drag_ratio.sigma));
  }
  const json j = to_json(o, sweeps, *curves);
  print_json(common, j);
  const std::string out = common.out.empty() ? fresh_folder("thrust") : common.out;
  auto lock = FolderLock::take(out);
  if (!lock) return Failure(lock.error());
  if (auto ok = files::write_file_atomic(out + "/thrust.json", j.dump(2) + "\n"); !ok)
    return Failure(ok.error());
  if (auto ok = write_page(out, sweeps, *curves); !ok) return Failure(ok.error());
  say(common, "report: " + out + "/report.html");
  if (!o.update.empty())
    if (auto ok = update(o, sweeps, *curves, common); !ok) return Failure(ok.error());
  return 0;
}

}  // namespace

Action add_thrust_curve(CLI::App& verb, Common& common) {
  auto o = std::make_shared<ThrustCurveOptions>();
  verb.add_option("sweeps", o->sweeps,
                  "CSV of a thrust stand: rotor speed [rpm], thrust, torque where measured")
      ->required();
  verb.add_option("--thrust-unit", o->thrust_unit,
                  "Unit of a thrust column whose header has none: N, g, gf or kg")
      ->check(CLI::IsMember({"N", "g", "gf", "kg"}));
  verb.add_option("--update", o->update,
                  "Vehicle (name or path) whose file gets thrust_coefficient and drag_ratio");
  return [o, &common] { return thrust_curve(*o, common); };
}

}  // namespace omniflight::cli
