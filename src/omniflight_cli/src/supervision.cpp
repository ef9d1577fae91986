#include "supervision.hpp"

#include <chrono>
#include <set>
#include <thread>

#include "omniflight_core/progress.hpp"

namespace omniflight::cli {
namespace {

// s of wall time for the rest to notice that a component is gone; none is needed for the recorder or a
// component that never began
constexpr double kGraceOfRest = 4.0, kGraceShort = 0.5;
// s for the clock master to end by itself: the longest ramp of the gate (10 s), and telling everybody
constexpr double kWindDown = 12.0;

bool would_not_start(const std::string& words) { return words.find("] not configured") != std::string::npos; }

/// What a flight through boards goes on without; without poses the controller's failsafe descends.
bool dispensable(const Child& child) {
  static const std::set<std::string> names{"omniflight_recorder", "omniflight_planner", "omniflight_monitor",
                                           "omniflight_natnet", "omniflight_natnet_emulator"};
  return names.contains(child.name());
}

}  // namespace

Supervised supervise(std::vector<Child>& children, const Supervision& how) {
  Supervised flight;
  const auto begin = std::chrono::steady_clock::now();
  const auto wall = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  Child& master = children.back();
  double give_up = how.limit_s;  // sooner once a component is lost
  std::vector<bool> told(children.size(), false);
  while (!master.poll()) {
    if (how.progress) how.progress(wall());
    for (std::size_t k = 0; k + 1 < children.size(); ++k) {
      Child& child = children[k];
      const auto code = child.poll();
      if (!code || told[k]) continue;
      told[k] = true;
      const std::string words = child.last_words();
      const std::string lost =
          child.name() + " ended in flight (exit code " + std::to_string(*code) + "): " + words;
      flight.notes.push_back(lost);
      const bool planned = child.name() == "omniflight_planner" && !how.lockstep && !would_not_start(words);
      if (!planned && flight.reason.empty()) flight.reason = lost;
      flight.refused = flight.refused || would_not_start(words);
      if (!how.lockstep && dispensable(child) && !would_not_start(words)) continue;
      give_up = std::min(give_up, wall() + (flight.refused || k == 0 ? kGraceShort : kGraceOfRest));
    }
    if (interrupted()) {
      flight.interrupted = true;
      flight.reason = "interrupted";
    }
    if (wall() > how.limit_s && flight.reason.empty())
      flight.reason = "took longer than " + std::to_string(how.limit_s) + " s";
    // a component is gone: the clock master notices by its own deadline and ends the flight in order
    if (interrupted() || wall() > give_up) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  flight.master_done = master.poll() == 0;
  if (const auto code = master.poll(); code && *code != 0 && flight.reason.empty())
    flight.reason =
        master.name() + " ended early (exit code " + std::to_string(*code) + "): " + master.last_words();
  flight.refused = flight.refused || would_not_start(flight.reason);
  flight.wall_s = wall();
  return flight;
}

void end_in_order(std::vector<Child>& children, const Supervision& how, Supervised& flight) {
  if (!how.lockstep) children.back().terminate(kWindDown);
  // One that is gone keeps the others waiting for its acknowledgements, so they end side by side.
  if (!flight.reason.empty())
    for (std::size_t k = children.size(); k-- > 1;) children[k].ask_to_end();
  while (!children.empty()) {  // in reverse: the recorder last
    Child& child = children.back();
    const bool was_running = !child.poll();
    const int code = child.terminate(5.0);
    if (code != 0 && was_running && flight.reason.empty())
      flight.reason = child.name() + " did not end in order (exit code " + std::to_string(code) +
                      "): " + child.last_words();
    children.pop_back();
  }
}

}  // namespace omniflight::cli
