// What a flight is made of, checked before anything is written or started.
#pragma once

#include <filesystem>

#include "flight.hpp"
#include "folder.hpp"
#include "omniflight_allocation/look_ahead.hpp"
#include "omniflight_planning/plan.hpp"
#include "omniflight_simulation/sensors.hpp"

namespace omniflight::cli {

inline constexpr const char* kRecording = "flight.mcap";
inline constexpr double kHold = 1.0, kSettle = 3.0, kAfter = 1.0;  ///< s around the trajectory

/// File of the folder in which the gateway leaves the counts of its periods.
inline constexpr const char* kPeriods = "periods.json";
/// Folder of the plans that were made in flight, 1, 2, ...
inline constexpr const char* kReplans = "replans";
/// The tilt that `--tilt lookahead` has found.
inline constexpr const char* kTiltSchedule = "tilt.yaml";
/// The model file of a flight whose mission has a payload or a tether.
inline constexpr const char* kLoadedModel = "effects.yaml";

struct Setup {
  planning::Plan plan;
  planning::Mission mission;
  std::optional<allocation::TiltSchedule> schedule;  ///< instead of the plan's tilt
  vehicle::Vehicle vehicle;                          ///< that flies, overrides included
  std::filesystem::path out;
  FolderLock lock;  ///< of `out`
  std::string sensors, effects, faults, world, natnet, defaults,
      loopback;                         ///< files; without effects, ...: empty
  std::string loaded_model;             ///< text of the file `effects` with the mission's loads; may be empty
  std::vector<std::string> neighbours;  ///< files
  simulation::SensorConfig sensing;     ///< of the plant's sensors, where it is ours
  std::map<std::string, std::string> weights;  ///< parameters of the allocator
  std::string fingerprint;                     ///< see fingerprint()
  std::optional<std::pair<Vec3, Vec3>> fence;  ///< m, corners of the test bed's known box; empty: none known
  double ground_z = 0;                         ///< m, floor of the test bed
  double duration = 0;                         ///< s, whole flight
  double after = 0;                            ///< s of it after the plan's end, `stay` included
  std::int64_t epoch_ns = 0;                   ///< CLOCK_MONOTONIC at flight time zero
};

/// The component that plays the plant where none is emulated or real.
std::string plant_component(const FlightOptions& options);
/// Every component of the flight in the order of their start, the clock master last.
std::vector<std::string> components_of(const FlightOptions& options);
/// Checks everything and plans where there is no plan. Writes nothing, locks nothing.
Result<Setup> plan_flight(const FlightOptions& options);
/// Writes what the folder of the flight holds beside its plan: tilt schedule and loaded model, where it has
/// them.
Status write_inputs(const Setup& setup);
/// plan_flight(), then makes the folders and writes the plan.
Result<Setup> prepare(const FlightOptions& options);
/// The parameters of this flight, on top of configs/components/default.yaml.
std::string parameters(const FlightOptions& options, const Setup& setup);

/// What a diagnosis may be told of this flight (told.yaml): the gains it is flown with and, where the plant
/// is ours, the size of its sensors' biases and the density of its air. Nothing of the effects.
Result<std::string> told(const FlightOptions& options, const Setup& setup);

}  // namespace omniflight::cli
