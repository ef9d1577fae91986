// The planner on the bus: plans a mission (or takes a plan that is there) and publishes its trajectory,
// latched.
#include "factories.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_planning/plan.hpp"
#include "trajectory_message.hpp"

namespace omniflight::components {
namespace {

class Planner final : public bus::Component {
 public:
  Planner() : Component("planner") {}

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "planner");
    const std::string directory = p.text("plan", "");
    const std::string mission_name = p.text("mission", "");
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
    return {};
  }
  Status on_activate() override {
    to_message(trajectory_, *message_);
    return publisher_->publish(*message_, 0);
  }
  Status on_cleanup() override {
    publisher_.reset();
    return {};
  }

  Trajectory trajectory_;
  bus::Message<TrajectoryMessage> message_;
  std::optional<bus::Publisher<TrajectoryMessage>> publisher_;
};

}  // namespace

std::unique_ptr<bus::Component> make_planner() { return std::make_unique<Planner>(); }

}  // namespace omniflight::components
