#include "survival_page.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::cli {
namespace {

using allocation::kTiltMethods;
using allocation::SurvivalCell;
using allocation::SurvivalComparison;
using allocation::SurvivalMap;
using allocation::TiltMethod;

std::string key_of(TiltMethod method) {
  switch (method) {
    case TiltMethod::case_a:
      return "case_a";
    case TiltMethod::case_b:
      return "case_b";
    case TiltMethod::dynamic:
      return "dynamic";
    case TiltMethod::look_ahead:
      return "look_ahead";
    case TiltMethod::look_ahead_told:
      return "look_ahead_told";
  }
  return "";
}

/// The rows of the heat maps: shares, in them roll times; the columns: tilt steps.
report::Matrix empty_matrix(const SurvivalMap& map) {
  report::Matrix m{.row_title = "thrust left, roll time", .column_title = "tilt a period of 10 ms [deg]"};
  for (const double step : map.config.tilt_steps)
    m.columns.push_back(fmt::format("{:.4g}", to_degrees(step)));
  for (const auto& share : map.config.shares)
    for (const double t : map.config.roll_times)
      m.rows.push_back(fmt::format("{}, {:.4g} s", share.words(), t));
  m.values.assign(m.rows.size(), std::vector<double>(m.columns.size(), std::nan("")));
  return m;
}

double& at(report::Matrix& m, const SurvivalMap& map, const SurvivalCell& cell) {
  return m.values[cell.share * map.config.roll_times.size() + cell.roll_time][cell.tilt_step];
}

report::Matrix power_of(const SurvivalMap& map, TiltMethod method, int survived) {
  report::Matrix m = empty_matrix(map);
  m.title = fmt::format("{}: survives {} of {}", allocation::words(method), survived, map.cells.size());
  m.value_label = "mean power [W]; a dash: lost";
  for (const SurvivalCell& cell : map.cells)
    if (cell.of(method).survived) at(m, map, cell) = cell.of(method).mean_power;
  return m;
}

/// Of the power of case A, what a method saves (positive) or takes in addition.
report::Matrix saving_of(const SurvivalMap& map, TiltMethod method) {
  report::Matrix m = empty_matrix(map);
  m.title = fmt::format("Power that {} saves of case A's", allocation::words(method));
  m.value_label = "saved [%]; a dash: case A is lost, or both are";
  for (const SurvivalCell& cell : map.cells) {
    const auto &a = cell.of(TiltMethod::case_a), &b = cell.of(method);
    if (a.survived && b.survived) at(m, map, cell) = 100 * (1 - b.mean_power / a.mean_power);
  }
  return m;
}

/// "Look-ahead survives 90 of the 90 that case A survives, with less power in 79 (-32 to +22 %)".
std::string beside_case_a(const SurvivalMap& map, TiltMethod method) {
  const SurvivalComparison c = allocation::compare(map, TiltMethod::case_a, method);
  std::string out = fmt::format("{} survives {} of the {} that case A survives", allocation::words(method),
                                c.first - c.only_first, c.first);
  if (c.both == 0) return out;
  return out + fmt::format(", with less power in {} ({:+.0f} to {:+.0f} %)", c.second_needs_less,
                           100 * (c.lowest - 1), 100 * (c.highest - 1));
}

std::string capital(std::string words) {
  words.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(words.front())));
  return words;
}

bool better_than_case_a(const SurvivalMap& map, TiltMethod method) {
  const SurvivalComparison c = allocation::compare(map, TiltMethod::case_a, method);
  return c.only_first == 0 && c.second_needs_less == c.both;
}

int survived(const SurvivalMap& map, TiltMethod method) {
  return allocation::compare(map, method, method).first;
}

}  // namespace

nlohmann::json survival_json(const std::string& vehicle, const SurvivalMap& map) {
  nlohmann::json out = {
      {"schema", "omniflight.survival/1"}, {"vehicle", vehicle}, {"cells", nlohmann::json::array()}};
  for (const TiltMethod m : kTiltMethods) out["survived"][key_of(m)] = survived(map, m);
  for (const SurvivalCell& cell : map.cells) {
    const auto& share = map.config.shares[cell.share];
    nlohmann::json one = {{"thrust_share_low", share.at_low},
                          {"thrust_share_high", share.at_high},
                          {"roll_time_s", map.config.roll_times[cell.roll_time]},
                          {"tilt_step_deg", to_degrees(map.config.tilt_steps[cell.tilt_step])}};
    for (const TiltMethod m : kTiltMethods) {
      const allocation::Survival& s = cell.of(m);
      one[key_of(m)] = {{"survived", s.survived},
                        {"worst_position_m", s.worst_error},
                        {"worst_attitude_deg", to_degrees(s.worst_angle)},
                        {"power_W", s.survived ? nlohmann::json(s.mean_power) : nlohmann::json()}};
    }
    out["cells"].push_back(std::move(one));
  }
  return out;
}

