#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <thread>

#include "omniflight_files/files.hpp"
#include "omniflight_jobs/child.hpp"
#include "omniflight_jobs/job.hpp"

namespace omniflight::jobs {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

const std::string kPartial = ".partial-";
constexpr double kEnding = 10.0;  // s that a program gets to end after SIGTERM

std::string host() {
  char name[256] = {};
  if (gethostname(name, sizeof name - 1) != 0) return "unknown";
  return name;
}

/// The name by which a cluster knows this machine; where there is no cluster, nothing.
std::string node() {
  const char* name = std::getenv("SLURMD_NODENAME");
  return name ? name : "";
}

/// Of all attempts at a job, beside its folder. Short: sockets in a folder have paths of 107 bytes at most.
std::string partial_prefix(const std::string& name) {
  return kPartial + files::sha256_hex(name).substr(0, 8) + "-";
}

/// No other attempt has it: neither on another machine, nor of another process, nor of another thread.
fs::path partial_of(const Job& job) {
  static std::atomic<unsigned> number{0};
  const std::string where = node().empty() ? host() : host() + "-" + node();
  return job.folder.parent_path() /
         fmt::format("{}{}-{}-{}", partial_prefix(job.folder.filename().string()), where, getpid(), number++);
}

/// The reason in words, of a program that ended with `code`.
std::string reason_of(int code, const Child& child) {
  const std::string words = child.last_words();
  if (code == 127) return "could not be started";
  if (code > 128) return fmt::format("was ended by signal {}: {}", code - 128, words);
  return fmt::format("ended with {}: {}", code, words);
}

/// Renames; done_before when somebody was quicker.
Performed publish(const Job& job, const fs::path& partial) {
  if (std::rename(partial.c_str(), job.folder.c_str()) == 0) return {Ending::done, {}, 0};
  const int error = errno;
  std::error_code ec;
  fs::remove_all(partial, ec);
  if (is_done(job)) return {Ending::done_before, {}, 0};
  return {Ending::failed, "cannot be put in place: " + std::string(std::strerror(error)), 0};
}

}  // namespace

bool is_done(const Job& job) {
  std::error_code ec;
  return fs::is_directory(job.folder, ec);
}

std::vector<char> are_done(const std::vector<Job>& jobs) {
  std::map<fs::path, std::set<std::string>> by_parent;
  std::vector<char> out;
  for (const Job& job : jobs) {
    const auto [at, fresh] = by_parent.try_emplace(job.folder.parent_path());
    std::error_code ec;
    if (fresh)
      for (const auto& entry : fs::directory_iterator(at->first, ec))
        at->second.insert(entry.path().filename().string());
    out.push_back(at->second.contains(job.folder.filename().string()));
  }
  return out;
}

Performed perform(const Job& job, const std::string& program, bool (*stop)()) {
  if (is_done(job)) return {Ending::done_before, {}, 0};
  const fs::path partial = partial_of(job);
  std::error_code ec;
  fs::create_directories(partial, ec);
  if (ec) return {Ending::failed, partial.string() + " cannot be made: " + ec.message(), 0};
  std::vector<std::string> arguments = job.command;
  for (std::string& a : arguments)
    if (a == kOut) a = partial.string();
  const auto begin = Clock::now();
  auto child = Child::start(program, arguments, {.log = (partial / "job.log").string()});
  if (!child) {
    fs::remove_all(partial, ec);
    return {Ending::failed, child.error().text(), 0};
  }
  std::optional<int> code;
  // short jobs are many: the wait begins short and grows
  for (auto wait = std::chrono::microseconds(200); !(code = child->poll());
       wait = std::min(2 * wait, std::chrono::microseconds(20000))) {
    if (stop && stop()) {
      child->terminate(kEnding);
      fs::remove_all(partial, ec);
      return {Ending::stopped, "stopped", 0};
    }
    std::this_thread::sleep_for(wait);
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (std::find(job.results.begin(), job.results.end(), *code) == job.results.end()) {
    Performed out{*code > 128 ? Ending::killed : Ending::failed, reason_of(*code, *child), seconds};
    if (stop && stop()) out = {Ending::stopped, "stopped", seconds};
    fs::remove_all(partial, ec);
    return out;
  }
  const nlohmann::json told{{"schema", "omniflight.job/1"}, {"name", job.name}, {"exit_code", *code},
                            {"seconds", seconds},           {"host", host()},   {"node", node()}};
  if (auto ok = files::write_file_atomic(partial / "job.json", told.dump(1) + "\n"); !ok) {
    fs::remove_all(partial, ec);
    return {Ending::failed, ok.error().text(), seconds};
  }
  Performed out = publish(job, partial);
  out.seconds = seconds;
  return out;
}

void remove_partials(const std::vector<Job>& jobs) {
  std::map<fs::path, std::set<std::string>> by_parent;
  for (const Job& job : jobs)
    if (is_done(job))
      by_parent[job.folder.parent_path()].insert(partial_prefix(job.folder.filename().string()));
  for (const auto& [parent, prefixes] : by_parent) {
    std::vector<fs::path> old;
    std::error_code ec;
    const std::size_t length = prefixes.begin()->size();
    for (const auto& entry : fs::directory_iterator(parent, ec))
      if (prefixes.contains(entry.path().filename().string().substr(0, length))) old.push_back(entry.path());
    for (const fs::path& folder : old) fs::remove_all(folder, ec);
  }
}

}  // namespace omniflight::jobs
