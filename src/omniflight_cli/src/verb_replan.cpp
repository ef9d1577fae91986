// Asks the planner of a run for another mission while it flies.
#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <filesystem>
#include <mutex>

#include "bus_access.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/replanning_message.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_planning/mission.hpp"
#include "operator_desk.hpp"
#include "verbs.hpp"
#include "wait_until.hpp"

namespace omniflight::cli {
namespace {

using components::MissionRequest;
using components::Replanning;
using components::ReplanningAnswer;
using msgs::diagnostic_msgs::DiagnosticArray;
using msgs::std_msgs::String;
using Clock = std::chrono::steady_clock;

/// Asks for missions and keeps the answers to its own request.
class PlannerDesk {
 public:
  static Result<std::unique_ptr<PlannerDesk>> join(int domain) {
    std::unique_ptr<PlannerDesk> desk(new PlannerDesk());
    auto participant = bus::Participant::create(domain);
    if (!participant) return Failure(participant.error());
    desk->participant_ = *participant;
    auto asks = bus::Publisher<String>::create(*participant, components::topics::mission, bus::Qos::bulk(4));
    if (!asks) return Failure(asks.error());
    desk->asks_.emplace(std::move(*asks));
    auto answers = bus::Subscription<DiagnosticArray>::create(
        *participant, components::topics::replanning, bus::Qos::latched_last(4),
        [self = desk.get()](const DiagnosticArray& m, std::int64_t) {
          const auto answer = components::replanning_answer(m);
          const std::lock_guard lock(self->mutex_);
          if (answer && answer->request.id == self->id_) self->answer_ = answer;
        });
    if (!answers) return Failure(answers.error());
    desk->answers_.emplace(std::move(*answers));
    return desk;
  }
  /// Waits until the planner listens and can answer; false after the timeout [s].
  bool wait_for_planner(double timeout_s) const {
    return wait_until([&] { return asks_->peers() > 0 && answers_->peers() > 0; }, timeout_s, interrupted);
  }
  Status ask(const std::string& mission) {
    bus::set_text(message_->data, MissionRequest{mission, id_}.text());
    return asks_->publish(*message_);
  }
  /// The planner's last word on it, nothing when it has not begun. Waits for the final one up to timeout [s].
  std::optional<ReplanningAnswer> wait_for_answer(double timeout_s) const {
    (void)wait_until(
        [&] {
          const std::lock_guard lock(mutex_);
          return answer_ && answer_->state != Replanning::planning;
        },
        timeout_s, interrupted);
    const std::lock_guard lock(mutex_);
    return answer_;
  }

 private:
  PlannerDesk() = default;
  const std::string id_ =
      fmt::format("{}-{}", getpid(), Clock::now().time_since_epoch().count());  // of this request
  mutable std::mutex mutex_;
  std::optional<ReplanningAnswer> answer_;  ///< guarded by mutex_
  std::optional<bus::Participant> participant_;
  bus::Message<String> message_;
  std::optional<bus::Publisher<String>> asks_;
  std::optional<bus::Subscription<DiagnosticArray>> answers_;
};

/// One run's answer: joined, or not and why.
Result<int> ask(int domain, const std::string& mission, double wait_s, std::string keys,
                const Common& common) {
  if (auto ok = use_bus_of(domain, keys); !ok) return Failure(ok.error());
  auto desk = PlannerDesk::join(domain);
  if (!desk) return Failure(desk.error());
  const bool heard = (*desk)->wait_for_planner(kMeet);
  if (heard)
    if (auto ok = (*desk)->ask(mission); !ok) return Failure(ok.error());
  const auto answer = heard ? (*desk)->wait_for_answer(wait_s) : std::nullopt;
  const bool joined = answer && answer->state == Replanning::joined;
  const std::string words = answer && answer->state != Replanning::planning ? answer->words
                            : answer ? fmt::format("the planner has not answered within {} s", wait_s)
                            : heard  ? fmt::format("the planner has not begun within {} s", wait_s)
                                     : "no planner listens" + unheard(domain, keys);
  print_json(
      common,
      {{"domain", domain}, {"mission", mission}, {"heard", heard}, {"joined", joined}, {"reason", words}});
  say(common, fmt::format("domain {}: {}{}", domain, joined ? "" : "NOT flown: ", words));
  return joined ? 0 : static_cast<int>(ErrorCode::incomplete);
}

}  // namespace

Action add_replan(CLI::App& verb, Common& common) {
  auto mission = std::make_shared<std::string>();
  auto domain = std::make_shared<int>(-1);
  auto keys = std::make_shared<std::string>();
  auto wait_s = std::make_shared<double>(10.0);
  verb.add_option("mission", *mission,
                  "Name under configs/missions or a path: another goal, or another map as its test_bed")
      ->required();
  verb.add_option("--domain", *domain, "Domain of the run; default: the only run of this machine")
      ->check(CLI::Range(0, 231));
  verb.add_option("--wait", *wait_s, "s to wait for the planner's answer")->check(CLI::Range(0.1, 600.0));
  add_secure(verb, *keys);
  return [=, &common]() -> Result<int> {
    const auto read = planning::load_mission(*mission);  // its mistakes are told here, not in flight
    if (!read) return Failure(read.error());
    const std::vector<int> runs = *domain >= 0 ? std::vector<int>{*domain} : domains_in_use();
    if (runs.size() != 1)  // never a run that was not meant
      return fail(ErrorCode::incomplete,
                  runs.empty() ? "no run of this machine holds a domain" : "several runs hold a domain",
                  "replan", "Name the run with --domain");
    // the planner may stand in another folder
    return ask(runs.front(), std::filesystem::absolute(read->file).string(), *wait_s, *keys, common);
  };
}

}  // namespace omniflight::cli
