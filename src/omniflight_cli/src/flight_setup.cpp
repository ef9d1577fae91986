#include "flight_setup.hpp"

#include <fmt/format.h>

#include <chrono>

#include "bus_access.hpp"
#include "control_choice.hpp"
#include "mission_loads.hpp"
#include "omniflight_allocation/rotor_load.hpp"
#include "omniflight_bus/security.hpp"
#include "omniflight_components/natnet_config.hpp"
#include "omniflight_components/tilt_schedule_file.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_diagnosis/neighbour_file.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_simulation/faults.hpp"
#include "parameter_check.hpp"
#include "tilt_look_ahead.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

/// Parameters of the allocator: a name, or a file of numbers on top of a name.
Result<std::map<std::string, std::string>> read_weights(const std::string& weights) {
  std::map<std::string, std::string> out{{"weights", weights}};
  if (weights == "case_a" || weights == "case_b" || weights == "dynamic") return out;
  std::error_code ec;
  if (!fs::is_regular_file(weights, ec))
    return bad_input("'" + weights + "' is neither case_a, case_b, dynamic nor a file", "--weights",
                     "A file has schema: omniflight.weights/1, base: case_b and for instance w_input: 1e-6");
  auto yaml = files::YamlReader::load(weights);
  if (!yaml) return Failure(yaml.error());
  if (yaml->string("schema") != "omniflight.weights/1")
    yaml->error_at("schema", "is not omniflight.weights/1");
  out["weights"] =
      yaml->choice<std::string>("base", {{"case_a", "case_a"}, {"case_b", "case_b"}, {"dynamic", "dynamic"}});
  for (const char* key : {"w_input", "w_rate", "w_linear", "w_angular", "dynamic_threshold_m",
                          "dynamic_growth", "dynamic_shrink", "dynamic_floor", "dynamic_ceiling"})
    if (yaml->has(key)) out[key] = fmt::format("{:.17g}", yaml->number(key, files::non_negative()));
  if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  return out;
}

/// Everything a flight is made of, as one hash: the content of its files, not their names.
Result<std::string> fingerprint_of(const FlightOptions& o, const std::string& mission_sha256, const Setup& s,
                                   const std::string& vehicle_sha256) {
  nlohmann::json j{{"mission", mission_sha256}, {"vehicle", vehicle_sha256},
                   {"plant", o.plant},          {"seed", o.seed},
                   {"realtime", o.realtime},    {"weights", s.weights},
                   {"tilt", o.tilt_mode},       {"parameters", o.parameters}};
  if (o.tilt_mode == "lookahead") j["tilt_reserve"] = o.tilt_reserve;
  if (o.stay_s > 0) j["stay_s"] = o.stay_s;
  if (!o.controller.empty()) j["controller"] = o.controller;
  std::vector<std::string> inputs{s.sensors, s.effects, s.faults, s.world, s.natnet, s.defaults};
  inputs.insert(inputs.end(), s.neighbours.begin(), s.neighbours.end());
  for (const std::string& file : inputs) {
    if (file.empty()) continue;
    auto sha = files::sha256_file(file);
    if (!sha) return sha;
    j["files"].push_back(*sha);
  }
  return files::sha256_hex(j.dump());
}

/// The world of the mujoco plant, and that nothing of the other plants is asked of it.
Status find_world(const FlightOptions& o, std::string& file) {
  if (o.plant != "mujoco") {
    if (o.world.empty()) return {};
    return bad_input("is a world of the mujoco plant, not of the " + o.plant, "--proof",
                     "Give --plant mujoco");
  }
  if (!o.effects.empty())
    return bad_input("is a model file of the simulator; the mujoco plant has a world of its own", "--effects",
                     "Give --proof WORLD");
  if (!find_program("omniflight_mujoco_plant"))
    return bad_input("was built without MuJoCo", "--plant mujoco",
                     "Install libmujoco-dev (Debian) and build omniflight_proof again");
  if (o.world.empty()) return {};
  auto world = find_config("proof_worlds", o.world);
  if (!world) return Failure(world.error());
  file = *world;
  return {};
}

