#include <fmt/format.h>

#include "folder.hpp"
#include "motor_file.hpp"
#include "motor_verbs.hpp"
#include "omniflight_core/frames.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::cli {
namespace {

using namespace identification;
using nlohmann::json;

struct Options {
  std::string motor;
  int rotor = 0;
  double period_ms = 1.0, max_sensitivity = 1.7, gain_spread_percent = 20.0;
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

Status write_page(const std::string& out, const Options& o, const Tuning& t,
                  const std::vector<LagPlant>& plants) {
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
  for (std::size_t k = 0; k < plants.size(); ++k) {
    const LagPlant& p = plants[k];
    report::Series s{.name = fmt::format("rotor {} {}", k / 2 + 1, k % 2 == 0 ? "up" : "down")};
    s.y = closed_loop_step(t.gains, p, T, static_cast<int>(std::min(5000.0, 8 * (p.lag_s + p.delay_s) / T)));
    for (std::size_t i = 0; i < s.y.size(); ++i) s.x.push_back(T * static_cast<double>(i));
    plot.series.push_back(std::move(s));
  }
  page.plot(std::move(plot));
  return page.write(out + "/report.html");
}

Result<int> run(const Options& o, const Common& common) {
  const auto plants = load_plants(o.motor, o.rotor);
  if (!plants) return Failure(plants.error());
  const auto tuning = tune_pidn(*plants, {.control_period_s = 1e-3 * o.period_ms,
                                          .max_sensitivity = o.max_sensitivity,
                                          .gain_spread = 0.01 * o.gain_spread_percent});
  if (!tuning) return Failure(tuning.error());
  const PidnGains& g = tuning->gains;
  const json j{{"schema", "omniflight.gains/1"},
               {"motor", o.motor},
               {"rotor", o.rotor},
               {"control_period_s", 1e-3 * o.period_ms},
               {"gains", {{"kp", g.kp}, {"ki", g.ki}, {"kd", g.kd}, {"n", g.n}}},
               {"nominal", to_json(tuning->nominal)},
               {"worst", to_json(tuning->worst)},
               {"overshoot", tuning->overshoot},
               {"rise_s", tuning->rise_s}};
  print_json(common, j);
  say(common, fmt::format("kp {:.5g}, ki {:.5g}, kd {:.5g}, n {:.5g} with a control period of {:.3g} ms",
                          g.kp, g.ki, g.kd, g.n, o.period_ms));
  say(common, "  mean motor: " + words(tuning->nominal));
  say(common, fmt::format("  worst of {} lags and gains within {:.0f} %: {}", plants->size(),
                          o.gain_spread_percent, words(tuning->worst)));
  say(common, fmt::format("  step: {:.1f} ms to 90 %, overshoot {:.1f} %", 1000 * tuning->rise_s,
                          100 * tuning->overshoot));
  const std::string out = common.out.empty() ? fresh_folder("gains") : common.out;
  auto lock = FolderLock::take(out);
  if (!lock) return Failure(lock.error());
  if (auto ok = files::write_file_atomic(out + "/gains.json", j.dump(2) + "\n"); !ok)
    return Failure(ok.error());
  if (auto ok = write_page(out, o, *tuning, *plants); !ok) return Failure(ok.error());
  say(common, "report: " + out + "/report.html");
  return 0;
}

}  // namespace

Action add_tune_motor(CLI::App& verb, Common& common) {
  auto o = std::make_shared<Options>();
  verb.add_option("motor", o->motor, "motor.json of identify-motor")->required();
  verb.add_option("--rotor", o->rotor, "Only this rotor, from 1; otherwise gains that serve all")
      ->check(CLI::Range(1, 16));
  verb.add_option("--control-period-ms", o->period_ms, "Period of the speed loop [ms]")
      ->check(not_negative(false));
  verb.add_option("--max-sensitivity", o->max_sensitivity, "Largest |1/(1+L)| that is allowed, 1.2 to 3");
  verb.add_option("--gain-spread-percent", o->gain_spread_percent,
                  "Motors this much stronger and weaker keep the margins as well [%]");
  return [o, &common] { return run(*o, common); };
}

}  // namespace omniflight::cli
