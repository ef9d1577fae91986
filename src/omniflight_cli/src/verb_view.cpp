// `view`: a page on the loopback interface, live from a run or as the replay of a recording.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <thread>

#include "bus_access.hpp"
#include "foxglove_relay.hpp"
#include "live_flight.hpp"
#include "omniflight_bus/domain.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/mission.hpp"
#include "omniflight_recording/formats.hpp"
#include "omniflight_view/view_page.hpp"
#include "operator_desk.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kFrame = 40ms;  // between two looks at the bus
constexpr auto kLookForRuns = 500ms;
constexpr auto kWishHolds = 5s;  // long enough for everybody to be found and to answer

struct ViewOptions {
  std::string recording, vehicle, mission, test_bed, map, keys;
  std::vector<std::string> set, origins;
  int port = 8642, domain = -1;
  double for_s = 0;
};

/// The solids of the test bed that is named, or of the mission's; none where neither is known.
Result<std::vector<planning::Primitive>> solids_of(const ViewOptions& o, const std::string& mission,
                                                   bool must) {
  std::filesystem::path description = o.test_bed;
  if (!o.test_bed.empty() && o.test_bed.find('/') == std::string::npos &&
      description.extension() != ".yaml") {
    const auto configs = files::config_dir();
    if (!configs) return Failure(configs.error());
    description = *configs / "test_beds" / (o.test_bed + ".yaml");
  } else if (o.test_bed.empty() && !mission.empty()) {
    const auto loaded = planning::load_mission(mission);
    if (!loaded)
      return must ? Result<std::vector<planning::Primitive>>(Failure(loaded.error()))
                  : std::vector<planning::Primitive>();
    description = loaded->description;
  }
  if (description.empty()) return std::vector<planning::Primitive>();
  const auto bed = planning::load_test_bed(description);
  if (!bed) return Failure(bed.error());
  return bed->primitives;
}

/// What the operator's stop on the page leads to: said by the loop below, within one frame.
struct StopButton {
  std::atomic<bool> pressed{false}, connected{false};
};

void announce(const Common& common, const view::WebServer& server, bool live) {
  const std::string url = fmt::format("http://127.0.0.1:{}/", server.port());
  say(common, "showing at " + url + (live ? " (Ctrl-C ends the view, not the flight)" : " (Ctrl-C ends it)"));
  print_json(common, {{"url", url}, {"port", server.port()}, {"live", live}});
  std::cout.flush();
}

bool over(const ViewOptions& o, Clock::time_point begin) {
  return interrupted() ||
         (o.for_s > 0 && std::chrono::duration<double>(Clock::now() - begin).count() > o.for_s);
}

Result<int> replay(const ViewOptions& o, const Common& common) {
  recording::LoadOptions how;
  how.map = o.map;
  const auto r = recording::load(o.recording, how);
  if (!r) return Failure(r.error());
  const auto fact = [&](const char* key) {
    const auto found = r->metadata.find(key);
    return found == r->metadata.end() ? std::string() : found->second;
  };
  const std::string name = o.vehicle.empty() ? fact("omniflight.vehicle") : o.vehicle;
  if (name.empty())
    return bad_input("the recording does not say which vehicle flew", o.recording,
                     "Name it with --vehicle; `omniflight vehicles` lists those known");
  const auto vehicle = vehicle::load_vehicle(name, o.set);
  if (!vehicle) return Failure(vehicle.error());
  const std::string mission = o.mission.empty() ? fact("omniflight.mission") : o.mission;
  auto solids = solids_of(o, mission, !o.mission.empty());
  if (!solids) return Failure(solids.error());
  auto frames = view::replay_json(*r, *vehicle);
  if (!frames) return Failure(frames.error());
  view::Scene scene;
  scene.title = std::filesystem::path(o.recording).filename().string();
  scene.subtitle =
      fmt::format("{}, {:.1f} s{}", vehicle->name, r->duration_s, mission.empty() ? "" : ", " + mission);
  scene.vehicle = *vehicle;
  scene.solids = std::move(*solids);
  const auto page = std::make_shared<view::ViewPage>(scene, std::move(*frames), nullptr);
  auto server =
      view::WebServer::start({.port = o.port}, [page](std::string_view p) { return page->get(p); }, {page});
  if (!server) return Failure(server.error());
  announce(common, **server, false);
  for (const auto begin = Clock::now(); !over(o, begin);) std::this_thread::sleep_for(kFrame);
  return 0;
}

/// The run to look at: the one named, else the first that holds a domain.
std::optional<int> find_run(const ViewOptions& o) {
  if (o.domain >= 0) return o.domain;
  const auto runs = domains_in_use();
  return runs.empty() ? std::nullopt : std::optional(runs.front());
}

/// What a live view consists of.
struct Shown {
  vehicle::Vehicle vehicle;
  std::shared_ptr<view::ViewPage> page;
  std::shared_ptr<view::FoxgloveEndpoint> foxglove;
  std::unique_ptr<view::WebServer> server;
  StopButton button;
  std::string keys;            ///< that this program joins with
  bool other_vehicle = false;  ///< it was said that another one flies
};

/// News of the run to the page and to Foxglove.
void pass_on(LiveFlight& flight, Shown& shown, const Common& common) {
  if (const auto path = flight.new_path()) {
    shown.page->show_path(*shown.server, *path);
    show_plan(*shown.foxglove, *shown.server, *path);
  }
  if (const auto frame = flight.news()) {
    const std::size_t rotors = frame->rotor_speed.size(), own = shown.vehicle.rotors.size();
    if (rotors > 0 && rotors != own && !std::exchange(shown.other_vehicle, true))
      say(common,
          fmt::format("  the run has {} rotors and {} has {}: name the vehicle that flies with --vehicle",
                      rotors, shown.vehicle.name, own));
    shown.page->show(*shown.server, view::frame_json(*frame, shown.vehicle));
    show_frame(*shown.foxglove, *shown.server, shown.vehicle, *frame);
  }
}