/// The schedule of faults, which only the simulator can carry out.
Status find_faults(const FlightOptions& o, int rotor_count, std::string& file) {
  if (o.faults.empty()) return {};
  if (o.plant != "simulator")
    return bad_input("breaks things in the simulator, not in the " + o.plant + " plant", "--faults",
                     "Give --plant simulator");
  auto found = find_config("faults", o.faults);
  if (!found) return Failure(found.error());
  file = *found;
  if (auto faults = simulation::load_faults(file, rotor_count); !faults) return Failure(faults.error());
  return {};
}

/// Where the motion capture is, for plants that fly in real time among boards.
Status find_natnet(const FlightOptions& o, std::string& file) {
  if (o.natnet.empty()) return {};
  if (o.lockstep())
    return bad_input("is for boards; the " + o.plant + " plant publishes poses itself", "--natnet",
                     "Give --plant emulator or hardware");
  auto found = find_config("natnet", o.natnet);
  if (!found) return Failure(found.error());
  file = *found;
  if (auto config = components::load_natnet(file); !config) return Failure(config.error());
  return {};
}

/// The tracks of other vehicles, which only the simulator knows.
Status find_neighbours(const FlightOptions& o, std::vector<std::string>& files) {
  if (!o.neighbours.empty() && o.plant != "simulator")
    return bad_input("flies beside the simulator, not beside the " + o.plant + " plant", "--neighbour",
                     "Give --plant simulator");
  if (o.neighbours.size() > static_cast<std::size_t>(physics::kMaxNeighbours))
    return bad_input("is given " + std::to_string(o.neighbours.size()) + " times; at most " +
                         std::to_string(physics::kMaxNeighbours) + " count",
                     "--neighbour");
  for (const std::string& name : o.neighbours) {
    if (name.find(';') != std::string::npos)
      return bad_input("has a ';' in its name", name, "Rename the file");
    auto track = diagnosis::load_neighbour(name, {}, 0.0);
    if (!track) return Failure(track.error());
    files.push_back(fs::absolute(name).string());
  }
  return {};
}

/// The box that the test bed's description says is known, which a vehicle leaves only to be brought down, and
/// its floor.
Status find_fence(const planning::Mission& mission, std::optional<std::pair<Vec3, Vec3>>& fence,
                  double& ground_z) {
  if (mission.description.empty()) return {};
  auto bed = files::YamlReader::load(mission.description);
  if (!bed) return Failure(bed.error());
  ground_z = bed->number("ground_z", files::any_number("m"), 0.0);
  auto bounds = bed->optional_child("bounds");
  if (!bounds) return {};
  fence.emplace(bounds->vec3("min", files::any_number("m")), bounds->vec3("max", files::any_number("m")));
  return bed->status();
}

/// The tilt that `-p allocator.alpha_deg` puts in place of the plan's must still carry the vehicle at its
/// start.
Status check_hover(const FlightOptions& o, const Reference& start, const vehicle::Vehicle& vehicle) {
  const auto own = o.parameters.find("allocator.alpha_deg");
  if (own == o.parameters.end() || o.tilt_mode == "search") return {};
  auto yaml = files::YamlReader::parse("alpha_deg: " + own->second, "-p allocator.alpha_deg");
  if (!yaml) return Failure(yaml.error());
  const double alpha = to_radians(yaml->number("alpha_deg", files::between(-180, 180, "deg")));
  if (auto ok = yaml->finish(); !ok) return ok;
  const auto rotors = allocation::RotorLoad::create(vehicle, alpha);
  if (!rotors) return Failure(rotors.error());
  if (const double load = rotors->hover_load(start.q_WB); !(load <= 1.0))
    return bad_input(
        fmt::format("cannot hover at the start: {:.0f} % of the rotors' range of '{}' ({:.4g} kg) are "
                    "needed at a tilt of {:.1f} deg",
                    100.0 * load, vehicle.name, vehicle.mass, to_degrees(alpha)),
        "-p allocator.alpha_deg", "Give another tilt");
  return {};
}

