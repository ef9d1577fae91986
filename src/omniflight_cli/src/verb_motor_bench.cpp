#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <filesystem>
#include <sstream>

#include "folder.hpp"
#include "motor_file.hpp"
#include "motor_verbs.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_gateway/bench_motors.hpp"
#include "omniflight_gateway/motor_bench.hpp"
#include "omniflight_identification/prbs.hpp"

namespace omniflight::cli {
namespace {

using namespace gateway;
using nlohmann::json;

struct MotorBenchOptions {
  std::string devices, gains;
  std::size_t rotors = 4;
  identification::PrbsConfig prbs;
  double max_speed = 2000, motor_rate_hz = 500;
  BenchMotorConfig motors;
  double lag_up_ms = 34, lag_down_ms = 50, delay_ms = 6;
};

/// A folder under the system's temporary one that goes with this object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "omniflight_bench_XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ec;
    if (!path_.empty()) std::filesystem::remove_all(path_, ec);
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

GatewayConfig gateway_config(const MotorBenchOptions& o, const std::vector<std::string>& devices) {
  GatewayConfig config;
  for (const std::string& device : devices)
    config.boards.push_back({device, std::min<std::size_t>(o.rotors, 4)});
  config.rotors = o.rotors;
  config.imu_rate_hz = 0;
  config.motor_rate_hz = o.motor_rate_hz;
  config.battery_rate_hz = 10;
  return config;
}

/// Ours are command per rad/s; boards count revolutions a second, and take the filter as 1000/s
/// (docs/how_to/motors.md).
Result<std::optional<BoardGains>> board_gains(const std::string& file) {
  if (file.empty()) return std::optional<BoardGains>();
  const auto g = load_gains(file);
  if (!g) return Failure(g.error());
  const BoardGains gains{2 * kPi * g->kp, 2 * kPi * g->ki, 2 * kPi * g->kd, 1e-3 * g->n};
  if (const auto counts = to_counts(gains, 1); !counts) return Failure(counts.error());
  return std::optional<BoardGains>(gains);
}

BenchConfig bench_config(const MotorBenchOptions& o, const std::optional<BoardGains>& gains) {
  BenchConfig config;
  config.gains = gains;
  config.period_s = o.prbs.period_s;
  config.max_speed_radps = o.max_speed;
  // the signal's own steps pass the gate, and nothing more sudden
  config.max_acceleration_radps2 = 1.1 * (o.prbs.high - o.prbs.low) / o.prbs.period_s + 2 * o.prbs.high;
  return config;
}

/// Emulated boards and motors, in their own time: as fast as this machine goes.
Result<BenchRecord> run_emulated(const MotorBenchOptions& o, const BenchConfig& bench,
                                 std::span<const double> command) {
  const TemporaryFolder folder;
  if (folder.path().empty())
    return bad_input("no temporary folder can be made", "TMPDIR", "Set it to a folder");
  BenchMotorConfig config = o.motors;
  config.rotors = o.rotors;
  config.lag_up_s = 1e-3 * o.lag_up_ms;
  config.lag_down_s = 1e-3 * o.lag_down_ms;
  config.delay_s = 1e-3 * o.delay_ms;
  BenchMotors motors(config);
  EmulatorConfig boards;
  boards.link_directory = folder.path();
  boards.line = LineKind::socket;
  for (std::size_t first = 0; first < o.rotors; first += 4) {
    EmulatedBoardConfig board;
    board.rotor_offset = first;
    board.rotors = std::min<std::size_t>(4, o.rotors);
    boards.boards.push_back(board);
  }
  auto emulator = BoardEmulator::create(std::move(boards), motors);
  if (!emulator) return Failure(emulator.error());
  std::vector<std::string> devices;
  for (std::size_t i = 0; i < emulator->board_count(); ++i) devices.push_back(emulator->device(i));
  auto gateway = Gateway::create(gateway_config(o, devices));
  if (!gateway) return Failure(gateway.error());
  double now_s = 0;
  const BenchClock clock{[&] { return now_s; },
                         [&](double until_s) -> Status {
                           now_s = until_s;
                           motors.step(now_s);
                           const Status ok = emulator->step(now_s);
                           motors.take_gains(*emulator);
                           return ok;
                         },
                         interrupted};
  return run_motor_bench(*gateway, o.rotors, command, bench, clock);
}

Result<BenchRecord> run_hardware(const MotorBenchOptions& o, const BenchConfig& bench,
                                 std::span<const double> command) {
  std::vector<std::string> devices;
  std::stringstream list(o.devices);
  for (std::string device; std::getline(list, device, ';');) devices.push_back(device);
  install_interrupt_handler(SecondInterrupt::is_ignored);  // the motors wind down first
  auto gateway = Gateway::create(gateway_config(o, devices));
  if (!gateway) return Failure(gateway.error());
  using steady = std::chrono::steady_clock;
  const auto begin = steady::now();
  const auto now = [begin] { return std::chrono::duration<double>(steady::now() - begin).count(); };
  const BenchClock clock{now,
                         [&](double until_s) -> Status {
                           while (now() < until_s) gateway->wait(std::min(1.0, until_s - now()));
                           return {};
                         },
                         interrupted};
  return run_motor_bench(*gateway, o.rotors, command, bench, clock);
}

/// Canonical CSV: commands and measured speeds at their own times.
std::string csv_of(const BenchRecord& record, std::size_t rotors) {
  struct Row {
    double t;
    std::string cells;
  };
  std::string header = "t_s", blank;
  for (std::size_t k = 1; k <= rotors; ++k) header += fmt::format(",rotor{}_cmd_radps", k);
  for (std::size_t k = 1; k <= rotors; ++k) header += fmt::format(",rotor{}_radps", k);
  for (std::size_t k = 1; k <= rotors; ++k) header += fmt::format(",pwm{}", k);
  const std::string none(rotors, ',');
  std::vector<Row> rows;
  for (std::size_t i = 0; i < record.command_s.size(); ++i) {
    std::string cells;
    for (std::size_t k = 0; k < rotors; ++k) cells += fmt::format(",{:.6f}", record.command_radps[i]);
    rows.push_back({record.command_s[i], cells + none + none + ","});
  }
  // the boards report their rotors one after the other: the samples of one instant make one row
  std::vector<std::vector<const RotorSample*>> of(rotors);
  for (const RotorSample& s : record.rotors)
    if (s.rotor < rotors && s.spinning) of[s.rotor].push_back(&s);
  std::size_t count = of.front().size();
  for (const auto& list : of) count = std::min(count, list.size());
  for (std::size_t i = 0; i < count; ++i) {
    std::string cells = none;
    for (std::size_t k = 0; k < rotors; ++k) cells += fmt::format(",{:.6f}", of[k][i]->speed_radps);
    for (std::size_t k = 0; k < rotors; ++k) cells += fmt::format(",{:.6f}", of[k][i]->throttle);
    rows.push_back({of.front()[i]->time_s, cells + ","});
  }
  for (const BatterySample& s : record.battery)
    rows.push_back({s.arrival_s, none + none + none + fmt::format(",{:.4f}", s.voltage_V)});
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.t < b.t; });
  std::string text = header + ",vbat_V\n";
  for (const Row& row : rows) text += fmt::format("{:.7f}{}\n", row.t, row.cells);
  return text;
}

