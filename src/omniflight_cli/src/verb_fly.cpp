#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <iostream>

#include "bus_access.hpp"
#include "flight.hpp"
#include "folder.hpp"
#include "omniflight_control/law.hpp"
#include "omniflight_physics/effect_ids.hpp"
#include "verbs.hpp"

namespace omniflight::cli {

Action add_fly(CLI::App& verb, Common& common) {
  auto o = std::make_shared<FlightOptions>();
  auto rate = std::make_shared<std::string>();
  auto params = std::make_shared<std::vector<std::string>>();
  verb.add_option("mission", o->mission, "Name under configs/missions or a path")->required();
  verb.add_option(
          "--plant", o->plant,
          "simulator | mujoco (a second world, shares no physics with it) | emulator (boards on pseudo "
          "terminals) | hardware")
      ->check(CLI::IsMember({"simulator", "mujoco", "emulator", "hardware"}));
  verb.add_option(
      "--plan", o->plan,
      "Folder of a plan of this mission for this vehicle; otherwise the mission is planned first");
  verb.add_option("--devices", o->devices, "Hardware: serial devices, separated by ;");
  verb.add_option("--vehicle", o->vehicle, "Instead of the mission's vehicle; planned for, too");
  verb.add_option("--set", o->set, "Override a vehicle field, for instance mass=1.4 (kg)");
  verb.add_option("--effects", o->effects,
                  "Model file of effects the plant flies (the controller does not know)");
  verb.add_option(
      "--proof", o->world,
      "World the mujoco plant flies in: name under configs/proof_worlds or a path; otherwise nominal");
  verb.add_option("--faults", o->faults,
                  "Simulator: what breaks when; name under configs/faults or a path (rotor_loss, bad_day)");
  verb.add_option(
      "--neighbour", o->neighbours,
      std::string("Simulator: track of another multirotor whose wash presses on this one (") +
          physics::effect_id::neighbour_downwash +
          "): a CSV of t_s,px_m,py_m,pz_m over simulated seconds, or any recording; one row: it hovers "
          "there. For instance fly trajectory_1 --neighbour above.csv");
  verb.add_option(
      "--natnet", o->natnet,
      "Poses of OptiTrack over NatNet: name under configs/natnet (optitrack) or a path; with the "
      "emulator plant an emulated server streams them. For instance fly trajectory_1 --plant emulator "
      "--natnet optitrack");
  verb.add_option("--sensors", o->sensors, "Sensor file or name: ideal | laboratory | degraded");
  verb.add_option("--weights", o->weights,
                  "Allocation weights: case_a | case_b | dynamic (eq. 5.3; for gains as stiff as those of "
                  "campaigns/tilt_mismatch.yaml) | FILE");
  verb.add_option(
          "--tilt", o->tilt_mode,
          "fixed (of the plan) | search (from period to period) | lookahead (the cheapest way through the "
          "whole plan, by dynamic programming); for instance fly full_roll --tilt lookahead")
      ->check(CLI::IsMember({"fixed", "search", "lookahead"}));
  verb.add_option("--tilt-reserve", o->tilt_reserve,
                  "lookahead: share of every rotor's thrust that is kept where it can be (0.1)")
      ->check(CLI::Range(0.0, 0.9));
  verb.add_option(
          "--controller", o->controller,
          "Control law: full_pose (attitude free) | thrust_vector (leans into its motion) | cascaded | "
          "incremental; default: by the vehicle's actuation. Parameters: -p controller.NAME=VALUE")
      ->check(CLI::IsMember(control::law_names()));
  add_secure(verb, o->keys);
  verb.add_option("--domain", o->domain, "Domain of the bus; default: the first free one")
      ->check(CLI::Range(0, 231));
  verb.add_option("--seed", o->seed, "Seed of all sensor noise");
  verb.add_option("--rate", *rate, "max (the default: lockstep) | realtime; simulator and mujoco only")
      ->check(CLI::IsMember({"max", "realtime"}));
  verb.add_option("-p,--param", *params, "Component parameter, for instance controller.kp='[10, 10, 10]'");
  verb.add_option("--stay", o->stay_s,
                  "s that the flight goes on after its plan: time for missions that are asked for in flight "
                  "(omniflight replan)")
      ->check(CLI::Range(0.0, 3600.0));
  verb.add_flag("--monitor", o->monitor,
                "Watch the residuals in flight (/diagnostics) and end with the verdict in a line");
  verb.add_flag("--force", o->force, "Overwrite a recording that is in --out");
  verb.add_flag("--in-process", o->in_process, "All components in one process");
  return [o, rate, params, &common]() -> Result<int> {
    if (!rate->empty() && !o->lockstep())
      return bad_input("does nothing with the " + o->plant + " plant, which flies in real time", "--rate",
                       "Leave it out, or give --plant simulator");
    if (!o->devices.empty() && o->plant != "hardware")
      return bad_input("names the serial devices of the hardware plant, not of the " + o->plant, "--devices",
                       "Leave it out, or give --plant hardware");
    o->realtime = *rate == "realtime" || !o->lockstep();
    o->out = common.out.empty()
                 ? fresh_folder(std::filesystem::path(o->mission).stem().string() + "-" + o->plant)
                 : common.out;
    o->quiet = common.quiet;
    o->page = true;
    for (const std::string& p : *params) {
      const auto equals = p.find('=');
      if (equals == std::string::npos || p.find('.') > equals)
        return bad_input("'" + p + "' is not component.parameter=value", "--param");
      o->parameters[p.substr(0, equals)] = p.substr(equals + 1);
    }
    auto result = fly(*o);
    if (!result) return Failure(result.error());
    print_json(common, result->json);
    const FlightMetrics& m = result->metrics;
    const Tracking& t = m.has_truth ? m.truth : m.measured;
    const std::string verdict =
        o->mission + (result->flown ? ": flown" : ": NOT flown: " + result->verdict + ": " + result->reason);
    if (!result->flown && common.quiet)
      std::cerr << verdict << std::endl;  // quiet is no excuse for no reason
    say(common, verdict);
    say(common,
        fmt::format("  RMSE {} x {:.4f} y {:.4f} z {:.4f} m, roll {:.3f} pitch {:.3f} yaw {:.3f} deg",
                    m.has_truth ? "(true state)" : "(measured)", t.position_rmse.x(), t.position_rmse.y(),
                    t.position_rmse.z(), t.attitude_rmse.x(), t.attitude_rmse.y(), t.attitude_rmse.z()));
    say(common, fmt::format("  mean power {:.1f} W mechanical ({:.2f} in the thesis's convention), {:.1f} s "
                            "of flight in {:.1f} s",
                            m.mean_power, m.thesis_power, result->json.value("simulated_s", 0.0),
                            result->json.value("wall_s", 0.0)));
    for (const std::string& remark : result->remarks) say(common, "  " + remark);
    if (!result->monitor.empty()) say(common, "  " + result->monitor);
    say(common, "  recording: " + result->recording);
    say(common, "  report: " + (std::filesystem::path(o->out) / "report.html").string());
    return result->flown ? 0 : static_cast<int>(ErrorCode::incomplete);
  };
}

}  // namespace omniflight::cli