/// Puts the mission's payload and tether into the model that the plant flies, beside the effects of its file.
Status add_loads(const FlightOptions& o, Setup& s) {
  if (o.plant != "simulator" && o.plant != "emulator") return {};
  auto loads = effects_of_loads(s.mission, s.vehicle, s.plan.trajectory.knots());
  if (!loads) return Failure(loads.error());
  if (loads->empty()) return {};
  physics::Model model;
  if (!s.effects.empty()) {
    auto given = physics::load_model(s.effects);
    if (!given) return Failure(given.error());
    model = std::move(*given);
  }
  model.effects.insert(model.effects.end(), loads->begin(), loads->end());
  s.loaded_model = physics::model_yaml(
      model.effects, "What this flight's plant has: given effects, and the mission's loads.");
  s.effects = (s.out / kLoadedModel).string();
  return {};
}

/// That every program of the flight, and the operator, has keys that can be used.
Status check_keys(const FlightOptions& o) {
  if (o.keys.empty()) return {};
  std::vector<std::string> roles = components_of(o);
  roles.insert(roles.end(), {"container", kOperator});
  for (const std::string& role : roles)
    if (auto ok = bus::check_keys(o.keys, role); !ok) return ok;
  return {};
}

/// Checks and finds everything but the plan. Writes nothing.
Result<Setup> find_inputs(const FlightOptions& o) {
  Setup s;
  s.out = fs::absolute(o.out);
  if (s.out.string().find(';') != std::string::npos)
    return bad_input("has a ';' in its name", "--out " + o.out, "Choose another --out");
  if (auto ok = check_parameters(o.parameters, components_of(o)); !ok) return Failure(ok.error());
  auto loaded = planning::load_mission(o.mission);
  if (!loaded) return Failure(loaded.error());
  s.mission = std::move(*loaded);
  if (auto ok = find_fence(s.mission, s.fence, s.ground_z); !ok) return Failure(ok.error());
  auto sensors = find_config("sensors", o.sensors);
  if (!sensors) return Failure(sensors.error());
  s.sensors = *sensors;
  if (o.plant != "hardware") {
    auto yaml = files::YamlReader::load(s.sensors);
    if (!yaml) return Failure(yaml.error());
    s.sensing = simulation::read_sensor_config(*yaml);
  }
  if (!o.effects.empty()) {
    auto effects = find_config("effects", o.effects);
    if (!effects) return Failure(effects.error());
    s.effects = *effects;
    if (auto model = physics::load_model(s.effects); !model) return Failure(model.error());
  }
  if (auto ok = find_neighbours(o, s.neighbours); !ok) return Failure(ok.error());
  if (auto ok = find_natnet(o, s.natnet); !ok) return Failure(ok.error());
  if (auto ok = find_world(o, s.world); !ok) return Failure(ok.error());
  auto weights = read_weights(o.weights);
  if (!weights) return Failure(weights.error());
  s.weights = std::move(*weights);
  if (auto ok = check_keys(o); !ok) return Failure(ok.error());
  auto vehicle = vehicle::load_vehicle(o.vehicle.empty() ? s.mission.vehicle : o.vehicle, o.set);
  if (!vehicle) return Failure(vehicle.error());
  if (auto ok = find_faults(o, vehicle->rotor_count(), s.faults); !ok) return Failure(ok.error());
  auto configs = files::config_dir();
  if (!configs) return Failure(configs.error());
  s.defaults = (*configs / "components" / "default.yaml").string();
  s.loopback = (*configs / "cyclonedds_loopback.xml").string();
  auto print = fingerprint_of(o, s.mission.sha256, s, vehicle->sha256);
  if (!print) return Failure(print.error());
  s.fingerprint = *print;
  s.vehicle = std::move(*vehicle);
  return s;
}

}  // namespace

std::string plant_component(const FlightOptions& o) {
  return o.plant == "mujoco" ? "mujoco_plant" : "simulator";
}

