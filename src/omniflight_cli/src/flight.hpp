// One flight: plan, start the components, wait, record, judge. Used by `fly` and `campaign`.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "metrics.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::cli {

struct FlightOptions {
  std::string mission;
  std::string plan;                     ///< folder of a plan that is there; empty: plan the mission
  std::string plant = "simulator";      ///< simulator | mujoco | emulator | hardware
  std::string devices;                  ///< hardware: "dev;dev;dev"
  std::string vehicle;                  ///< instead of the mission's, for controller and allocator
  std::vector<std::string> set;         ///< overrides of vehicle fields, for plant and control alike
  std::string effects;                  ///< model file the plant flies
  std::string natnet;                   ///< poses over NatNet, by this file; emulated where the plant is
  std::string faults;                   ///< schedule of faults of the simulator
  std::vector<std::string> neighbours;  ///< recordings of other vehicles that fly here, over simulated time
  std::string world;                    ///< mujoco: name under configs/proof_worlds or a path; empty: nominal
  std::string sensors = "ideal";        ///< name under configs/sensors or a path
  std::string weights = "case_a";       ///< case_a | case_b | dynamic | file
  std::string tilt_mode = "fixed";      ///< fixed | search | lookahead
  double tilt_reserve = 0.1;            ///< lookahead: share of the thrust that is kept where it can be
  std::string controller;               ///< control law; empty: by the vehicle's actuation
  std::uint64_t seed = 1;
  std::string keys;  ///< folder of keys that secure the bus; empty: clear text
  int domain = -1;   ///< of the bus; -1: the first free one
  bool realtime = false;
  double stay_s = 0.0;      ///< that the flight goes on after its plan, for missions that come in flight
  bool monitor = false;     ///< watch the residuals in flight, see the monitor component
  bool in_process = false;  ///< all components in one container
  std::map<std::string, std::string> parameters;  ///< "controller.kp" -> YAML text
  std::string out;
  bool force = false;  ///< overwrite a recording that is in `out`
  bool quiet = false;
  bool page = false;  ///< also write report.html

  /// Plants that wait for each command, as fast as they can.
  bool lockstep() const { return plant == "simulator" || plant == "mujoco"; }
};

struct FlightResult {
  nlohmann::json json;    ///< what flight.json holds
  std::string recording;  ///< path
  bool flown = false;     ///< to the end and within its bounds
  bool complete = false;  ///< every component did its part to the plan's end; the vehicle may be lost
  std::string verdict;    ///< see verdict.hpp
  std::string reason;     ///< why it is not flown
  FlightMetrics metrics;
  std::vector<std::string> remarks;  ///< what else the operator is to know, a line each
  std::string monitor;               ///< its verdict in a line; empty when there was none
};

/// Refuses a folder that holds a recording (without `force`) or that another run holds. Writes plan/,
/// params.yaml, log/, flight.mcap, flight.json and, where
/// asked for, report.html into options.out.
Result<FlightResult> fly(const FlightOptions& options);

/// SHA-256 over everything that decides how the flight goes: two flights with one fingerprint are the same
/// flight.
Result<std::string> fingerprint(const FlightOptions& options);

/// "ideal" -> configs/sensors/ideal.yaml; a path stays a path.
Result<std::string> find_config(const std::string& kind, const std::string& name);

}  // namespace omniflight::cli
