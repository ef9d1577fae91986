#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cmath>

#include "folder.hpp"
#include "motor_file.hpp"
#include "motor_verbs.hpp"
#include "omniflight_core/frames.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_identification/gain_search.hpp"
#include "omniflight_identification/prbs.hpp"
#include "omniflight_identification/speed_loop.hpp"
#include "omniflight_report/page.hpp"
#include "speed_errors.hpp"

namespace omniflight::cli {
namespace {

using namespace identification;
using nlohmann::json;

struct TuneMotorOptions {
  std::string motor;
  int rotor = 0;
  int rounds = 0;
  std::string runs;
  double period_ms = 1.0, max_sensitivity = 1.7, gain_spread_percent = 20.0, search_sensitivity = 2.0;
};

json to_json(const Margins& m) {
  return {{"max_sensitivity", m.max_sensitivity},
          {"gain_margin", std::isfinite(m.gain_margin) ? json(m.gain_margin) : json(nullptr)},
          {"phase_margin_deg",
           std::isfinite(m.phase_margin_rad) ? json(to_degrees(m.phase_margin_rad)) : json(nullptr)},
          {"delay_margin_s", std::isfinite(m.delay_margin_s) ? json(m.delay_margin_s) : json(nullptr)},
          {"crossover_radps", m.crossover_radps},
          {"stable", m.stable}};
}

std::string words(const Margins& m) {
  return fmt::format(
      "sensitivity {:.2f}, gain margin {:.1f}, phase margin {:.0f} deg, delay margin {:.1f} ms",
      m.max_sensitivity, m.gain_margin, to_degrees(m.phase_margin_rad), 1000 * m.delay_margin_s);
}

Status write_page(const std::string& out, const TuneMotorOptions& o, const Tuning& t,
                  const std::vector<MotorOfFile>& motors) {
  report::Page page("Gains of the motors' speed loop", o.motor);
  page.section("Gains");
  page.table({.columns = {{.name = "gain"}, {.name = "value"}, {.name = "unit"}},
              .rows = {{"kp", t.gains.kp, "command per rad/s"},
                       {"ki", t.gains.ki, "command per rad"},
                       {"kd", t.gains.kd, "command per rad/s2"},
                       {"n", t.gains.n, "1/s"}}});
  page.paragraph("Mean motor: " + words(t.nominal) + ". Worst of all motors and gains: " + words(t.worst) +
                 ".");
  report::TimePlot plot{.title = "Step of the set point, lag up and lag down of every rotor",
                        .y_label = "speed, share of the step [1]"};
  const double T = 1e-3 * o.period_ms;
  for (const MotorOfFile& m : motors)
    for (const bool up : {true, false}) {
      const LagPlant& p = up ? m.up : m.down;
      report::Series series{.name = fmt::format("rotor {} {}", m.rotor, up ? "up" : "down")};
      series.y =
          closed_loop_step(t.gains, p, T, static_cast<int>(std::min(5000.0, 8 * (p.lag_s + p.delay_s) / T)));
      for (std::size_t i = 0; i < series.y.size(); ++i) series.x.push_back(T * static_cast<double>(i));
      plot.series.push_back(std::move(series));
    }
  page.plot(std::move(plot));
  return page.write(out + "/report.html");
}

SearchOptions search_options(const TuneMotorOptions& o) {
  return {.max_sensitivity = o.search_sensitivity, .control_period_s = 1e-3 * o.period_ms};
}

/// The rows that have gains, as the search takes them.
std::vector<FlownGains> flown_of(const std::vector<RunRow>& rows) {
  std::vector<FlownGains> flown;
  for (const RunRow& row : rows)
    if (std::isfinite(row.gains.kp + row.gains.ki + row.gains.kd))
      flown.push_back({row.gains, row.errors.overall()});
  return flown;
}

/// Every motor under its speed loop, on a set point that jumps between its own slow and fast speeds.
Result<SpeedErrors> fly_simulated(const std::vector<MotorOfFile>& motors, const PidnGains& gains,
                                  double period_s) {
  SpeedErrors errors;
  for (const MotorOfFile& m : motors) {
    const auto wanted = make_prbs({.low = m.low_radps,
                                   .high = m.high_radps,
                                   .band_hz = 0.1 / m.up.lag_s,
                                   .period_s = period_s,
                                   .duration_s = 300 * m.up.lag_s,
                                   .lead_s = 0.5});
    if (!wanted) return Failure(wanted.error());
    const SpeedLoop loop{m.up, m.down, period_s, m.noise_radps, 0.0, static_cast<std::uint64_t>(m.rotor)};
    const LoopScore s = score(wanted->values, simulated(loop, gains, wanted->values));
    errors.mean.push_back(s.mean_error);
    errors.max.push_back(s.max_error);
  }
  return errors;
}

/// Flies, scores and chooses the next gains, until nothing is better or the rounds are used up. Rows that are
/// in the list already count as flown.
Result<PidnGains> simulated_rounds(const TuneMotorOptions& o, const std::vector<MotorOfFile>& motors,
                                   PidnGains gains, std::vector<RunRow>& rows, const Common& common) {
  Progress progress("tuning", o.rounds, "rounds", common.quiet || common.json);
  for (int round = 1; round <= o.rounds && !interrupted(); ++round) {
    const auto errors = fly_simulated(motors, gains, 1e-3 * o.period_ms);
    if (!errors) return Failure(errors.error());
    rows.push_back({now_utc(), fmt::format("simulated {}", rows.size() + 1), gains, *errors});
    progress.update(round);
    const auto next = next_gains(flown_of(rows), plants_of(motors), search_options(o));
    if (!next) return Failure(next.error());
    if (!*next) break;
    gains = **next;
  }
  return rows[*best_run(rows)].gains;
}

/// Gains beside those of the model: the best of simulated rounds, or what the runs flown so far make worth
/// flying next.
Result<PidnGains> searched(const TuneMotorOptions& o, const std::vector<MotorOfFile>& motors,
                           const PidnGains& tuned, const std::string& out, const Common& common,
                           std::string& source) {
  if (o.rounds > 0) {
    const std::string file = out + "/runs.csv";
    auto rows = read_runs(file);
    if (!rows) return Failure(rows.error());
    if (!rows->empty() && rows->front().errors.mean.size() != motors.size())
      return bad_input("is of another number of rotors", file, "Choose another --out");
    const auto best = simulated_rounds(o, motors, tuned, *rows, common);
    if (!best) return Failure(best.error());
    if (auto ok = write_runs(file, *rows); !ok) return Failure(ok.error());
    source = fmt::format("best of {} simulated runs", rows->size());
    say(common,
        fmt::format(
            "{} simulated runs: mean error {:.3f} rad/s with the model's gains, {:.3f} with the best; {}",
            rows->size(), rows->front().errors.overall(), (*rows)[*best_run(*rows)].errors.overall(), file));
    return *best;
  }
  const auto rows = read_runs(o.runs);
  if (!rows) return Failure(rows.error());
  const auto next = next_gains(flown_of(*rows), plants_of(motors), search_options(o));
  if (!next) return Failure(next.error());
  source = *next ? fmt::format("next to fly after {} runs", rows->size())
                 : "the best run, nothing near it is better";
  const auto best = best_run(*rows);
  return *next ? **next : (*rows)[*best].gains;
}

Result<int> tune_motor(const TuneMotorOptions& o, const Common& common) {
  const auto motors = load_motors(o.motor, o.rotor);
  if (!motors) return Failure(motors.error());
  if (o.rounds > 0 && !o.runs.empty())
    return bad_input("rounds are simulated and runs were flown: choose one", "--rounds, --runs");
  const std::vector<LagPlant> plants = plants_of(*motors);
  auto tuning = tune_pidn(plants, {.control_period_s = 1e-3 * o.period_ms,
                                   .max_sensitivity = o.max_sensitivity,
                                   .gain_spread = 0.01 * o.gain_spread_percent});
  if (!tuning) return Failure(tuning.error());
  const std::string out = common.out.empty() ? fresh_folder("gains") : common.out;
  auto lock = FolderLock::take(out);
  if (!lock) return Failure(lock.error());
  std::string source = "model";
  if (o.rounds > 0 || !o.runs.empty()) {
    const auto gains = searched(o, *motors, tuning->gains, out, common, source);
    if (!gains) return Failure(gains.error());
    tuning = assessed(*gains, plants,
                      {.control_period_s = 1e-3 * o.period_ms, .gain_spread = 0.01 * o.gain_spread_percent});
    if (!tuning) return Failure(tuning.error());
  }
  const PidnGains& g = tuning->gains;
  const json j{{"schema", "omniflight.gains/1"},
               {"motor", o.motor},
               {"rotor", o.rotor},
               {"source", source},
               {"control_period_s", 1e-3 * o.period_ms},
               {"gains", {{"kp", g.kp}, {"ki", g.ki}, {"kd", g.kd}, {"n", g.n}}},
               {"nominal", to_json(tuning->nominal)},
               {"worst", to_json(tuning->worst)},
               {"overshoot", tuning->overshoot},
               {"rise_s", tuning->rise_s}};
  print_json(common, j);
  say(common, fmt::format("kp {:.5g}, ki {:.5g}, kd {:.5g}, n {:.5g} with a control period of {:.3g} ms ({})",
                          g.kp, g.ki, g.kd, g.n, o.period_ms, source));
  say(common, "  mean motor: " + words(tuning->nominal));
  say(common, fmt::format("  worst of {} lags and gains within {:.0f} %: {}", plants.size(),
                          o.gain_spread_percent, words(tuning->worst)));
  say(common, fmt::format("  step: {:.1f} ms to 90 %, overshoot {:.1f} %", 1000 * tuning->rise_s,
                          100 * tuning->overshoot));
  if (auto ok = files::write_file_atomic(out + "/gains.json", j.dump(2) + "\n"); !ok)
    return Failure(ok.error());
  if (auto ok = write_page(out, o, *tuning, *motors); !ok) return Failure(ok.error());
  say(common, "report: " + out + "/report.html");
  return 0;
}

}  // namespace

Action add_tune_motor(CLI::App& verb, Common& common) {
  auto o = std::make_shared<TuneMotorOptions>();
  verb.add_option("motor", o->motor, "motor.json of identify-motor")->required();
  verb.add_option("--rotor", o->rotor, "Only this rotor, from 1; otherwise gains that serve all")
      ->check(CLI::Range(1, 16));
  verb.add_option("--control-period-ms", o->period_ms, "Period of the speed loop [ms]")
      ->check(not_negative(false));
  verb.add_option("--max-sensitivity", o->max_sensitivity,
                  "Largest |1/(1+L)| of the model's gains, 1.2 to 3");
  verb.add_option("--gain-spread-percent", o->gain_spread_percent,
                  "Motors this much stronger and weaker keep the margins as well [%]");
  verb.add_option("--rounds", o->rounds,
                  "Simulated flights, each with the next gains; kept in runs.csv of --out")
      ->check(CLI::Range(1, 1000));
  verb.add_option("--runs", o->runs,
                  "runs.csv of compare-runs: the gains to fly next, from those that were flown");
  verb.add_option("--search-sensitivity", o->search_sensitivity, "Largest |1/(1+L)| of gains that are tried")
      ->check(CLI::Range(1.2, 3.0));
  return [o, &common] { return tune_motor(*o, common); };
}

}  // namespace omniflight::cli
