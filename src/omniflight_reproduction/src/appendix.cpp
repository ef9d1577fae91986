// Appendix: the other choice of axes, sets at other tilts, runs of motors and rotor speeds.
#include <fmt/format.h>

#include <cmath>

#include "chapters.hpp"
#include "flown.hpp"
#include "geometries.hpp"
#include "wrench_sets.hpp"

namespace omniflight::reproduction {
namespace {

Result<Finding> drawn(const Inputs& in) {
  Finding f;
  f.outlines = {drawing(choice_1(in.omnimorph), 0, "Choice 1 at 0 deg"),
                drawing(choice_1(in.omnimorph), to_radians(45), "Choice 1 at 45 deg")};
  return f;
}

/// The readings of OmniMorph, then those of choice 1.
Result<Finding> appendix_uniformity(const Inputs& in, bool torques, const std::vector<std::string>& keys) {
  Finding f;
  const auto of = torques ? torque_uniformity : force_uniformity;
  const auto tilts = compared_tilts();
  for (std::size_t k = 0; k < 3; ++k) {
    Row row = compared(keys[k], {});
    for (const auto& [name, v] :
         {std::pair{std::string("OmniMorph, "), in.omnimorph}, {"choice 1, ", choice_1(in.omnimorph)}}) {
      auto readings = of(v, tilts[k]);
      if (!readings) return Failure(readings.error());
      for (Reading& r : *readings) row.readings.push_back({name + r.assumption, r.value});
    }
    f.rows.push_back(std::move(row));
  }
  judge_together(f.rows);
  auto hull = hulls({{"choice 1, ", choice_1(in.omnimorph)}}, tilts, torques);
  if (!hull) return Failure(hull.error());
  f.outlines = {*hull};
  f.notes = {
      "One definition has to give all three numbers. None that was tried does; the one that comes nearest is "
      "shown."};
  return f;
}

Result<Finding> appendix_forces(const Inputs& in) {
  return appendix_uniformity(in, false, {"A.2/force_30", "A.2/force_45", "A.2/force_55"});
}
Result<Finding> appendix_torques(const Inputs& in) {
  return appendix_uniformity(in, true, {"A.3/torque_30", "A.3/torque_45", "A.3/torque_55"});
}

Result<Finding> at_50_deg(const Inputs& in) {
  Finding f;
  Row row = compared("A.4/inradius_50", {});
  for (const double f_max : {6.25, kChapter5Limit, 6.25 - 0.15}) {
    const auto set = allocation::WrenchSet::create(without_drag(in.omnimorph), to_radians(50), f_max);
    if (!set) return Failure(set.error());
    row.readings.push_back(
        {fmt::format("largest thrust {:.2f} N{}", f_max, f_max == 6.1 ? ", 6.25 less the least thrust" : ""),
         set->omnidirectional_force()});
  }
  f.rows = {row};
  auto hull = hulls({{"", in.omnimorph}}, {to_radians(50)}, false);
  if (!hull) return Failure(hull.error());
  f.outlines = {*hull};
  f.notes = {"4 f sin(50 deg) is 18.67 N for f = 6.093 N, a limit that stands nowhere in the thesis."};
  return f;
}

/// Mean and largest |commanded - measured speed| [rad/s] of a rotor while the reference moves.
std::pair<double, double> speed_error(const Flown& flight, Eigen::Index rotor) {
  const auto *speed = flight.recording->find("rotor_speed"),
             *command = flight.recording->find("rotor_command");
  const double none = std::nan("");
  if (!speed || !command || rotor >= std::min(speed->width(), command->width())) return {none, none};
  const recording::Signal moving = recording::window(*speed, flight.metrics.from, flight.metrics.to);
  const Eigen::VectorXd error =
      (recording::resample(*command, moving.t_s).col(rotor) - moving.values.col(rotor)).cwiseAbs();
  double sum = 0, most = 0, used = 0;
  for (const double e : error)
    if (std::isfinite(e)) sum += e, most = std::max(most, e), ++used;
  return used > 0 ? std::pair{sum / used, most} : std::pair{none, none};
}

/// What compare-runs appends to runs.csv.
Result<Finding> runs(const Inputs& in) {
  Finding f;
  report::Table t, largest;
  t.caption = "Mean |commanded - measured speed| of each rotor [rad/s]";
  largest.caption = "The largest [rad/s]";
  for (report::Table* table : {&t, &largest}) {
    table->columns = {{.name = "rotor"}};
    for (int k = 0; k < in.omnimorph.rotor_count(); ++k)
      table->rows.push_back({report::Cell(std::to_string(k + 1))});
  }
  for (const char* name : {"t1_nominal", "t1_hidden_boards", "t2_nominal", "t2_hidden_boards"}) {
    const auto x = flown(in, name);
    if (!x) return Failure(x.error());
    if (!*x) return fail(ErrorCode::incomplete, "the flight was not flown", name);
    for (report::Table* table : {&t, &largest})
      table->columns.push_back({.name = name, .significant_digits = 3});
    double overall = 0;
    for (std::size_t k = 0; k < t.rows.size(); ++k) {
      const auto [mean, most] = speed_error(**x, static_cast<Eigen::Index>(k));
      t.rows[k].emplace_back(mean);
      largest.rows[k].emplace_back(most);
      overall += mean / static_cast<double>(t.rows.size());
    }
    f.rows.push_back(shown(std::string("mean error of all rotors, ") + name, "rad/s", overall));
  }
  f.tables = {t, largest};
  f.notes = {
      "The columns of runs.csv, to which `omniflight compare-runs` appends a line a run, with gains and "
      "time."};
  return f;
}

/// Speeds of the rotors of one board over time, simulated and with everything hidden.
Result<Finding> speeds(const Inputs& in, const std::vector<std::string>& trajectories) {
  Finding f;
  for (const std::string& t : trajectories)
    for (const auto& [flight, words] : {std::pair{"_nominal", "simulated"}, {"_hidden_boards", "hidden"}}) {
      const auto x = flown(in, t + flight);
      if (!x) return Failure(x.error());
      if (!*x) return fail(ErrorCode::incomplete, "the flight was not flown", t + flight);
      std::vector<std::string> names;
      double sum = 0;
      const int n = in.omnimorph.rotor_count();
      for (int k = 0; k < n; ++k) {
        names.push_back(fmt::format("rotor {}", k + 1));
        sum += rms(**x, "rotor_speed", k) / n;
      }
      f.plots.push_back({.title = fmt::format("Rotor speeds, trajectory {}, {}", t.substr(1), words),
                         .x_label = "time from the first motion [s]",
                         .y_label = "speed [Hz]",
                         .series = curves(**x, "rotor_speed", names, 0, 1 / (2 * kPi), false),
                         .height_px = 240,
                         .group = "speeds " + t});
      f.rows.push_back(
          shown(fmt::format("{}: mean RMS of the rotor speeds, {}", t, words), "Hz", sum / (2 * kPi)));
    }
  return f;
}

Result<Finding> speeds_1(const Inputs& in) { return speeds(in, {"t1"}); }
Result<Finding> speeds_2(const Inputs& in) { return speeds(in, {"t2"}); }

/// How much faster the rotors turn with everything hidden: the square root of the thrust they carry more.
Result<Finding> faster(const Inputs& in) {
  Finding f;
  report::Table table;
  table.caption = "RMS speed of each rotor while the reference moves [Hz]";
  table.columns = {{.name = "rotor"}};
  for (const char* t : {"T1", "T2"})
    for (const char* what : {" simulated", " hidden", " ratio"})
      table.columns.push_back({.name = std::string(t) + what});
  for (int k = 0; k < in.omnimorph.rotor_count(); ++k) {
    auto& row = table.rows.emplace_back(std::vector<report::Cell>{std::to_string(k + 1)});
    for (const char* t : {"t1", "t2"}) {
      double of[2] = {};
      for (const int hidden : {0, 1}) {
        const auto x = flown(in, std::string(t) + (hidden ? "_hidden_boards" : "_nominal"));
        if (!x) return Failure(x.error());
        if (!*x) return fail(ErrorCode::incomplete, "a flight was not flown", t);
        of[hidden] = rms(**x, "rotor_speed", k) / (2 * kPi);
        row.emplace_back(of[hidden]);
      }
      row.emplace_back(of[1] / of[0]);
    }
  }
  f.tables = {table};
  f.notes = {
      "With thrust as the square of the speed, power 33.4 % and 61.9 % higher means speeds 10 % and 17 % "
      "higher."};
  return f;
}

}  // namespace

std::vector<Figure> appendix() {
  const auto of = [](const std::string& t) {
    return std::vector<std::string>{t + "_nominal", t + "_hidden_boards"};
  };
  auto both = of("t1");
  for (const auto& name : of("t2")) both.push_back(name);
  return {
      {"A.1", "Rotors, normals and tilt axes of choice 1 at other tilts", true, true, {}, false, drawn},
      {"A.2", "Uniformity of forces of the appendix", false, true, {}, false, appendix_forces},
      {"A.3", "Uniformity of torques of the appendix", false, true, {}, false, appendix_torques},
      {"A.4", "Force in the weakest direction at 50 deg", false, true, {}, false, at_50_deg},
      {"A.5", "Runs of the motors: errors in speed", false, false, both, false, runs},
      {"A.6", "Rotor speeds, trajectory 1", true, false, of("t1"), false, speeds_1},
      {"A.7", "Rotor speeds, trajectory 2", true, false, of("t2"), false, speeds_2},
      {"A.8", "Rotor speeds, simulated and real", false, false, both, false, faster},
  };
}

}  // namespace omniflight::reproduction
