// The planner on the bus: plans a mission (or takes a plan that is there) and publishes its trajectory,
// latched. A mission that comes in flight (another goal, another map) is planned from the state that the
// flight will have a lead later; the trajectory that is published then is the old one up to there and the new
// one from then on, in the same time. Where there is no such plan in time, the reason is said and the old one
// is flown.
#include <fmt/format.h>

#include <atomic>
#include <filesystem>

#include "factories.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/say.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/replanning_message.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/replan.hpp"
#include "request_worker.hpp"
#include "trajectory_message.hpp"

namespace omniflight::components {
namespace {

using msgs::diagnostic_msgs::DiagnosticArray;
using msgs::omniflight_msgs::ControllerState;
using msgs::std_msgs::String;

class Planner final : public bus::Component {
 public:
  Planner() : Component("planner") {}
  ~Planner() override { worker_.stop(); }

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "planner");
    const std::string directory = p.text("plan", "");
    const std::string mission_name = p.text("mission", "");
    lead_ = p.number("replan_lead_s", 2.0, 0.1, 60);
    folder_ = p.text("replans", "");
    fixed_tilt_ = p.flag("fixed_tilt", false);
    latest_end_ = p.number("latest_end_s", kNoEnd, 0.0, kNoEnd);
    if (auto ok = p.finish(); !ok) return ok;
    if (directory.empty() == mission_name.empty())
      return bad_input("needs either a plan folder or a mission", "planner.plan");
    if (!directory.empty()) {
      auto plan = planning::read_plan(directory);
      if (!plan) return Failure(plan.error());
      trajectory_ = plan->trajectory;
    } else {
      auto mission = planning::load_mission(mission_name);
      if (!mission) return Failure(mission.error());
      auto plan = planning::plan_mission(*mission);
      if (!plan) return Failure(plan.error());
      trajectory_ = plan->trajectory;
    }
    auto made = advertise<TrajectoryMessage>(topics::trajectory, bus::Qos::latched_last());
    if (!made) return Failure(made.error());
    publisher_.emplace(std::move(*made));
    auto answers = advertise<DiagnosticArray>(topics::replanning, bus::Qos::latched_last(4));
    if (!answers) return Failure(answers.error());
    answers_.emplace(std::move(*answers));
    auto state = bus::Subscription<ControllerState>::create(
        participant(), topics::controller, bus::Qos::bulk(512),
        [this](const ControllerState& m, std::int64_t) { along_ = m.trajectory_time; });
    if (!state) return Failure(state.error());
    controller_.emplace(std::move(*state));
    auto missions = bus::Subscription<String>::create(
        participant(), topics::mission, bus::Qos::bulk(4),
        [this](const String& m, std::int64_t) { worker_.ask(std::string(bus::text(m.data))); });
    if (!missions) return Failure(missions.error());
    missions_.emplace(std::move(*missions));
    return {};
  }
  Status on_activate() override {
    to_message(trajectory_, *message_);
    if (auto ok = publisher_->publish(*message_, 0); !ok) return ok;
    worker_.start([this](const std::string& text) { plan_again(MissionRequest::of(text)); });
    return {};
  }
  Status on_deactivate() override {
    worker_.stop();
    return {};
  }
  Status on_cleanup() override {
    missions_.reset();
    controller_.reset();
    answers_.reset();
    publisher_.reset();
    return {};
  }

  /// In the worker's thread, which alone changes the trajectory once the component is active.
  void plan_again(const MissionRequest& request) {
    answer(request, Replanning::planning, "");
    if (auto ok = join(request); !ok) answer(request, Replanning::kept, ok.error().text());
  }

  /// Plans the mission and publishes the trajectory that goes on to it. An error: the old one is kept.
  Status join(const MissionRequest& request) {
    constexpr double kShareOfLead = 0.7;  // for planning; the rest is for the way over the bus
    const auto mission = planning::load_mission(request.mission);
    if (!mission) return Failure(mission.error());
    const double now = std::max(0.0, along_.load());
    planning::PlanOptions options;
    options.budget_s = std::min(mission->budget_s, kShareOfLead * lead_);
    const auto next = planning::replan(*mission, trajectory_, now + lead_, options);
    if (!next) return Failure(next.error());
    const planning::Certificate& c = next->plan.certificate;
    if (fixed_tilt_ && c.alpha_highest - c.alpha_lowest > 1e-9)
      return bad_input("its plan moves the tilt of the rotors, which the boards cannot",
                       request.mission + ": alpha_deg", "Give the tilt that is flown");
    if (const double end = next->trajectory.duration(); end > latest_end_)
      return fail(ErrorCode::incomplete,
                  fmt::format("its plan ends {:.1f} s after the flight does", end - latest_end_), "planner",
                  "Give fly more time with --stay");
    if (const double late = along_.load() - next->join; late > 0.0)
      return fail(ErrorCode::incomplete,
                  fmt::format("its plan came {:.3f} s after the time it was made for", late), "planner",
                  "Raise planner.replan_lead_s");
    if (!folder_.empty()) {
      const std::filesystem::path folder = folder_ / std::to_string(++replans_);
      if (auto ok = planning::write_plan(next->plan, folder); !ok) return ok;
      if (auto ok = files::write_file_atomic(folder / kJoinFile, fmt::format("{:.17g}\n", next->join)); !ok)
        return ok;
    }
    trajectory_ = next->trajectory;
    to_message(trajectory_, *message_);
    if (auto ok = publisher_->publish(*message_, 0); !ok) {
      finish(ok);
      return ok;
    }
    answer(request, Replanning::joined,
           fmt::format("flown from {:.2f} s on, to {:.2f} s", next->join, trajectory_.duration()));
    return {};
  }

  void answer(const MissionRequest& request, Replanning state, const std::string& words) {
    if (state == Replanning::kept)
      bus::say("planner", "the mission " + request.mission + " is not flown, the old plan is kept: " + words);
    if (state == Replanning::joined) bus::say("planner", "the mission " + request.mission + " is " + words);
    to_message({request, state, words}, *answer_);
    (void)answers_->publish(*answer_, 0);  // who listens does so to know; the flight does not need it
  }

  static constexpr double kNoEnd = 1e9;  // s
  Trajectory trajectory_;
  bool fixed_tilt_ = false;       // the plant cannot move the tilt in flight
  double latest_end_ = kNoEnd;    // s, in the time of the trajectory: no plan made in flight ends later
  double lead_ = 2.0;             // s, from a request to the time that its plan begins at
  std::filesystem::path folder_;  // where plans that were made in flight are kept; empty: nowhere
  int replans_ = 0;
  std::atomic<double> along_{-1.0};  // s, time of the trajectory; negative before it begins
  bus::Message<TrajectoryMessage> message_;
  std::optional<bus::Publisher<TrajectoryMessage>> publisher_;
  bus::Message<DiagnosticArray> answer_;
  std::optional<bus::Publisher<DiagnosticArray>> answers_;
  std::optional<bus::Subscription<ControllerState>> controller_;
  std::optional<bus::Subscription<String>> missions_;
  RequestWorker worker_;
};

}  // namespace

std::unique_ptr<bus::Component> make_planner() { return std::make_unique<Planner>(); }

}  // namespace omniflight::components
