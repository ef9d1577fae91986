// Ratios that a loaded machine does not spoil: the contenders take turns on one pinned processor, thread CPU
// time counts, and the ratio is the median over the turns of (their time / our time in the same turn).
#pragma once

#include <sched.h>
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace omniflight::benchmarks {

/// Something that can be run for a number of steps.
struct Contender {
  std::string name;
  std::function<void(int)> run;  ///< runs this many steps
  double work = 1;               ///< vehicle-steps a step
  std::string absent;            ///< why it cannot be run; empty when it can
};

inline double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Keeps this process on the processor it is on now; where that is not allowed the figures are only noisier.
inline void pin_to_one_processor() {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(std::max(0, sched_getcpu())), &set);
  (void)sched_setaffinity(0, sizeof(set), &set);
}

inline double median(std::vector<double> v) {
  if (v.empty()) return 0;
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

/// Times [ns a vehicle-step] of all contenders, one column each; every row is one turn.
inline std::vector<std::vector<double>> take_turns(std::vector<Contender*> contenders, int turns = 25,
                                                   double seconds_a_turn = 0.01) {
  std::vector<int> steps;
  for (Contender* c : contenders) {
    int n = 16;
    for (;;) {  // find a number of steps that fills the turn; this also warms up
      const double start = thread_seconds();
      c->run(n);
      const double took = thread_seconds() - start;
      if (took > 0.5 * seconds_a_turn || n > (1 << 24)) {
        steps.push_back(std::max(1, static_cast<int>(n * seconds_a_turn / std::max(took, 1e-9))));
        break;
      }
      n *= 2;
    }
  }
  std::vector<std::vector<double>> rows;
  for (int turn = 0; turn < turns; ++turn) {
    std::vector<double> row;
    for (std::size_t k = 0; k < contenders.size(); ++k) {
      const double start = thread_seconds();
      contenders[k]->run(steps[k]);
      row.push_back(1e9 * (thread_seconds() - start) / (steps[k] * contenders[k]->work));
    }
    rows.push_back(row);
  }
  return rows;
}

/// One line of the table that launch_scripts/benchmark.sh prints, as JSON on stdout. must and stretch are
/// ratios; 0 when there is no such goal.
inline void report(const std::string& id, const std::string& what, const std::string& ours, double ours_ns,
                   const std::string& peer, double peer_ns, double ratio, double must, double stretch) {
  std::printf(
      R"({"id":"%s","what":"%s","ours":"%s","ours_value":%.4g,"peer":"%s","peer_value":%.4g,"unit":"ns","ratio":%.4g,"must":%g,"stretch":%g})"
      "\n",
      id.c_str(), what.c_str(), ours.c_str(), ours_ns, peer.c_str(), peer_ns, ratio, must, stretch);
  std::fflush(stdout);
}

/// A goal that could not be measured, with the reason.
inline void report_skip(const std::string& id, const std::string& what, const std::string& peer,
                        const std::string& why) {
  std::printf(R"({"id":"%s","what":"%s","peer":"%s","skipped":"%s"})"
              "\n",
              id.c_str(), what.c_str(), peer.c_str(), why.c_str());
  std::fflush(stdout);
}

/// Runs ours beside the peers that are there and reports one line a peer.
inline void compare(const std::string& id, const std::string& what, Contender ours,
                    std::vector<Contender> peers, double must, double stretch, int turns = 25) {
  std::vector<Contender*> present{&ours};
  if (!ours.absent.empty()) return report_skip(id, what, ours.name, ours.absent);
  for (Contender& p : peers) {
    if (p.absent.empty())
      present.push_back(&p);
    else
      report_skip(id, what, p.name, p.absent);
  }
  const auto rows = take_turns(present, turns);
  for (std::size_t k = 1; k < present.size(); ++k) {
    std::vector<double> mine, theirs, ratio;
    for (const auto& row : rows) {
      mine.push_back(row[0]);
      theirs.push_back(row[k]);
      ratio.push_back(row[k] / row[0]);
    }
    report(id, what, ours.name, median(mine), present[k]->name, median(theirs), median(ratio), must, stretch);
  }
}

}  // namespace omniflight::benchmarks
