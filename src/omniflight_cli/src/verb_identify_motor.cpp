#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <limits>

#include "folder.hpp"
#include "load_all.hpp"
#include "motor_report.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_physics/effect_ids.hpp"
#include "omniflight_recording/formats.hpp"
#include "vehicle_update.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

struct IdentifyMotorOptions {
  std::vector<std::string> recordings, held_out;
  std::vector<int> rotors;
  std::string map, command, trend = "line", voltage = "auto", update;
  double split = 0.6, budget_s = 300, max_delay_ms = 50;
  int max_order = 3;
};

/// Data of a rotor from several recordings with one period.
Result<identification::Dataset> gather(const std::vector<recording::Recording>& recordings,
                                       const MotorSignals& signals, Eigen::Index rotor) {
  identification::Dataset all{signals.period_s, {}};
  for (const auto& r : recordings) {
    auto data = rotor_data(r, signals, rotor);
    if (!data) return data;
    for (auto& e : data->experiments) all.experiments.push_back(std::move(e));
  }
  return all;
}

Status same_signals(const std::vector<recording::Recording>& recordings, const MotorSignals& signals) {
  for (const auto& r : recordings) {
    const auto own = motor_signals(r, signals.command);
    if (!own) return Failure(own.error());
    if (own->rotors != signals.rotors)
      return bad_input(fmt::format("has {} rotors, the first recording {}", own->rotors, signals.rotors),
                       r.file, "Identify one vehicle at a time");
    if (std::abs(own->period_s - signals.period_s) > 0.05 * signals.period_s)
      return bad_input(fmt::format("is sampled every {:.3g} ms, the first recording every {:.3g} ms",
                                   1000 * own->period_s, 1000 * signals.period_s),
                       r.file, "Identify recordings of one rate together");
  }
  return {};
}

struct Split {
  identification::Dataset fit, validation;
};
Result<Split> split_data(const std::vector<recording::Recording>& fit,
                         const std::vector<recording::Recording>& held_out, const MotorSignals& signals,
                         Eigen::Index rotor, const IdentifyMotorOptions& o) {
  Split out;
  auto data = gather(fit, signals, rotor);
  if (!data) return Failure(data.error());
  if (held_out.empty()) {
    std::tie(out.fit, out.validation) = identification::split(*data, o.split);
    return out;
  }
  auto other = gather(held_out, signals, rotor);
  if (!other) return Failure(other.error());
  out.fit = std::move(*data);
  out.validation = std::move(*other);
  return out;
}

/// Of two uses of the voltage the one with which lag and delay simulate the validation data better. A battery
/// that does not move, or a command that is a speed, leaves one.
Result<VoltageUse> voltage_use(const std::vector<recording::Recording>& fit,
                               const std::vector<recording::Recording>& held_out, const MotorSignals& signals,
                               Eigen::Index rotor, const IdentifyMotorOptions& o,
                               const std::function<bool()>& stop) {
  if (signals.voltage == VoltageUse::none) return signals.voltage;
  const bool duty = signals.command != "rotor_command" && signals.reference_V > 0;
  VoltageUse best = VoltageUse::none;
  double percent = -std::numeric_limits<double>::infinity();
  for (const VoltageUse use : {VoltageUse::second_input, duty ? VoltageUse::product : VoltageUse::none}) {
    MotorSignals tried = signals;
    tried.voltage = use;
    const auto data = split_data(fit, held_out, tried, rotor, o);
    if (!data) return Failure(data.error());
    const auto motor = identification::fit_dynamics(
        data->fit, {.max_delay_s = 2e-3 * o.max_delay_ms,
                    .transient_samples = static_cast<Eigen::Index>(0.25 / signals.period_s),
                    .stop = stop});
    if (!motor) continue;
    const double here = identification::fit_percent(*motor, data->validation);
    if (here > percent) {
      percent = here;
      best = use;
    }
  }
  return best;
}

Result<RotorReport> identify(const std::vector<recording::Recording>& fit,
                             const std::vector<recording::Recording>& held_out, MotorSignals signals,
                             Eigen::Index rotor, const IdentifyMotorOptions& o,
                             const std::function<bool()>& stop) {
  const auto use = voltage_use(fit, held_out, signals, rotor, o, stop);
  if (!use) return Failure(use.error());
  signals.voltage = *use;
  auto data = split_data(fit, held_out, signals, rotor, o);
  if (!data) return Failure(data.error());
  identification::RotorOptions options;
  options.trend = o.trend == "mean" ? identification::Trend::mean : identification::Trend::line;
  options.max_delay_s = 1e-3 * o.max_delay_ms;
  options.max_order = o.max_order;
  options.stop = stop;
  auto result = identification::identify_rotor(data->fit, data->validation, options);
  if (!result) return Failure(result.error());
  return RotorReport{rotor, *use, std::move(*result), std::move(data->validation)};
}

