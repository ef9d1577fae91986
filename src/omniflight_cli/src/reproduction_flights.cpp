#include "reproduction_flights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <set>
#include <thread>

#include "investigation.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "process.hpp"
#include "verbs.hpp"
#include "verdict.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kEnding = 30;  // s that a diagnosis gets to write its answer after its budget

/// What figures read; the rest of a recording would fill memory for nothing.
void keep_signals(recording::Recording& r) {
  static const std::set<std::string> kept{
      "position",     "attitude",      "est_position",   "est_attitude",
      "ref_position", "ref_attitude",  "ref_velocity",   "ref_angular_velocity",
      "rotor_speed",  "rotor_command", "thrust_command", "qddr",
      "integral"};
  for (auto at = r.signals.begin(); at != r.signals.end();)
    at = kept.count(at->first) > 0 ? std::next(at) : r.signals.erase(at);
}

/// The recording of a flight that is there; a remark when it did not end as flown.
Result<recording::Recording> get(const FlightOptions& options, const std::string& name, std::string& remark) {
  const auto flown = flown_before(options);
  if (!flown) return fail(ErrorCode::incomplete, "it was not flown to the end", name);
  if (const std::string verdict = flown->value("verdict", ""); verdict != kFlown)
    remark = name + ": " + verdict + " (" + flown->value("reason", "") + ")";
  auto recording = recording::load(options.out + "/flight.mcap", {});
  if (!recording) return Failure(recording.error());
  keep_signals(*recording);
  return recording;
}

}  // namespace

WorkTime::WorkTime(double budget_s) : budget_s_(budget_s), begin_(std::chrono::steady_clock::now()) {}

double WorkTime::left_s() const {
  if (budget_s_ <= 0) return std::numeric_limits<double>::infinity();
  return budget_s_ - std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

bool WorkTime::over() const { return interrupted() || left_s() <= 0; }

Result<FlightOptions> options_of(const reproduction::Flight& flight, const std::string& folder) {
  if (auto ok = make_folder(folder); !ok) return Failure(ok.error());
  FlightOptions o;
  o.mission = flight.mission;
  o.plant = flight.plant;
  o.sensors = flight.sensors;
  o.parameters = flight.parameters;
  o.out = folder + "/" + flight.name;
  o.realtime = !o.lockstep();
  o.in_process = o.plant == "simulator";
  o.quiet = o.force = true;
  for (const auto& [text, place, ending] : {std::tuple{&flight.model, &o.effects, ".model.yaml"},
                                            std::tuple{&flight.world, &o.world, ".world.yaml"}}) {
    if (text->empty()) continue;
    *place = o.out + ending;
    if (auto ok = files::write_file_atomic(*place, *text); !ok) return Failure(ok.error());
  }
  return o;
}

Result<int> fly_reproduction(const std::string& name, const std::string& out) {
  const auto* flight = reproduction::find_flight(name);
  if (!flight) return bad_input("there is no flight " + files::shown(name), "--fly");
  auto options = options_of(*flight, out + "/inputs");
  if (!options) return Failure(options.error());
  options->out = out;
  const auto result = fly_as_job(*options, name);
  if (!result) return Failure(result.error());
  if (!result->complete) return fail(ErrorCode::incomplete, result->reason, name);
  return 0;
}

Result<FlownFlights> fly_all(const std::vector<std::string>& names, const std::string& folder,
                             jobs::Executor& executor, const WorkTime& time, const Common& common,
                             const std::function<void(std::size_t)>& done) {
  FlownFlights out;
  std::vector<std::string> order = names;
  std::stable_partition(order.begin(), order.end(), [](const std::string& name) {
    const auto* f = reproduction::find_flight(name);
    return f && f->plant == "emulator";
  });
  std::vector<FlightOptions> options;
  std::vector<jobs::Job> list;
  for (const std::string& name : order) {
    const auto* flight = reproduction::find_flight(name);
    if (!flight) return fail(ErrorCode::internal, "there is no such flight", name);
    auto o = options_of(*flight, folder);
    if (!o) return Failure(o.error());
    if (!flown_before(*o))
      if (auto ok = clear_away(o->out); !ok) return Failure(ok.error());
    list.push_back({name,
                    fs::absolute(o->out).lexically_normal(),
                    {"reproduce", "--fly", name, "--out", jobs::kOut, "--quiet"}});
    options.push_back(std::move(*o));
  }
  auto work = work_of(folder, list, common, done);
  work.may_begin = [&time] { return !time.over(); };
  const auto ran = executor.run(work);
  if (!ran) return Failure(ran.error());
  for (const auto& m : ran->missing) out.missing.emplace(order[m.job], m.reason);
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (out.missing.contains(order[k])) continue;
    std::string remark;
    auto got = is_done(list[k])
                   ? get(options[k], order[k], remark)
                   : Result<recording::Recording>(fail(ErrorCode::incomplete, "interrupted", order[k]));
    if (got)
      out.recordings.emplace(order[k], std::move(*got));
    else
      out.missing.emplace(order[k], got.error().text());
    if (!remark.empty()) out.remarks.push_back(remark);
  }
  out.remarks.insert(out.remarks.end(), ran->remarks.begin(), ran->remarks.end());
  std::sort(out.remarks.begin(), out.remarks.end());
  return out;
}

Result<std::string> diagnose_flights(const std::vector<std::string>& names, const std::string& folder,
                                     double most_s) {
  const std::string out = folder + "/diagnosis", key_file = out + "/inputs.sha256";
  std::vector<std::string> arguments{"diagnose"};
  std::string all = std::to_string(names.size());
  for (const std::string& name : names) {
    arguments.push_back(folder + "/" + name + "/flight.mcap");
    const auto sum = files::sha256_file(arguments.back());
    if (!sum) return Failure(sum.error());
    all += *sum;
  }
  const std::string key = files::sha256_hex(all);
  const auto before = files::read_file(key_file, 1000);
  auto kept = files::read_file(out + "/diagnosis.json", 64 * files::kMegabyte);
  if (before && kept && *before == key) return kept;
  if (most_s < kEnding) return fail(ErrorCode::incomplete, "no time was left for it", "diagnosis");
  if (auto ok = make_folder(out); !ok) return Failure(ok.error());
  arguments.insert(arguments.end(), {"--vehicle", "omnimorph", "--quiet", "--budget-s",
                                     fmt::format("{:.0f}", most_s), "--out", out});
  auto child = Child::start(this_program(), arguments, {.log = out + "/log.txt"});
  if (!child) return Failure(child.error());
  const WorkTime time(most_s + kEnding);
  std::optional<int> code;
  while (!(code = child->poll())) {
    if (time.over()) return fail(ErrorCode::incomplete, "was stopped before it had an answer", "diagnosis");
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  auto text = files::read_file(out + "/diagnosis.json", 64 * files::kMegabyte);
  if (*code != 0 && *code != static_cast<int>(ErrorCode::incomplete))
    return fail(ErrorCode::incomplete, child->last_words(), "diagnosis", "Its log is " + out + "/log.txt");
  if (text && *code == 0)
    if (auto ok = files::write_file_atomic(key_file, key); !ok) return Failure(ok.error());
  return text;
}

}  // namespace omniflight::cli
