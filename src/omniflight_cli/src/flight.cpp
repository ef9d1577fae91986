#include "flight.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <thread>

#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_planning/plan.hpp"
#include "omniflight_recording/formats.hpp"
#include "process.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kHold = 1.0, kSettle = 3.0, kAfter = 1.0;  // s around the trajectory
// s of wall time for the rest to notice that a component is gone; none is needed for the recorder or a
// component that never began
constexpr double kGrace = 4.0, kGraceShort = 0.5;

std::string join(const std::vector<std::string>& items) {
  std::string out;
  for (const auto& i : items) out += (out.empty() ? "" : ";") + i;
  return out;
}

std::string quoted(const std::string& text) { return nlohmann::json(text).dump(); }

struct Setup {
  planning::Plan plan;
  std::string mission_vehicle;
  fs::path out;
  std::string sensors, effects, defaults, loopback;
  double duration = 0;
  std::int64_t epoch_ns = 0;
};

/// The parameters of this flight, on top of configs/components/default.yaml.
std::string parameters(const FlightOptions& o, const Setup& s) {
  const std::string vehicle = o.vehicle.empty() ? s.mission_vehicle : o.vehicle;
  const auto& knot = s.plan.trajectory.knots().front().reference;
  const Vec3 rpy = roll_pitch_yaw(knot.q_WB) * (180.0 / kPi);
  const double alpha = to_degrees(s.plan.certificate.alpha);
  std::map<std::string, std::map<std::string, std::string>> p;
  const auto common = [&](const std::string& component) {
    p[component]["vehicle"] = quoted(vehicle);
    p[component]["vehicle_set"] = quoted(join(o.set));
  };
  p["recorder"] = {
      {"file", quoted((s.out / "flight.mcap").string())},
      {"overwrite", "true"},
      {"record_truth", o.plant == "hardware" ? "false" : "true"},
      {"metadata", quoted(fmt::format("vehicle={};plant={};mission={};seed={};synthetic={};map_sha256={};"
                                      "vehicle_sha256={};mission_sha256={}",
                                      vehicle, o.plant, s.plan.certificate.mission, o.seed,
                                      o.plant == "hardware" ? "no" : "yes", s.plan.certificate.map_sha256,
                                      s.plan.certificate.vehicle_sha256, s.plan.certificate.mission_sha256))},
      {"attachments", quoted((s.out / "plan" / "certificate.json").string())}};
  p["planner"] = {{"plan", quoted((s.out / "plan").string())}};
  common("allocator");
  p["allocator"]["alpha_deg"] = fmt::format("{:.17g}", alpha);
  p["allocator"]["weights"] = o.weights;
  p["allocator"]["tilt_mode"] = o.tilt_mode;
  p["controller"]["settle_s"] = fmt::format("{}", kSettle);
  const auto plant = [&](const std::string& component) {
    common(component);
    auto& q = p[component];
    q["model"] = quoted(s.effects);
    q["sensors"] = quoted(s.sensors);
    q["seed"] = std::to_string(o.seed);
    q["hold_s"] = fmt::format("{}", kHold);
    q["duration_s"] = fmt::format("{:.17g}", s.duration);
    q["initial_position_m"] =
        fmt::format("[{:.17g}, {:.17g}, {:.17g}]", knot.p_WB.x(), knot.p_WB.y(), knot.p_WB.z());
    q["initial_rpy_deg"] = fmt::format("[{:.17g}, {:.17g}, {:.17g}]", rpy.x(), rpy.y(), rpy.z());
    q["initial_alpha_deg"] = fmt::format("{:.17g}", alpha);
  };
  if (o.plant == "simulator") {
    plant("simulator");
    p["simulator"]["rate"] = o.realtime ? "realtime" : "max";
    p["simulator"]["recorder_window_ticks"] = "200";
  } else {
    const std::string links = (s.out / "boards").string();
    if (o.plant == "emulator") {
      plant("emulator");
      p["emulator"]["link_directory"] = quoted(links);
      p["emulator"]["epoch_ns"] = std::to_string(s.epoch_ns);
    }
    common("gateway");
    auto& g = p["gateway"];
    g["devices"] = quoted(o.plant == "emulator" ? links + "/board0;" + links + "/board1;" + links + "/board2"
                                                : o.devices);
    g["epoch_ns"] = std::to_string(s.epoch_ns);
    g["hold_s"] = "2.0";
    g["flight_s"] = fmt::format("{:.17g}", kSettle + s.plan.trajectory.duration() + kAfter);
    g["alpha_deg"] = fmt::format("{:.17g}", alpha);
  }
  for (const auto& [key, value] : o.parameters) {
    const auto dot = key.find('.');
    if (dot != std::string::npos) p[key.substr(0, dot)][key.substr(dot + 1)] = value;
  }
  std::string yaml = "# Parameters of this flight, on top of configs/components/default.yaml.\n";
  for (const auto& [component, values] : p) {
    yaml += component + ":\n  ros__parameters:\n";
    for (const auto& [key, value] : values) yaml += "    " + key + ": " + value + "\n";
  }
  return yaml;
}