Result<int> motor_bench(const MotorBenchOptions& o, const Common& common) {
  if (o.rotors > 4 && o.rotors % 4 != 0)
    return bad_input(fmt::format("are {}; a board drives four", o.rotors), "--rotors",
                     "Choose 1 to 4, 8, 12 or 16");
  const auto prbs = identification::make_prbs(o.prbs);
  if (!prbs) return Failure(prbs.error());
  const auto gains = board_gains(o.gains);
  if (!gains) return Failure(gains.error());
  const BenchConfig bench = bench_config(o, *gains);
  const std::span<const double> command(prbs->values.data(), static_cast<std::size_t>(prbs->values.size()));
  const std::string out = common.out.empty() ? fresh_folder("bench") : common.out;
  auto lock = FolderLock::take(out);
  if (!lock) return Failure(lock.error());
  say(common, fmt::format("PRBS of {:.0f} and {:.0f} rad/s, bits of {:.1f} ms (band {:.2g} Hz), {:.0f} s, {}",
                          o.prbs.low, o.prbs.high, 1000 * prbs->bit_s, o.prbs.band_hz,
                          o.prbs.period_s * static_cast<double>(command.size()),
                          o.devices.empty() ? "emulated boards and motors" : "boards at " + o.devices));
  const auto record = o.devices.empty() ? run_emulated(o, bench, command) : run_hardware(o, bench, command);
  if (!record) return Failure(record.error());
  const std::string file = out + "/bench.csv";
  if (auto ok = files::write_file_atomic(file, csv_of(*record, o.rotors)); !ok) return Failure(ok.error());
  print_json(common, {{"schema", "omniflight.motor_bench/1"},
                      {"log", file},
                      {"emulated", o.devices.empty()},
                      {"rotors", o.rotors},
                      {"prbs",
                       {{"low_radps", o.prbs.low},
                        {"high_radps", o.prbs.high},
                        {"bit_s", prbs->bit_s},
                        {"register_bits", prbs->register_bits},
                        {"seed", o.prbs.seed}}},
                      {"commands_refused", record->refused},
                      {"samples_missed", record->missed},
                      {"gains_read_back", record->gains_confirmed},
                      {"complete", record->complete}});
  say(common,
      fmt::format("{} commands ({} refused), {} samples of {} rotors ({} lost): {}", record->command_s.size(),
                  record->refused, record->rotors.size(), o.rotors, record->missed, file));
  if (bench.gains)
    say(common, record->gains_confirmed > 0
                    ? fmt::format("gains read back from {} of {} motors", record->gains_confirmed, o.rotors)
                    : "gains sent; the boards did not tell them back");
  say(common, "next: omniflight identify-motor " + file);
  return record->complete && record->refused == 0 ? 0 : static_cast<int>(ErrorCode::incomplete);
}

}  // namespace

