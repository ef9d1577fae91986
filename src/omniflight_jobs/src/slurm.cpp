// Jobs as an array under Slurm. Results are the folders alone; what Slurm says of tasks is only for waiting
// and for words.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <thread>

#include "executors.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_jobs/task.hpp"
#include "slurm_commands.hpp"

namespace omniflight::jobs {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kLook = 0.5;       // s between two looks at the folders
constexpr double kAsk = 3.0;        // s between two questions to the controller
constexpr double kSilent = 900;     // s that the controller may not answer
constexpr double kHeld = 10;        // s that tasks may be on hold
constexpr double kLateFolder = 10;  // s until a folder of another machine is seen (attribute cache of NFS)

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// One run over a list of jobs.
class Run {
 public:
  Run(const ExecutorOptions& options, const SlurmCommands& slurm, const Work& work)
      : o_(options), slurm_(slurm), work_(work), reasons_(work.jobs.size()), done_(work.jobs.size(), 0) {}

  Result<Ran> go() {
    std::error_code ec;
    fs::create_directories(work_.folder, ec);
    if (ec)
      return bad_input("cannot be made: " + ec.message(), work_.folder.string(), "Choose another --out");
    look();
    out_.before = count_;
    const auto begin = Clock::now();
    if (auto ok = wait_for_earlier(); !ok) return Failure(ok.error());
    for (int k = 0; k < o_.attempts && !over(); ++k) {
      if (open().empty()) break;
      if (work_.may_begin && !work_.may_begin()) {
        for (const std::size_t job : open())
          if (reasons_[job].words.empty()) reasons_[job].words = kNoTime;
        break;
      }
      if (k > 0) say(fmt::format("{} jobs left no result; they are submitted again", open().size()));
      if (auto ok = one_array(); !ok) return Failure(ok.error());
    }
    out_.work_s = since(begin) - out_.submit_s;
    const auto collect = Clock::now();
    look();
    out_.made = count_ - out_.before;
    for (std::size_t k = 0; k < work_.jobs.size(); ++k)
      if (!done_[k])
        out_.missing.push_back({k, reasons_[k].words.empty() ? "it was not come to" : reasons_[k].words});
    remove_partials(work_.jobs);
    out_.collect_s = since(collect);
    out_.remarks.insert(out_.remarks.end(), remarks_.begin(), remarks_.end());
    return out_;
  }

 private:
  struct Reason {
    std::string words;
    bool final = false;  ///< the program itself said that it cannot
  };

  void say(const std::string& line) const {
    if (work_.say) work_.say(line);
  }
  bool stopped() {
    out_.stopped = out_.stopped || (work_.stop && work_.stop());
    return out_.stopped;
  }
  /// Ended from outside, or by its deadline.
  bool over() { return stopped() || since(begin_) > 3600 * o_.wait_h; }

  void look() {
    const auto begin = Clock::now();
    done_ = are_done(work_.jobs);
    count_ = static_cast<std::size_t>(std::count(done_.begin(), done_.end(), 1));
    if (work_.progress) work_.progress(count_);
    look_s_ = since(begin);
  }
  /// Until the next look: at most a twentieth of the time goes into looking.
  void rest() const {
    std::this_thread::sleep_for(std::chrono::duration<double>(std::max(kLook, 20 * look_s_)));
  }
  std::vector<std::size_t> open() const {
    std::vector<std::size_t> out;
    for (std::size_t k = 0; k < work_.jobs.size(); ++k)
      if (!done_[k] && !reasons_[k].final) out.push_back(k);
    return out;
  }

  /// An array that an earlier run has left is waited for: its jobs are these.
  Status wait_for_earlier() {
    std::vector<fs::path> left;
    std::error_code ec;
    for (const auto& entry : fs::directory_iterator(work_.folder, ec))
      if (entry.path().extension() == ".id") left.push_back(entry.path());
    std::sort(left.begin(), left.end());
    for (const fs::path& file : left) {
      const auto id = files::read_file(file, 1000);
      const auto tasks = id ? slurm_.queue(*id) : Result<std::vector<QueuedTask>>(Failure(id.error()));
      if (tasks && !tasks->empty()) {
        say(fmt::format("array {} of an earlier run is still at work: {} tasks", *id, tasks->size()));
        if (auto ok = wait(*id); !ok) return ok;
      }
      if (!stopped()) fs::remove(file, ec);
    }
    return {};
  }

  /// A name that no array of this folder has.
  fs::path fresh() const {
    std::error_code ec;
    for (int k = 1;; ++k)
      if (const fs::path file = work_.folder / fmt::format("array-{}.json", k); !fs::exists(file, ec))
        return file;
  }

  Result<std::string> submit(const std::vector<std::size_t>& jobs, const fs::path& file) {
    const std::size_t most = slurm_.largest_array();
    std::size_t each = (jobs.size() + most - 1) / most;
    if (o_.jobs_per_task > 0) {
      if (static_cast<std::size_t>(o_.jobs_per_task) < each)
        remarks_.insert(
            fmt::format("{} jobs a task instead of {}: the cluster's arrays have at most {} tasks", each,
                        o_.jobs_per_task, most));
      each = std::max(each, static_cast<std::size_t>(o_.jobs_per_task));
    }
    JobArray array{work_.program, {}, {}};
    for (std::size_t k = 0; k < jobs.size(); ++k) {
      if (k % each == 0) array.tasks.emplace_back();
      array.tasks.back().push_back(k);
      array.jobs.push_back(work_.jobs[jobs[k]]);
    }
    each_ = each;
    if (auto ok = write_array(array, file); !ok) return Failure(ok.error());
    std::string line = "exec " + shell_word(work_.program);
    for (const std::string& a : work_.run_task) line += " " + shell_word(a);
    line += " " + shell_word(file.string()) + " \"$SLURM_ARRAY_TASK_ID\"\n";
    const fs::path script = file.string() + ".sh", logs = file.string() + ".log";
    if (auto ok = files::write_file_atomic(script, "#!/bin/sh\n" + line); !ok) return Failure(ok.error());
    std::error_code ec;
    fs::create_directories(logs, ec);
    return slurm_.submit(o_, array.tasks.size(), script, logs / "%a.txt");
  }

