// The plan that was flown: the one that the flight began with, and what missions in flight made of it.
#pragma once

#include <string>
#include <vector>

#include "flight_setup.hpp"

namespace omniflight::cli {

struct FlownPlan {
  planning::Plan plan;        ///< one trajectory in the time of the first plan; certificate of the last one
  planning::Mission mission;  ///< the last one, whose bounds and map the flight is judged by
  double after = 0;           ///< s that the flight went on after the plan's end
  std::vector<std::string> remarks;  ///< a line for each mission that was joined in flight
};

/// Reads the plans that the planner left under kReplans, in their order; without any it is the plan of the
/// setup.
Result<FlownPlan> flown_plan(const Setup& setup);

}  // namespace omniflight::cli