Status write_results(const MotorReport& report, const IdentifyMotorOptions& o, const Common& common) {
  const std::string out = common.out.empty() ? fresh_folder("motor") : common.out;
  auto lock = FolderLock::take(out);
  if (!lock) return Failure(lock.error());
  if (auto ok = files::write_file_atomic(out + "/motor.json", to_json(report).dump(2) + "\n"); !ok) return ok;
  if (auto ok = page_of(report).write(out + "/report.html"); !ok) return ok;
  say(common, "report: " + out + "/report.html");
  if (o.update.empty()) return {};
  RotorField lag{"time_constant",
                 std::vector<double>(static_cast<std::size_t>(report.signals.rotors), std::nan("")), ""};
  double delay = 0, fit = 0;
  for (const RotorReport& r : report.rotors) {
    lag.values[static_cast<std::size_t>(r.rotor)] = r.result.motor.lag();
    delay += r.result.motor.delay / static_cast<double>(report.rotors.size());
    fit += r.result.validation_percent / static_cast<double>(report.rotors.size());
  }
  lag.provenance = fmt::format(
      "omniflight identify-motor: {} to speed of {} recording(s), first sha256 {}; mean of lag up and down; "
      "delay of "
      "{:.1f} ms beside it (effect {}); fit {:.0f} % on data not fitted to",
      report.signals.command, report.recordings.size(), report.sha256.front().substr(0, 12), 1000 * delay,
      physics::effect_id::transport_delay, fit);
  const auto file = update_vehicle(o.update, {lag});
  if (!file) return Failure(file.error());
  say(common, "updated: " + *file + " (time_constant)");
  return {};
}

Result<int> identify_motor(const IdentifyMotorOptions& o, const Common& common) {
  using clock = std::chrono::steady_clock;
  const auto end =
      clock::now() + std::chrono::duration_cast<clock::duration>(std::chrono::duration<double>(o.budget_s));
  const auto stop = [end] { return interrupted() || clock::now() > end; };
  auto fit = load_all(o.recordings, {o.map});
  if (!fit) return Failure(fit.error());
  auto held_out = load_all(o.held_out, {o.map});
  if (!held_out) return Failure(held_out.error());
  auto signals = motor_signals(fit->front(), o.command);
  if (!signals) return Failure(signals.error());
  if (auto ok = same_signals(*fit, *signals); !ok) return Failure(ok.error());
  if (auto ok = same_signals(*held_out, *signals); !ok) return Failure(ok.error());
  for (const auto* list : {&*fit, &*held_out})
    for (const auto& r : *list)
      if (o.voltage == "none" || r.find("vbat") == nullptr) signals->voltage = VoltageUse::none;

  MotorReport report{o.recordings, {}, o.held_out, *signals, {}, {}};
  for (const auto& r : *fit) report.sha256.push_back(r.sha256);
  std::vector<int> rotors = o.rotors;
  if (rotors.empty())
    for (int k = 1; k <= static_cast<int>(signals->rotors); ++k) rotors.push_back(k);
  for (const int rotor : rotors)
    if (rotor < 1 || rotor > static_cast<int>(signals->rotors))
      return bad_input(fmt::format("is {}, the recording has rotors 1 to {}", rotor, signals->rotors),
                       "--rotor");
  Progress progress("identifying", static_cast<double>(rotors.size()), "rotors", common.quiet || common.json);
  for (const int rotor : rotors) {
    auto one = identify(*fit, *held_out, *signals, rotor - 1, o, stop);
    if (one)
      report.rotors.push_back(std::move(*one));
    else
      report.failed.emplace_back(rotor - 1, one.error());
    progress.update(static_cast<double>(report.rotors.size() + report.failed.size()));
  }
  progress.finish();
  if (report.rotors.empty()) return Failure(report.failed.front().second);
  print_json(common, to_json(report));
  say(common, to_text(report));
  if (auto ok = write_results(report, o, common); !ok) return Failure(ok.error());
  return report.failed.empty() ? 0 : static_cast<int>(ErrorCode::incomplete);
}

}  // namespace

Action add_identify_motor(CLI::App& verb, Common& common) {
  auto o = std::make_shared<IdentifyMotorOptions>();
  verb.add_option("recordings", o->recordings, "Logs with command and measured speed of the rotors")
      ->required();
  verb.add_option("--held-out", o->held_out, "Logs to judge the models on; otherwise the end of each log is");
  verb.add_option("--rotor", o->rotors, "Only this rotor, from 1 (may be repeated)");
  verb.add_option("--command", o->command,
                  "Signal that is the command; otherwise the first of these that is there")
      ->check(CLI::IsMember({"rotor_command", "pwm", "motor_power"}));
  verb.add_option(
          "--voltage", o->voltage,
          "Battery voltage: auto (second input or factor of the command, whichever fits better), none")
      ->check(CLI::IsMember({"auto", "none"}));
  verb.add_option("--trend", o->trend, "Taken out before sampled models are fitted: mean or line")
      ->check(CLI::IsMember({"mean", "line"}));
  verb.add_option("--split", o->split, "Share of each log that is fitted to, without --held-out")
      ->check(CLI::Range(0.2, 0.9));
  verb.add_option("--max-order", o->max_order, "Largest number of poles")->check(CLI::Range(1, 6));
  verb.add_option("--max-delay-ms", o->max_delay_ms, "Longest delay that is looked for [ms]")
      ->check(CLI::Range(1.0, 500.0));
  verb.add_option("--update", o->update,
                  "Vehicle (name or path) whose file gets the lags, with their source");
  verb.add_option("--budget-s", o->budget_s, "Time for all searches [s]")->check(not_negative(false));
  add_map(verb, o->map);
  return [o, &common] { return identify_motor(*o, common); };
}

}  // namespace omniflight::cli
