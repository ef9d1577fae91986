#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cmath>
#include <filesystem>

#include "folder.hpp"
#include "motor_file.hpp"
#include "motor_verbs.hpp"
#include "omniflight_recording/formats.hpp"
#include "speed_errors.hpp"

namespace omniflight::cli {
namespace {

using nlohmann::json;

struct CompareRunsOptions {
  std::vector<std::string> recordings;
  std::string runs = "runs.csv", gains, map;
};

Result<int> compare_runs(const CompareRunsOptions& o, const Common& common) {
  identification::PidnGains gains{std::nan(""), std::nan(""), std::nan(""), std::nan("")};
  if (!o.gains.empty()) {
    const auto told = load_gains(o.gains);
    if (!told) return Failure(told.error());
    gains = *told;
  }
  std::vector<RunRow> fresh;
  for (const std::string& path : o.recordings) {
    recording::LoadOptions options;
    options.map = o.map;
    const auto r = recording::load(path, options);
    if (!r) return Failure(r.error());
    const auto errors = speed_errors(*r);
    if (!errors) return Failure(errors.error());
    fresh.push_back({now_utc(), path, gains, *errors});
  }
  const std::filesystem::path file =
      common.out.empty() ? std::filesystem::path(o.runs) : std::filesystem::path(common.out) / o.runs;
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  auto lock = FolderLock::take(folder);  // no other run appends meanwhile
  if (!lock) return Failure(lock.error());
  auto rows = read_runs(file.string());
  if (!rows) return Failure(rows.error());
  const std::size_t rotors =
      rows->empty() ? fresh.front().errors.mean.size() : rows->front().errors.mean.size();
  json list = json::array();
  for (RunRow& row : fresh) {
    if (row.errors.mean.size() != rotors)
      return bad_input(fmt::format("has {} rotors, the runs before it {}", row.errors.mean.size(), rotors),
                       row.log, "Keep one runs.csv for each vehicle");
    const auto best = best_run(*rows);
    const double before = best ? (*rows)[*best].errors.overall() : std::nan("");
    const bool better = !best || row.errors.overall() < before;
    say(common,
        fmt::format("{}: mean error {:.3f} rad/s{}", row.log, row.errors.overall(),
                    !best    ? ", the first run"
                    : better ? fmt::format(", better than {:.3f} of {}", before, (*rows)[*best].log)
                             : fmt::format(", not better than {:.3f} of {}", before, (*rows)[*best].log)));
    for (std::size_t k = 0; k < rotors; ++k)
      say(common, fmt::format("  rotor {}: mean {:.3f}, maximum {:.3f} rad/s", k + 1, row.errors.mean[k],
                              row.errors.max[k]));
    list.push_back({{"log", row.log},
                    {"mean_radps", row.errors.mean},
                    {"max_radps", row.errors.max},
                    {"overall_radps", row.errors.overall()},
                    {"better", better}});
    rows->push_back(std::move(row));
  }
  if (auto ok = write_runs(file.string(), *rows); !ok) return Failure(ok.error());
  const RunRow& best = (*rows)[*best_run(*rows)];
  print_json(common,
             {{"schema", "omniflight.compare_runs/1"},
              {"runs_file", file.string()},
              {"runs", list},
              {"best", {{"log", best.log}, {"time", best.time}, {"overall_radps", best.errors.overall()}}}});
  say(common, fmt::format("best of {} runs: {} ({:.3f} rad/s); written: {}", rows->size(), best.log,
                          best.errors.overall(), file.string()));
  return 0;
}

}  // namespace

Action add_compare_runs(CLI::App& verb, Common& common) {
  auto o = std::make_shared<CompareRunsOptions>();
  verb.add_option("recordings", o->recordings, "Logs with commanded and measured speed of the rotors [rad/s]")
      ->required();
  verb.add_option("--runs", o->runs, "List of runs that these are appended to");
  verb.add_option("--gains", o->gains, "gains.json that was flown, kept beside the errors");
  add_map(verb, o->map);
  return [o, &common] { return compare_runs(*o, common); };
}

}  // namespace omniflight::cli