Result<Setup> prepare(const FlightOptions& o) {
  Setup s;
  s.out = fs::absolute(o.out);
  // everything that can be wrong with the input is looked at before the first file is written
  auto mission = planning::load_mission(o.mission);
  if (!mission) return Failure(mission.error());
  s.mission_vehicle = mission->vehicle;
  if (!o.plan.empty()) {
    auto plan = planning::read_plan(o.plan);
    if (!plan) return Failure(plan.error());
    s.plan = std::move(*plan);
  } else {
    planning::PlanOptions options;
    auto plan = planning::plan_mission(*mission, options);
    if (!plan) return Failure(plan.error());
    s.plan = std::move(*plan);
  }
  auto sensors = find_config("sensors", o.sensors);
  if (!sensors) return Failure(sensors.error());
  s.sensors = *sensors;
  if (!o.effects.empty()) {
    auto effects = find_config("effects", o.effects);
    if (!effects) return Failure(effects.error());
    s.effects = *effects;
    if (auto model = physics::load_model(s.effects); !model) return Failure(model.error());
  }
  if (auto v = vehicle::load_vehicle(o.vehicle.empty() ? s.mission_vehicle : o.vehicle, o.set); !v)
    return Failure(v.error());
  auto configs = files::config_dir();
  if (!configs) return Failure(configs.error());
  s.defaults = (*configs / "components" / "default.yaml").string();
  s.loopback = (*configs / "cyclonedds_loopback.xml").string();
  s.duration = kHold + kSettle + s.plan.trajectory.duration() + kAfter;
  s.epoch_ns = bus::wall_clock_ns();
  if (auto ok = make_folder((s.out / "log").string()); !ok) return Failure(ok.error());
  if (auto ok = make_folder((s.out / "plan").string()); !ok) return Failure(ok.error());
  if (auto ok = planning::write_plan(s.plan, s.out / "plan"); !ok) return Failure(ok.error());
  std::error_code ec;
  fs::remove(s.out / "flight.json", ec);  // of an earlier flight into the same folder
  return s;
}

/// Starts what the flight needs, the clock master last.
Result<std::vector<Child>> start(const FlightOptions& o, const Setup& s, int domain) {
  std::vector<std::vector<std::string>> groups;
  std::vector<std::string> names{"recorder", "planner", "allocator", "controller"};
  if (o.plant == "simulator") names.push_back("simulator");
  if (o.plant == "emulator") names.push_back("emulator");
  if (o.plant != "simulator") names.push_back("gateway");
  if (o.in_process)
    groups.push_back(names);
  else
    for (const auto& n : names) groups.push_back({n});
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
    if (!o.realtime && o.plant == "simulator" && !o.in_process && processors > 1)
      child.cpu = group.front() == "recorder" ? static_cast<int>(processors) - 1
                                              : static_cast<int>(domain % (processors - 1));
    auto started = Child::start(*program, arguments, child);
    if (!started) return Failure(started.error());
    children.push_back(std::move(*started));
  }
  return children;
}

}  // namespace

Result<std::string> find_config(const std::string& kind, const std::string& name) {
  std::error_code ec;
  if (fs::is_regular_file(name, ec)) return fs::absolute(name).string();
  auto configs = files::config_dir();
  if (!configs) return Failure(configs.error());
  const fs::path path = *configs / kind / (name + ".yaml");
  if (fs::is_regular_file(path, ec)) return path.string();
  std::vector<std::string> known;
  for (const auto& e : fs::directory_iterator(*configs / kind, ec)) known.push_back(e.path().stem().string());
  const std::string near = files::nearest_word(name, known);
  return bad_input("there is neither such a file nor such a name under configs/" + kind, name,
                   near.empty() ? "" : "Did you mean '" + near + "'?");
}

Result<FlightResult> fly(const FlightOptions& o) {
  auto setup = prepare(o);
  if (!setup) return Failure(setup.error());
  const Setup& s = *setup;
  if (auto ok = files::write_file_atomic(s.out / "params.yaml", parameters(o, s)); !ok)
    return Failure(ok.error());
  auto domain = bus::claim_free_domain();
  if (!domain) return Failure(domain.error());

  const auto begin = std::chrono::steady_clock::now();
  const auto wall = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  auto started = start(o, s, domain->domain());
  if (!started) return Failure(started.error());
  std::vector<Child>& children = *started;
  const double limit = (o.realtime || o.plant != "simulator" ? s.duration + 60.0 : 5.0 * s.duration + 60.0);
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
  auto vehicle = vehicle::load_vehicle(o.vehicle.empty() ? s.mission_vehicle : o.vehicle, o.set);
  if (!vehicle) return Failure(vehicle.error());
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
       {"recording", "flight.mcap"},
       {"simulated_s", recording->duration_s},
       {"wall_s", flight_wall},
       {"synthetic", o.plant != "hardware"}};
  j["recording_notes"] = nlohmann::json::array();
  for (const auto& note : recording->notes) j["recording_notes"].push_back(note.text);
  if (auto metrics = assess(*recording, *vehicle)) {
    result.metrics = *metrics;
    j["metrics"] = to_json(*metrics);
    const Tracking& tracking = metrics->has_truth ? metrics->truth : metrics->measured;
    if (result.reason.empty() && !(tracking.position_rmse.norm() < 0.5))
      result.reason =
          fmt::format("the vehicle left its reference (RMSE {:.2f} m)", tracking.position_rmse.norm());
  } else if (result.reason.empty()) {
    result.reason = metrics.error().text();
  }
  result.flown = result.reason.empty();
  j["verdict"] = result.flown ? "flown" : "not flown to the end";
  j["reason"] = result.reason;
  if (auto ok = files::write_file_atomic(s.out / "flight.json", j.dump(2) + "\n"); !ok)
    return result.flown ? Result<FlightResult>(Failure(ok.error()))
                        : fail(ErrorCode::incomplete, result.reason, "flight", ok.error().text());
  return result;
}

}  // namespace omniflight::cli
