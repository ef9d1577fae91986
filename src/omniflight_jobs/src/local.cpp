// Jobs on this machine, some at once.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "executors.hpp"

namespace omniflight::jobs {
namespace {

class Local final : public Executor {
 public:
  explicit Local(int at_once) : at_once_(at_once) {}

  Result<Ran> run(const Work& work) override {
    const auto begin = std::chrono::steady_clock::now();
    Ran out;
    std::atomic<std::size_t> next{0};
    std::size_t done = 0;
    std::mutex mutex;  // of what follows
    const auto some = [&] {
      for (std::size_t k = next++; k < work.jobs.size() && !(work.stop && work.stop()); k = next++) {
        if (work.may_begin && !is_done(work.jobs[k]) && !work.may_begin()) {
          const std::lock_guard lock(mutex);
          out.missing.push_back({k, kNoTime});
          continue;
        }
        const Performed one = perform(work.jobs[k], work.program, work.stop);
        const std::lock_guard lock(mutex);
        out.before += one.ending == Ending::done_before;
        out.made += one.ending == Ending::done;
        out.stopped = out.stopped || one.ending == Ending::stopped;
        if (one.ending == Ending::failed || one.ending == Ending::killed)
          out.missing.push_back({k, one.reason});
        if (work.progress) work.progress(++done);
      }
    };
    const int at_once = std::min(at_once_, static_cast<int>(work.jobs.size()));
    std::vector<std::thread> threads;
    for (int i = 0; i < at_once; ++i) threads.emplace_back(some);
    for (auto& t : threads) t.join();
    out.stopped = out.stopped || (work.stop && work.stop());
    std::sort(out.missing.begin(), out.missing.end(),
              [](const Missing& a, const Missing& b) { return a.job < b.job; });
    remove_partials(work.jobs);
    out.work_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return out;
  }

 private:
  int at_once_;
};

}  // namespace

std::unique_ptr<Executor> make_local(const ExecutorOptions& o) {
  return std::make_unique<Local>(o.at_once());
}

std::vector<std::string> arguments_of(const ExecutorOptions& o) {
  std::vector<std::string> out{"--executor", o.name};
  const auto add = [&](const char* option, auto value) {
    if (value > 0) out.insert(out.end(), {option, fmt::format("{}", value)});
  };
  if (!o.partition.empty()) out.insert(out.end(), {"--partition", o.partition});
  if (!o.account.empty()) out.insert(out.end(), {"--account", o.account});
  add("--time", o.time_min);
  add("--cpus", o.cpus);
  add("--tasks-at-once", o.tasks_at_once);
  add("--jobs-per-task", o.jobs_per_task);
  add("--attempts", o.attempts);
  add("--wait-h", o.wait_h);
  return out;
}

Result<std::unique_ptr<Executor>> make_executor(const ExecutorOptions& options) {
  if (options.name == "local") return make_local(options);
  if (options.name == "slurm") return make_slurm(options);
  return bad_input("'" + options.name + "' is no executor", "--executor", "Give local or slurm");
}

}  // namespace omniflight::jobs
