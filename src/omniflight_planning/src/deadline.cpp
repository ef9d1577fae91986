#include "omniflight_planning/deadline.hpp"

#include <cstdio>

namespace omniflight::planning {

Failure out_of_time(const Deadline& deadline, const std::string& phase) {
  if (deadline.stopped())
    return fail(ErrorCode::incomplete, "the plan was stopped while it was " + phase, "plan");
  char text[200];
  std::snprintf(text, sizeof text, "out_of_time: the plan was not finished within %.0f ms, it was %s",
                1e3 * deadline.limit(), phase.c_str());
  return fail(ErrorCode::incomplete, text, "budget_ms", "Give more budget_ms or less clearance_m");
}

}  // namespace omniflight::planning