std::vector<std::string> components_of(const FlightOptions& o) {
  std::vector<std::string> names{"recorder", "planner", "allocator", "controller"};
  if (o.monitor) names.insert(names.begin() + 1, "monitor");
  if (o.plant == "emulator") names.push_back("emulator");
  if (!o.natnet.empty()) names.push_back("natnet");
  if (!o.natnet.empty() && o.plant == "emulator") names.push_back("natnet_emulator");
  names.push_back(o.lockstep() ? plant_component(o) : "gateway");
  return names;
}

Result<std::string> fingerprint(const FlightOptions& options) {
  auto s = find_inputs(options);
  if (!s) return Failure(s.error());
  return s->fingerprint;
}

Result<Setup> plan_flight(const FlightOptions& o) {
  // everything that can be wrong with the input is looked at before the first file is written
  auto found = find_inputs(o);
  if (!found) return found;
  if (auto ok = refuse_overwriting(found->out / kRecording, o.force); !ok) return Failure(ok.error());
  Setup s = std::move(*found);
  planning::PlanOptions for_this_vehicle;
  for_this_vehicle.vehicle = o.vehicle;
  for_this_vehicle.set = o.set;
  for_this_vehicle.stop = interrupted;
  auto plan =
      o.plan.empty() ? planning::plan_mission(s.mission, for_this_vehicle) : planning::read_plan(o.plan);
  if (!plan) return Failure(plan.error());
  if (!o.plan.empty())
    if (auto ok = planning::check_match(plan->certificate, s.mission, s.vehicle); !ok)
      return Failure(ok.error());
  if (auto ok = check_hover(o, plan->trajectory.knots().front().reference, s.vehicle); !ok)
    return Failure(ok.error());
  s.plan = std::move(*plan);
  if (auto ok = check_law(o, s); !ok) return Failure(ok.error());
  if (auto ok = check_weights(o, s); !ok) return Failure(ok.error());
  if (auto ok = find_schedule(o, s); !ok) return Failure(ok.error());
  if (auto ok = add_loads(o, s); !ok) return Failure(ok.error());
  if (!o.lockstep() && s.plan.certificate.alpha_highest > s.plan.certificate.alpha_lowest)
    return bad_input("moves the tilt of the rotors, which the boards of the " + o.plant + " plant cannot",
                     s.mission.file + ": alpha_deg", "Give --plant simulator or mujoco, or one tilt");
  s.duration = kHold + kSettle + s.plan.trajectory.duration() + kAfter + o.stay_s;
  s.after = kAfter + o.stay_s;
  s.epoch_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                   std::chrono::steady_clock::now().time_since_epoch())
                   .count();
  return s;
}

Status write_inputs(const Setup& s) {
  if (s.schedule)
    if (auto ok =
            files::write_file_atomic(s.out / kTiltSchedule, components::tilt_schedule_text(*s.schedule));
        !ok)
      return ok;
  if (!s.loaded_model.empty()) return files::write_file_atomic(s.effects, s.loaded_model);
  return {};
}

Result<Setup> prepare(const FlightOptions& o) {
  auto planned = plan_flight(o);
  if (!planned) return planned;
  Setup s = std::move(*planned);
  auto lock = FolderLock::take(s.out);
  if (!lock) return Failure(lock.error());
  s.lock = std::move(*lock);
  if (auto ok = refuse_overwriting(s.out / kRecording, o.force); !ok) return Failure(ok.error());
  if (auto ok = make_folder((s.out / "log").string()); !ok) return Failure(ok.error());
  if (auto ok = make_folder((s.out / "plan").string()); !ok) return Failure(ok.error());
  if (auto ok = planning::write_plan(s.plan, s.out / "plan"); !ok) return Failure(ok.error());
  std::error_code ec;
  for (const char* of_an_earlier_flight :
       {"flight.json", "monitor.json", kPeriods, kTiltSchedule, kLoadedModel})
    fs::remove(s.out / of_an_earlier_flight, ec);
  fs::remove_all(s.out / kReplans, ec);
  if (auto ok = write_inputs(s); !ok) return Failure(ok.error());
  return s;
}

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

}  // namespace omniflight::cli