  Status one_array() {
    const auto begin = Clock::now();
    const std::vector<std::size_t> jobs = open();
    const fs::path file = fresh();
    const auto id = submit(jobs, file);
    if (!id) return Failure(id.error());
    const fs::path id_file = file.string() + ".id";
    if (auto ok = files::write_file_atomic(id_file, *id); !ok) return ok;
    out_.submit_s += since(begin);
    ++out_.arrays;
    say(fmt::format("array {}: {} jobs in {} tasks", *id, jobs.size(), (jobs.size() + each_ - 1) / each_));
    if (auto ok = wait(*id); !ok) return ok;
    if (stopped()) return {};
    learn(*id, jobs, file);
    std::error_code ec;
    fs::remove(id_file, ec);
    return {};
  }

  /// Why jobs of an array have no result.
  void learn(const std::string& id, const std::vector<std::size_t>& jobs, const fs::path& file) {
    const auto begin = Clock::now();
    while (!open().empty() && since(begin) < kLateFolder) {
      look();
      if (open().empty()) return;
      rest();
    }
    std::string remark;
    const Endings endings = slurm_.endings(id, remark);
    for (std::size_t k = 0; k < jobs.size(); ++k) {
      if (done_[jobs[k]]) continue;
      Reason& reason = reasons_[jobs[k]];
      const auto ended = endings.find(k / each_);
      if (const auto failure = failure_of(work_.jobs[jobs[k]], file)) {
        reason = {failure->reason, !failure->killed};
      } else {
        reason.words = fmt::format(
            "lost: task {} of array {} {}", k / each_, id,
            ended == endings.end() ? "ended, and nothing is known of how" : "ended as " + ended->second);
        if (!remark.empty()) remarks_.insert(remark);
      }
    }
  }

  /// Tasks that will never start, and those on hold. True: the array was cancelled and has ended.
  Result<bool> cannot_start(const std::string& id, const std::vector<QueuedTask>& tasks) {
    Blocked why;
    const bool all = !tasks.empty() && std::all_of(tasks.begin(), tasks.end(), [&](const QueuedTask& t) {
      if (t.state != "PENDING") return false;
      if (is_held(t.reason)) return true;
      why = blocked(t.reason);
      return !why.error.message.empty();
    });
    if (!all) blocked_since_ = Clock::now();
    if (since(blocked_since_) < std::max(kHeld, why.patience_s)) return false;
    blocked_since_ = Clock::now();
    slurm_.cancel(id);
    if (!why.error.message.empty()) return Failure(why.error);
    remarks_.insert("tasks of array " + id + " were on hold (" + tasks.front().reason +
                    ") and were cancelled");
    return true;
  }

  /// Until the array has no tasks any more, every job has a result, or the work is over.
  Status wait(const std::string& id) {
    auto asked = Clock::now() - std::chrono::hours(1), answered = Clock::now();
    std::map<std::size_t, int> restarts;
    while (true) {
      look();
      if (over() || count_ == work_.jobs.size()) {
        slurm_.cancel(id);  // what runs still only repeats what is there, or shall not go on
        if (count_ < work_.jobs.size()) say("array " + id + " was cancelled");
        break;
      }
      if (since(asked) >= kAsk) {
        asked = Clock::now();
        const auto tasks = slurm_.queue(id);
        if (!tasks && since(answered) > kSilent) return Failure(tasks.error());
        if (tasks) {
          answered = Clock::now();
          for (const QueuedTask& t : *tasks) restarts[t.number] = std::max(restarts[t.number], t.restarts);
          if (tasks->empty()) break;
          const auto ended = cannot_start(id, *tasks);
          if (!ended) return Failure(ended.error());
          if (*ended) break;
        }
      }
      rest();
    }
    for (const auto& [task, count] : restarts) out_.requeued += count;
    return {};
  }

  const ExecutorOptions& o_;
  const SlurmCommands& slurm_;
  const Work& work_;
  Ran out_;
  std::vector<Reason> reasons_;
  std::vector<char> done_;
  std::size_t count_ = 0, each_ = 1;
  double look_s_ = 0;
  Clock::time_point blocked_since_ = Clock::now();  ///< a task could start then
  std::set<std::string> remarks_;
  Clock::time_point begin_ = Clock::now();
};

class Slurm final : public Executor {
 public:
  Slurm(ExecutorOptions options, SlurmCommands commands)
      : options_(std::move(options)), commands_(std::move(commands)) {}
  Result<Ran> run(const Work& work) override { return Run(options_, commands_, work).go(); }

 private:
  ExecutorOptions options_;
  SlurmCommands commands_;
};

}  // namespace

Result<std::unique_ptr<Executor>> make_slurm(const ExecutorOptions& options) {
  auto commands = SlurmCommands::find();
  if (!commands) return Failure(commands.error());
  return std::make_unique<Slurm>(options, std::move(*commands));
}

}  // namespace omniflight::jobs
