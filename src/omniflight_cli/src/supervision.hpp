// Watching the processes of a flight, and ending them so that the rotors wind down first.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "process.hpp"

namespace omniflight::cli {

struct Supervision {
  double limit_s = 0;     ///< wall time the flight may take
  bool lockstep = false;  ///< a simulated plant waits for everybody, so that no loss can be flown through
  std::function<void(double wall_s)> progress;
};

struct Supervised {
  std::string reason;              ///< why the flight is not complete; empty when it is
  bool refused = false;            ///< a component would not start with its parameters
  bool interrupted = false;        ///< by the operator
  bool master_done = false;        ///< the clock master came to the end of the flight by itself
  std::vector<std::string> notes;  ///< losses that the flight went on without
  double wall_s = 0;
};

/// Waits until the clock master, which is the last of the children, has ended, the operator interrupts, or a
/// component without which there is no flight is lost and the master has had time to notice. Through boards a
/// lost recorder or planner ends nothing: the vehicle is in the air.
Supervised supervise(std::vector<Child>& children, const Supervision& how);

/// Ends all children. The clock master goes first and gets the time to wind the rotors down; only then is
/// anybody else asked to end.
void end_in_order(std::vector<Child>& children, const Supervision& how, Supervised& flight);

}  // namespace omniflight::cli