std::vector<std::string> survival_lines(const SurvivalMap& map) {
  std::vector<std::string> out;
  for (const TiltMethod m : kTiltMethods)
    out.push_back(
        fmt::format("  {:32} survives {:3} of {}", allocation::words(m), survived(map, m), map.cells.size()));
  out.push_back(capital(beside_case_a(map, TiltMethod::look_ahead)));
  out.push_back(capital(beside_case_a(map, TiltMethod::look_ahead_told)));
  return out;
}

report::Page survival_page(const std::string& vehicle, const SurvivalMap& map) {
  const allocation::SurvivalConfig& c = map.config;
  report::Page page("What survives a roll of " + vehicle,
                    fmt::format("{} flights of each way of choosing weights and tilt", map.cells.size()));
  const bool told = better_than_case_a(map, TiltMethod::look_ahead_told),
             untold = better_than_case_a(map, TiltMethod::look_ahead);
  const int most = survived(map, TiltMethod::look_ahead_told);
  page.verdict(
      told ? report::Tone::ok : report::Tone::warn,
      fmt::format("Dynamic weights with look-ahead survive {} of {}, case A {}",
                  survived(map, TiltMethod::look_ahead), map.cells.size(), survived(map, TiltMethod::case_a)),
      capital(beside_case_a(map, TiltMethod::look_ahead)) + ". " +
          capital(beside_case_a(map, TiltMethod::look_ahead_told)) + fmt::format(", and {} in all.", most) +
          (told && !untold ? " A plan that does not know of a loss at small tilts goes there to save "
                             "power, and needs more."
                           : ""));
  report::Table t;
  t.caption = "Of every method over all cells";
  t.columns = {{.name = "weights and tilt"},
               {.name = "survives"},
               {.name = "survives where case A is lost"},
               {.name = "power over case A's, mean of both survived", .significant_digits = 3}};
  for (const TiltMethod m : kTiltMethods) {
    double own = 0, of_a = 0;
    int more = 0;
    for (const SurvivalCell& cell : map.cells) {
      const auto &a = cell.of(TiltMethod::case_a), &b = cell.of(m);
      more += b.survived && !a.survived;
      if (a.survived && b.survived) own += b.mean_power, of_a += a.mean_power;
    }
    t.rows.push_back({allocation::words(m), survived(map, m), more, of_a > 0 ? own / of_a : std::nan("")});
  }
  page.table(t);
  page.paragraph(
      fmt::format("Each flight hovers 2 s, rolls once about x on the spot and hovers 1 s, under PD control "
                  "(position {:.0f} 1/s and "
                  "{:.0f} 1/s2, attitude {:.1f} and {:.0f}) at 100 Hz; motors follow at once. The searches "
                  "and plans begin at a "
                  "tilt of {:.0f} deg. Lost: more than {:.1f} m or {:.0f} deg from the reference. The "
                  "look-ahead keeps {:.0f} % "
                  "of the thrust, told of the loss {:.0f} %; the allocator never knows it.",
                  c.gains.kp1, c.gains.kp2, c.gains.kr1, c.gains.kr2, to_degrees(c.initial_tilt), c.left,
                  to_degrees(c.turned_away), 100 * c.reserve, 100 * c.reserve_told));
  page.section("Power where case A survives");
  for (const TiltMethod m : {TiltMethod::look_ahead, TiltMethod::look_ahead_told})
    page.matrix(saving_of(map, m));
  page.section("Survival and power of each");
  for (const TiltMethod m : kTiltMethods) page.matrix(power_of(map, m, survived(map, m)));
  return page;
}

Result<int> map_survival(const vehicle::Vehicle& vehicle, const Common& common) {
  install_interrupt_handler();
  Progress progress("survival", 100, "%", common.quiet);
  const auto map = allocation::survival_map(vehicle, {}, [&](double done) {
    progress.update(100 * done);
    return !interrupted();
  });
  progress.finish();
  if (!map) return Failure(map.error());
  const nlohmann::json j = survival_json(vehicle.name, *map);
  print_json(common, j);
  for (const std::string& line : survival_lines(*map)) say(common, line);
  if (common.out.empty()) return 0;
  if (auto ok = make_folder(common.out); !ok) return Failure(ok.error());
  if (auto ok = files::write_file_atomic(common.out + "/survival.json", j.dump(2) + "\n"); !ok)
    return Failure(ok.error());
  if (auto ok = survival_page(vehicle.name, *map).write(common.out + "/report.html"); !ok)
    return Failure(ok.error());
  say(common, "report: " + common.out + "/report.html");
  return 0;
}

}  // namespace omniflight::cli