Action add_motor_bench(CLI::App& verb, Common& common) {
  auto o = std::make_shared<MotorBenchOptions>();
  o->prbs.period_s = 0.005;
  verb.add_option("--low", o->prbs.low, "Slower of the two speeds [rad/s]")->required();
  verb.add_option("--high", o->prbs.high, "Faster of the two speeds [rad/s]")->required();
  verb.add_option("--band-hz", o->prbs.band_hz, "Where the signal has lost half its power [Hz]");
  verb.add_option("--duration-s", o->prbs.duration_s, "Length [s]");
  verb.add_option("--max-slope", o->prbs.max_slope, "Largest change of the command [rad/s2]; 0: steps");
  verb.add_option("--command-period-s", o->prbs.period_s, "Between commands [s]");
  verb.add_option("--seed", o->prbs.seed, "Start of the sequence");
  verb.add_option("--max-speed", o->max_speed, "No command is beyond this [rad/s]")
      ->check(not_negative(false));
  verb.add_option("--rotors", o->rotors, "Motors on the bench")->check(CLI::Range(1, 16));
  verb.add_option("--motor-rate-hz", o->motor_rate_hz, "Speed samples of each motor [Hz]")
      ->check(CLI::Range(10.0, 2000.0));
  verb.add_option(
      "--devices", o->devices,
      "Serial devices of the boards, with ';' between; without it boards and motors are emulated");
  verb.add_option("--gains", o->gains,
                  "gains.json of tune-motor, sent to the boards before the motors start");
  verb.add_flag("--speed-loop", o->motors.speed_loop,
                "Emulated boards close a speed loop around motors that follow a throttle");
  verb.add_option("--lag-up-ms", o->lag_up_ms, "Of the emulated motors [ms]")->check(not_negative(false));
  verb.add_option("--lag-down-ms", o->lag_down_ms, "Of the emulated motors [ms]")->check(not_negative(false));
  verb.add_option("--delay-ms", o->delay_ms, "Of the emulated motors [ms]")->check(not_negative());
  return [o, &common] { return motor_bench(*o, common); };
}

}  // namespace omniflight::cli
