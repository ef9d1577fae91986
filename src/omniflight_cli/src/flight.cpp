#include "flight_setup.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "bus_access.hpp"
#include "flight_page.hpp"
#include "flown_plan.hpp"
#include "omniflight_bus/domain.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "operator_desk.hpp"
#include "supervision.hpp"
#include "verbs.hpp"
#include "verdict.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kReport = "report.html";
constexpr double kArming = 600;  // s that an operator may take to arm

/// Starts what the flight needs, the clock master last.
Result<std::vector<Child>> start(const FlightOptions& o, const Setup& s, int domain) {
  std::vector<std::vector<std::string>> groups;
  std::vector<std::string> names = components_of(o);
  if (o.plant == "mujoco") names.pop_back();  // in a process of its own
  if (o.in_process)
    groups.push_back(names);
  else
    for (const auto& n : names) groups.push_back({n});
  if (o.plant == "mujoco") groups.push_back({plant_component(o)});  // never in one process with the simulator
  const long processors = sysconf(_SC_NPROCESSORS_ONLN);
  std::vector<Child> children;
  for (const auto& group : groups) {
    const auto program =
        find_program(group.size() > 1 ? "omniflight_container" : "omniflight_" + group.front());
    if (!program) return Failure(program.error());
    std::vector<std::string> arguments;
    if (group.size() > 1) arguments = group;
    for (const std::string& a :
         {std::string("--params"), s.defaults, (s.out / "params.yaml").string(), std::string("--domain"),
          std::to_string(domain), std::string("--loopback"), s.loopback})
      arguments.push_back(a);
    if (!o.lockstep()) arguments.push_back("--heartbeat");
    if (!o.keys.empty()) arguments.insert(arguments.end(), {"--secure", fs::absolute(o.keys).string()});
    ChildOptions child;
    child.log = (s.out / "log" / (group.size() > 1 ? "container.log" : group.front() + ".log")).string();
    // Lockstep partners take turns, so they share one processor: no wake-up of an idle one on every turn.
    if (!o.realtime && o.lockstep() && !o.in_process && processors > 1)
      child.cpu = group.front() == "recorder" || group.front() == "monitor"
                      ? static_cast<int>(processors) - 1
                      : static_cast<int>(domain % (processors - 1));
    child.prompt = o.realtime;
    auto started = Child::start(*program, arguments, child);
    if (!started) return Failure(started.error());
    children.push_back(std::move(*started));
  }
  return children;
}

/// The summary that the monitor left, and it in a line.
void read_monitor(const fs::path& file, FlightResult& result) {
  auto text = files::read_file(file, files::kMegabyte);
  const auto said = text ? nlohmann::json::parse(*text, nullptr, false) : nlohmann::json();
  if (!said.is_object() || !said.contains("checks")) {
    result.monitor = "monitor: no verdict; its log is in " + (file.parent_path() / "log").string();
    return;
  }
  result.json["monitor"] = said;
  result.monitor = "monitor: " + said.value("worst", "?");
  for (const auto& check : said["checks"])
    if (check.value("worst", "OK") != "OK")
      result.monitor +=
          fmt::format("; {} {} from {:.1f} s: {}", check.value("name", ""), check.value("worst", ""),
                      check.value("from_s", 0.0), check.value("message", ""));
}

/// The periods that the clock master missed, in the answer and in a line.
void read_periods(const fs::path& file, FlightResult& result) {
  auto text = files::read_file(file, files::kMegabyte);
  const auto said = text ? nlohmann::json::parse(*text, nullptr, false) : nlohmann::json();
  const auto count = [&](const char* key) -> std::optional<double> {
    if (!said.is_object() || !said.contains(key) || !said[key].is_number()) return {};
    return said[key].get<double>();
  };
  const auto periods = count("periods"), missed = count("periods_missed"), latest = count("latest_ms");
  if (!periods || !missed || !latest) {
    result.remarks.push_back("control periods are not counted: the gateway left no " +
                             file.filename().string());
    return;
  }
  result.json["silent"] = said.value("silent", nlohmann::json::array());
  for (const auto& silence : result.json["silent"])
    if (silence.is_object() && silence.value("back", false))
      result.remarks.push_back(fmt::format("{} stood still for {:.2f} s", silence.value("component", "?"),
                                           silence.value("for_s", 0.0)));
  result.json["periods"] = said["periods"];
  result.json["periods_missed"] = said["periods_missed"];
  result.json["period_latest_ms"] = *latest;
  if (count("page_faults")) result.json["page_faults"] = said["page_faults"];
  result.remarks.push_back(fmt::format("{:.0f} of {:.0f} control periods missed, the latest {:.1f} ms late",
                                       *missed, *periods, *latest));
}

/// The vehicle had left its reference when the failsafe of a simulated flight ended it. Every component did
/// its part, so the flight is complete; the vehicle is lost.
bool lost_to_the_failsafe(const FlightOptions& o, const FlightResult& result) {
  const Tracking& tracking = result.metrics.has_truth ? result.metrics.truth : result.metrics.measured;
  return o.lockstep() && tracking.left_at && result.json["losses"].empty() &&
         result.reason.find("the failsafe ended the flight") != std::string::npos;
}

/// Whether the plant carried what the mission says that the vehicle carries.
void tell_loads(const FlightOptions& o, const Setup& s, FlightResult& result) {
  if (!s.loaded_model.empty())
    result.remarks.push_back(std::string("the plant carries the mission's payload and tether, as in ") +
                             kLoadedModel);
  else if (o.plant == "mujoco" && (s.mission.payload || s.mission.tether))
    result.remarks.push_back(
        "the mujoco plant carries neither the mission's payload nor its tether: its "
        "world says what it flies with");
}

