// What the components of a simulated flight are configured with, for a flight that closes the same loop
// without them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "omniflight_allocation/config.hpp"
#include "omniflight_allocation/look_ahead.hpp"
#include "omniflight_control/law.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_simulation/plant.hpp"

namespace omniflight::components {

/// The control law of the controller.
struct LawParameters {
  std::string name = "full_pose";
  control::LawConfig config;
  bool anti_windup = true;  ///< the law is told what the allocator achieved of its last demand
};

/// The allocator.
struct AllocatorParameters {
  double joints_hz = 50.0;  ///< messages of the joints in a second of flight time; 0: none
  vehicle::Vehicle vehicle;
  allocation::AllocatorConfig config;
  std::optional<allocation::TiltSchedule>
      schedule;             ///< of the tilt over the plan's time; instead of the plan's
  bool follow_plan = true;  ///< takes the tilt that the plan tells
  bool drop_lost = true;    ///< leaves out rotors that do not turn
};

/// The loop of a simulated flight: plant, control law and allocation.
struct LoopParameters {
  vehicle::Vehicle vehicle;  ///< that the plant flies
  physics::Model model;      ///< its effects
  simulation::PlantConfig plant;
  double control_period = 0.002;  ///< s
  double hold = 1.0;              ///< s that the body is held at the start
  double settle = 3.0;            ///< s in hover before the plan begins
  double duration = 10.0;         ///< s, whole flight
  LawParameters law;
  AllocatorParameters allocator;
};

/// Reads parameter files of a flight (the later before the earlier) as simulator, controller and allocator
/// would. Errors name file, component and field.
Result<LoopParameters> read_loop_parameters(const std::vector<std::string>& files);

}  // namespace omniflight::components
