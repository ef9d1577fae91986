#include "omniflight_bus/run_components.hpp"

#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <mutex>

#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/heartbeat.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/security.hpp"
#include "omniflight_core/progress.hpp"

namespace omniflight::bus {
namespace {

/// Keeps the first error and prints every one.
class Verdict {
 public:
  explicit Verdict(bool quiet) : quiet_(quiet) {}
  bool take(const std::string& name, const char* what, const Status& status) {
    if (status) {
      if (!quiet_) std::fprintf(stderr, "[%s] %s\n", name.c_str(), what);
      return true;
    }
    std::fprintf(stderr, "[%s] not %s: %s\n", name.c_str(), what, status.error().text().c_str());
    if (code_ == 0) code_ = static_cast<int>(status.error().code);
    return false;
  }
  int code() const { return code_; }

 private:
  bool quiet_;
  int code_ = 0;
};

/// Wakes the runner when a component ends.
struct Wake {
  std::mutex mutex;
  std::condition_variable changed;
  bool ended = false;
  void notify() {
    const std::lock_guard lock(mutex);
    ended = true;
    changed.notify_all();
  }
  bool wait(std::chrono::milliseconds longest) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, longest, [this] { return ended; });
  }
};

Status start(Component& component, const Participant& participant, const RunOptions& options) {
  const auto parameters = load_parameters(options.parameter_files, options.overrides, component.name());
  if (!parameters) return Failure(parameters.error());
  return component.configure(participant, *parameters);
}

void wait_for_end(const std::vector<std::unique_ptr<Component>>& components, Wake& wake,
                  const RunOptions& options, Verdict& verdict) {
  const auto begin = std::chrono::steady_clock::now();
  auto next_report = begin + options.report;
  while (!wake.wait(options.poll) && !interrupted()) {
    const auto now = std::chrono::steady_clock::now();
    if (now >= next_report) {
      next_report = now + options.report;
      for (const auto& component : components) component->report();
    }
    if (options.timeout && now - begin > *options.timeout) {
      verdict.take("runner", "finished",
                   fail(ErrorCode::incomplete,
                        "still running after " + std::to_string(options.timeout->count()) + " s", "timeout",
                        "Allow more time or look for the component that waits"));
      return;
    }
  }
}

}  // namespace

int run_components(std::vector<std::unique_ptr<Component>> components, const RunOptions& options) {
  // Rotors wind down before the process ends, however impatient its operator is, and also when whoever read
  // what it says (`| tee`) has gone with the same Ctrl-C.
  install_interrupt_handler(SecondInterrupt::is_ignored);
  std::signal(SIGPIPE, SIG_IGN);
  Verdict verdict(options.quiet);
  if (!options.loopback_file.empty() &&
      !verdict.take("runner", "on loopback", use_loopback(options.loopback_file))) {
    return verdict.code();
  }
  if (!options.keys.empty() && !verdict.take("runner", "secured", use_security(options.keys, options.role))) {
    return verdict.code();
  }
  const Result<Participant> participant = Participant::create(options.domain);
  if (!participant) {
    verdict.take("runner", "joined", Failure(participant.error()));
    return verdict.code();
  }
  std::optional<Heartbeat> heartbeat;
  if (options.heartbeat) {
    std::string names;
    for (const auto& component : components) names += (names.empty() ? "" : "+") + component->name();
    auto started = Heartbeat::start(*participant, names, heartbeat_lease);
    if (!started) {
      verdict.take("runner", "beating", Failure(started.error()));
      return verdict.code();
    }
    heartbeat.emplace(std::move(*started));
  }
  const auto wake = std::make_shared<Wake>();
  bool running = true;
  for (auto& component : components) {
    component->on_outcome([wake] { wake->notify(); });
    running =
        running && verdict.take(component->name(), "configured", start(*component, *participant, options));
  }
  for (auto& component : components) {
    running = running && verdict.take(component->name(), "activated", component->activate());
  }
  if (running) wait_for_end(components, *wake, options, verdict);
  for (auto& component : components) {
    if (const auto outcome = component->outcome()) verdict.take(component->name(), "finished", *outcome);
  }
  // First everything falls silent, then everything is taken apart: a recorder hears the last message of the
  // others.
  for (auto component = components.rbegin(); component != components.rend(); ++component) {
    if ((*component)->phase() != ComponentPhase::active) continue;
    verdict.take((*component)->name(), "deactivated", (*component)->deactivate());
  }
  for (auto component = components.rbegin(); component != components.rend(); ++component) {
    verdict.take((*component)->name(), "shut down", (*component)->shutdown());
    component->reset();
  }
  return verdict.code();
}

}  // namespace omniflight::bus