/// Measures the recording and judges it, unless something had ended the flight before.
void judge(const FlightOptions& o, const Setup& s, const recording::Recording& recording,
           FlightResult& result) {
  nlohmann::json& j = result.json;
  result.verdict = kNotFlown;
  if (auto metrics = assess(recording, s.vehicle)) {
    result.metrics = *metrics;
    j["metrics"] = to_json(*metrics);
    if (result.reason.empty()) {
      const auto flown = flown_plan(s);
      if (!flown) {
        result.reason = "the plans that were made in flight cannot be read: " + flown.error().text();
        j["reason"] = result.reason;
        return;
      }
      const FlightVerdict v =
          judge_flight({flown->plan, flown->mission, s.vehicle, flown->after}, recording, *metrics);
      result.verdict = v.word;
      result.reason = v.reason;
      result.complete = v.complete;
      j["judged"] = v.figures;
      std::vector<std::string> remarks = flown->remarks;
      remarks.insert(remarks.end(), v.remarks.begin(), v.remarks.end());
      j["remarks"] = remarks;
      result.remarks.insert(result.remarks.end(), remarks.begin(), remarks.end());
    } else if (lost_to_the_failsafe(o, result)) {
      result.verdict = kLost;
      result.complete = true;
    }
  } else if (result.reason.empty()) {
    result.reason = metrics.error().text();
  }
  result.flown = result.verdict == kFlown;
  j["complete"] = result.complete;
  j["verdict"] = result.verdict;
  j["reason"] = result.reason;
}

}  // namespace

Result<FlightResult> fly(const FlightOptions& o) {
  auto domain = o.domain < 0 ? bus::claim_free_domain() : bus::claim_domain(o.domain);
  if (!domain) return Failure(domain.error());
  auto setup = prepare(o);
  if (!setup) return Failure(setup.error());
  const Setup& s = *setup;
  if (!o.keys.empty()) domain->tell_keys(fs::canonical(o.keys).string());
  const auto known = told(o, s);
  if (!known) return Failure(known.error());
  if (auto ok = files::write_file_atomic(s.out / "told.yaml", *known); !ok) return Failure(ok.error());
  if (auto ok = files::write_file_atomic(s.out / "params.yaml", parameters(o, s)); !ok)
    return Failure(ok.error());

  auto started = start(o, s, domain->domain());
  if (!started) return Failure(started.error());
  Supervision how;
  how.limit_s = o.realtime || !o.lockstep() ? s.duration + 60.0 : 5.0 * s.duration + 60.0;
  how.lockstep = o.lockstep();
  if (o.plant == "hardware") how.limit_s += kArming;
  Supervised flight;
  {
    Progress progress("flight", how.limit_s, "s of wall time", o.quiet || !isatty(STDERR_FILENO));
    Keyboard keyboard;
    std::unique_ptr<OperatorDesk> desk;
    std::string gate_said;
    if (keyboard.there() && !o.lockstep()) {
      std::string keys = o.keys;
      if (auto ok = use_bus_of(domain->domain(), keys); !ok) return Failure(ok.error());
      auto joined = OperatorDesk::join(domain->domain());
      if (!joined) return Failure(joined.error());
      desk = std::move(*joined);
      std::fprintf(stderr, "keys: a arm, space or e emergency stop, s wind down, l land, h hold, r resume\n");
    }
    how.progress = [&](double wall_s) {
      progress.update(wall_s);
      if (desk && desk->gate() != gate_said) {
        gate_said = desk->gate();
        std::fprintf(stderr, "gate: %s\n", gate_said.c_str());
      }
      const auto key = desk ? keyboard.key() : std::nullopt;
      if (const std::string wish = key ? wish_of_key(*key) : ""; !wish.empty()) (void)desk->say(wish);
    };
    flight = supervise(*started, how);
  }
  end_in_order(*started, how, flight);
  FlightResult result;
  result.reason = flight.reason;
  for (const std::string& loss : flight.notes)
    if (flight.master_done) result.remarks.push_back("flown to the end without it: " + loss);
  if (flight.refused) return bad_input(result.reason, "flight", "Its log is in " + (s.out / "log").string());

  result.recording = (s.out / "flight.mcap").string();
  auto recording = recording::load(result.recording, {});
  if (!recording) {
    if (!result.reason.empty()) return fail(ErrorCode::incomplete, result.reason, "flight");
    return Failure(recording.error());
  }
  nlohmann::json& j = result.json;
  j = {{"schema", "omniflight.flight/1"},
       {"mission", s.plan.certificate.mission},
       {"plant", o.plant},
       {"seed", o.seed},
       {"inputs_sha256", s.fingerprint},
       {"recording", "flight.mcap"},
       {"recording_sha256", recording->sha256},
       {"simulated_s", recording->duration_s},
       {"wall_s", flight.wall_s},
       {"synthetic", o.plant != "hardware"}};
  j["losses"] = flight.notes;  // components that ended before the flight did
  j["recording_notes"] = nlohmann::json::array();
  for (const auto& note : recording->notes) j["recording_notes"].push_back(note.text);
  if (!o.lockstep()) read_periods(s.out / kPeriods, result);
  if (o.monitor) read_monitor(s.out / "monitor.json", result);
  tell_loads(o, s, result);
  judge(o, s, *recording, result);
  if (auto ok = files::write_file_atomic(s.out / "flight.json", j.dump(2) + "\n"); !ok)
    return result.flown ? Result<FlightResult>(Failure(ok.error()))
                        : fail(ErrorCode::incomplete, result.reason, "flight", ok.error().text());
  if (o.page)
    if (auto ok = write_flight_page(o, result, *recording, s.vehicle, (s.out / kReport).string()); !ok)
      result.remarks.push_back("no page: " + ok.error().text());
  return result;
}

}  // namespace omniflight::cli