/// Shows one run until it has ended.
Status show_run(const ViewOptions& o, int domain, const Common& common, Shown& shown,
                Clock::time_point begin) {
  auto flight = LiveFlight::join(domain);
  if (!flight) return Failure(flight.error());
  auto desk = OperatorDesk::join(domain);
  if (!desk) return Failure(desk.error());
  say(common, fmt::format("  looking at domain {}{}", domain, unheard(domain, shown.keys)));
  shown.button.connected = true;
  std::unique_ptr<FoxgloveRelay> relay;  // the run is asked for everything only while somebody looks
  auto next_look = Clock::now() + kLookForRuns;
  auto rejoin_at = Clock::time_point::max();
  while (!over(o, begin)) {
    std::this_thread::sleep_for(kFrame);
    if (shown.button.pressed.exchange(false)) {
      if (auto ok = (*desk)->say("cut"); !ok) return ok;
      rejoin_at = Clock::now() + kWishHolds;
      say(common, fmt::format("  domain {}: rotors to be stopped, said from the page", domain));
    }
    if (Clock::now() > rejoin_at) {  // a wish is latched: the next flight here shall not hear it
      rejoin_at = Clock::time_point::max();
      desk = OperatorDesk::join(domain);
      if (!desk) return Failure(desk.error());
    }
    pass_on(**flight, shown, common);
    const bool watched = shown.server->clients(shown.foxglove->protocol()) > 0;
    if (watched && !relay) {
      auto made = FoxgloveRelay::join(domain, *shown.server, *shown.foxglove);
      if (!made) return Failure(made.error());
      relay = std::move(*made);
    } else if (!watched) {
      relay.reset();
    }
    if (o.domain < 0 && Clock::now() > next_look) {
      next_look = Clock::now() + kLookForRuns;
      const auto runs = domains_in_use();
      if (std::find(runs.begin(), runs.end(), domain) == runs.end()) break;
    }
  }
  shown.button.connected = false;
  return {};
}

Result<int> live(const ViewOptions& o, const Common& common) {
  std::string name = o.vehicle;
  if (name.empty() && !o.mission.empty()) {
    const auto mission = planning::load_mission(o.mission);
    if (!mission) return Failure(mission.error());
    name = mission->vehicle;
  }
  const auto vehicle = vehicle::load_vehicle(name.empty() ? "omnimorph" : name, o.set);
  if (!vehicle) return Failure(vehicle.error());
  auto solids = solids_of(o, o.mission, true);
  if (!solids) return Failure(solids.error());
  // the keys are chosen before threads start: those of the run that flies now, where none are named
  std::string keys = o.keys;
  if (auto ok = use_bus_of(find_run(o).value_or(o.domain), keys); !ok) return Failure(ok.error());
  view::Scene scene;
  scene.title = "Live";
  scene.subtitle = vehicle->name + (o.domain >= 0 ? fmt::format(", domain {}", o.domain) : "");
  scene.live = scene.may_stop = true;
  scene.vehicle = *vehicle;
  scene.solids = std::move(*solids);
  Shown shown;
  shown.keys = keys;
  shown.vehicle = *vehicle;
  shown.page = std::make_shared<view::ViewPage>(scene, "", [&shown]() -> std::string {
    if (!shown.button.connected) return "no run is connected: NOTHING was stopped";
    shown.button.pressed = true;
    return "said, waiting for the gate";
  });
  shown.foxglove = foxglove_endpoint();
  auto server = view::WebServer::start({.port = o.port, .allowed_origins = o.origins},
                                       [page = shown.page](std::string_view p) { return page->get(p); },
                                       {shown.page, shown.foxglove});
  if (!server) return Failure(server.error());
  shown.server = std::move(*server);
  show_world(*shown.foxglove, *shown.server, scene.solids);
  announce(common, *shown.server, true);
  const auto begin = Clock::now();
  while (!over(o, begin)) {
    if (const auto domain = find_run(o)) {
      if (auto ok = show_run(o, *domain, common, shown, begin); !ok) return Failure(ok.error());
    } else {
      std::this_thread::sleep_for(kLookForRuns);
    }
  }
  return 0;
}

}  // namespace

Action add_view(CLI::App& verb, Common& common) {
  auto o = std::make_shared<ViewOptions>();
  verb.add_option("recording", o->recording,
                  "Recording to replay; without one, the run that flies now is shown");
  verb.add_option("--vehicle", o->vehicle,
                  "Vehicle that flies (default: as recorded; live: of the mission, else omnimorph)");
  verb.add_option("--set", o->set, "Override a vehicle field");
  verb.add_option("--mission", o->mission, "Mission whose test bed is shown (default: as recorded)");
  verb.add_option("--test-bed", o->test_bed, "Test bed to show instead, a name or a YAML");
  verb.add_option("--domain", o->domain,
                  "Domain of the run (default: the first run of this machine, and the next)")
      ->check(CLI::Range(0, 231));
  add_secure(verb, o->keys);
  verb.add_option("--port", o->port, "Port on 127.0.0.1; 0 takes any")->check(CLI::Range(0, 65535));
  verb.add_option("--allow-origin", o->origins,
                  "Page of another server that may look over Foxglove's protocol (https://app.foxglove.dev)");
  verb.add_option("--for-s", o->for_s, "End after so long [s] (default: at Ctrl-C)")->check(not_negative());
  add_map(verb, o->map);
  return [o, &common] { return o->recording.empty() ? live(*o, common) : replay(*o, common); };
}

}  // namespace omniflight::cli
