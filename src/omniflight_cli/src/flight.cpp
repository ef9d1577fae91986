#include "flight_setup.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <thread>

#include "omniflight_bus/domain.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "process.hpp"
#include "verbs.hpp"
#include "verdict.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

// s of wall time for the rest to notice that a component is gone; none is needed for the recorder or a
// component that never began
constexpr double kGrace = 4.0, kGraceShort = 0.5;

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

/// Measures the recording and judges it, unless something had ended the flight before.
void judge(const Setup& s, const recording::Recording& recording, FlightResult& result) {
  nlohmann::json& j = result.json;
  result.verdict = kNotFlown;
  if (auto metrics = assess(recording, s.vehicle)) {
    result.metrics = *metrics;
    j["metrics"] = to_json(*metrics);
    if (result.reason.empty()) {
      const FlightVerdict v = judge_flight({s.plan, s.mission, s.vehicle, s.after}, recording, *metrics);
      result.verdict = v.word;
      result.reason = v.reason;
      result.complete = v.complete;
      j["judged"] = v.figures;
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
  const auto known = told(o, s);
  if (!known) return Failure(known.error());
  if (auto ok = files::write_file_atomic(s.out / "told.yaml", *known); !ok) return Failure(ok.error());
  if (auto ok = files::write_file_atomic(s.out / "params.yaml", parameters(o, s)); !ok)
    return Failure(ok.error());

  const auto begin = std::chrono::steady_clock::now();
  const auto wall = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  auto started = start(o, s, domain->domain());
  if (!started) return Failure(started.error());
  std::vector<Child>& children = *started;
  const double limit = (o.realtime || !o.lockstep() ? s.duration + 60.0 : 5.0 * s.duration + 60.0);
  FlightResult result;
  bool refused = false;  // a component would not start with its parameters
  {
    Progress progress("flight", limit, "s of wall time", o.quiet || !isatty(STDERR_FILENO));
    Child& master = children.back();
    double give_up = limit;  // wall time; sooner once a component is lost
    while (!master.poll()) {
      progress.update(wall());
      for (Child& child : children)
        if (&child != &master && child.poll() && result.reason.empty()) {
          result.reason = child.name() + " ended in flight (exit code " + std::to_string(*child.poll()) +
                          "): " + child.last_words();
          refused = result.reason.find("] not configured") != std::string::npos;
          give_up = wall() + (refused || &child == &children.front() ? kGraceShort : kGrace);
        }
      if (interrupted()) result.reason = "interrupted";
      if (wall() > limit && result.reason.empty())
        result.reason = "took longer than " + std::to_string(limit) + " s";
      // a component is gone: the clock master notices by its own deadline and ends the flight in order
      if (interrupted() || wall() > give_up) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    if (const auto code = master.poll(); code && *code != 0 && result.reason.empty())
      result.reason =
          master.name() + " ended early (exit code " + std::to_string(*code) + "): " + master.last_words();
    refused = refused || result.reason.find("] not configured") != std::string::npos;
  }
  const double flight_wall = wall();
  // One that is gone keeps the others waiting for its acknowledgements, so they end side by side.
  if (!result.reason.empty())
    for (std::size_t k = children.size(); k-- > 1;) children[k].ask_to_end();
  while (!children.empty()) {  // in reverse: the recorder last
    Child& child = children.back();
    const bool was_running = !child.poll();
    const int code = child.terminate(5.0);
    if (code != 0 && was_running && result.reason.empty())
      result.reason = child.name() + " did not end in order (exit code " + std::to_string(code) +
                      "): " + child.last_words();
    children.pop_back();
  }

  if (refused) return bad_input(result.reason, "flight", "Its log is in " + (s.out / "log").string());

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
       {"wall_s", flight_wall},
       {"synthetic", o.plant != "hardware"}};
  j["recording_notes"] = nlohmann::json::array();
  for (const auto& note : recording->notes) j["recording_notes"].push_back(note.text);
  if (o.monitor) read_monitor(s.out / "monitor.json", result);
  judge(s, *recording, result);
  if (auto ok = files::write_file_atomic(s.out / "flight.json", j.dump(2) + "\n"); !ok)
    return result.flown ? Result<FlightResult>(Failure(ok.error()))
                        : fail(ErrorCode::incomplete, result.reason, "flight", ok.error().text());
  return result;
}

}  // namespace omniflight::cli
