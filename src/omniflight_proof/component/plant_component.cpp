#include "plant_component.hpp"

#include <atomic>
#include <sstream>
#include <thread>

#include "command_inbox.hpp"
#include "omniflight_bus/parameters.hpp"
#include "plant_publisher.hpp"

namespace omniflight::proof {
namespace {

using namespace std::chrono_literals;
using Seconds = std::chrono::duration<double>;
using Watch = std::chrono::steady_clock;
using msgs::omniflight_msgs::RecorderState;
constexpr const char* kName = "mujoco_plant";

class PlantComponent final : public bus::Component {
 public:
  PlantComponent() : Component(kName) {}
  ~PlantComponent() override { stop(); }

 private:
  Status on_configure(const YAML::Node& node) override;
  Status on_activate() override {
    running_ = true;
    thread_ = std::thread([this] { finish(run()); });
    return {};
  }
  Status on_deactivate() override {
    stop();
    return {};
  }
  Status on_cleanup() override {
    stop();
    recorder_.reset();
    inbox_.unsubscribe();
    publisher_.destroy();
    return {};
  }
  void stop() {
    running_ = false;
    if (thread_.joinable()) thread_.join();
  }

  Status run();
  Status meet_peers();
  Status obey(double t);
  Status follow_recorder();
  Status stopped() const { return fail(ErrorCode::incomplete, "stopped in flight", kName); }
  /// Tells everybody that the flight is over, and why.
  Status give_up(Status why) {
    (void)publisher_.tick(plant_->time(), period_, Phase::ended);
    return why;
  }
  Status execute(const CommandInbox::Command& c) {
    if (c.count > 0 && !plant_->set_command({c.speed.data(), c.count}, c.alpha))
      return fail(ErrorCode::internal,
                  "the allocator commands a speed that is not finite or has the wrong count", kName);
    return {};
  }

  std::optional<MujocoPlant> plant_;
  std::optional<SensorSuite> sensors_;
  PlantPublisher publisher_;
  CommandInbox inbox_;
  std::optional<bus::Subscription<RecorderState>> recorder_;
  std::atomic<std::uint64_t> recorded_ticks_{0};
  std::atomic<bool> running_{false};
  std::thread thread_;
  bool lockstep_ = true;
  std::uint64_t window_ = 0;
  double period_ = 0.002, hold_ = 1, duration_ = 10, peers_timeout_ = 20, command_timeout_ = 2,
         stale_after_ = 0.1;
};

Status PlantComponent::on_configure(const YAML::Node& node) {
  bus::Parameters p(node, kName);
  const std::string name = p.text("vehicle", {}), overrides = p.text("vehicle_set", "");
  const std::string world_file = p.text("world", ""), sensor_file = p.text("sensors", "");
  const std::string rate = p.text("rate", "max");
  PlantOptions options;
  options.seed = static_cast<std::uint64_t>(p.integer("seed", 1, 0));
  options.step = p.number("step_s", 0.001, 1e-5, 0.02);
  period_ = p.number("control_period_s", 0.002, 1e-4, 0.1);
  hold_ = p.number("hold_s", 1.0, 0.0, 60.0);
  duration_ = p.number("duration_s", 10.0, 0.01, 36000.0);
  peers_timeout_ = p.number("peers_timeout_s", 20.0, 0.1, 600.0);
  command_timeout_ = p.number("command_timeout_s", 2.0, 0.01, 60.0);
  stale_after_ = p.number("stale_after_s", 0.1, 0.005, 10.0);
  window_ = static_cast<std::uint64_t>(p.integer("recorder_window_ticks", 0, 0, 100000));
  const auto position = p.numbers("initial_position_m", std::vector<double>{0, 0, 1}, 3);
  const auto rpy = p.numbers("initial_rpy_deg", std::vector<double>{0, 0, 0}, 3);
  const double alpha = to_radians(p.number("initial_alpha_deg", 30.0, -180, 180));
  if (auto ok = p.finish(); !ok) return ok;
  if (rate != "max" && rate != "realtime")
    return bad_input("'" + rate + "' is neither max nor realtime", "mujoco_plant.rate");
  lockstep_ = rate == "max";
  const double ratio = period_ / options.step;
  if (std::abs(ratio - std::round(ratio)) > 1e-6 || ratio < 0.999)
    return bad_input("is no whole multiple of step_s", "mujoco_plant.control_period_s");

  std::vector<std::string> set;
  std::istringstream items(overrides);
  for (std::string item; std::getline(items, item, ';');)
    if (!item.empty()) set.push_back(item);
  auto vehicle = vehicle::load_vehicle(name, set);
  if (!vehicle) return Failure(vehicle.error());
  World world;
  if (!world_file.empty()) {
    auto loaded = load_world(world_file);
    if (!loaded) return Failure(loaded.error());
    world = std::move(*loaded);
  }
  SensorConfig config;
  if (!sensor_file.empty()) {
    auto loaded = load_sensors(sensor_file);
    if (!loaded) return Failure(loaded.error());
    config = *loaded;
  }
  options.initial.p_WB = Vec3(position[0], position[1], position[2]);
  options.initial.q_WB = from_roll_pitch_yaw((kPi / 180.0) * Vec3(rpy[0], rpy[1], rpy[2]));
  options.initial_alpha = vehicle->tilt.kind == vehicle::TiltKind::none
                              ? 0.0
                              : std::clamp(alpha, vehicle->tilt.min, vehicle->tilt.max);
  auto plant = MujocoPlant::create(*vehicle, world, options);
  if (!plant) {
    Error e = plant.error();
    if (!world_file.empty()) e.where = world_file + ": " + e.where;
    return Failure(e);
  }
  plant_.emplace(std::move(*plant));
  sensors_.emplace(config, world.sensors, options.step, options.seed);

  const auto make = [this]<class T>(std::optional<bus::Publisher<T>>& slot, const char* topic,
                                    const bus::Qos& qos) -> Status {
    auto made = advertise<T>(topic, qos);
    if (!made) return Failure(made.error());
    slot.emplace(std::move(*made));
    return {};
  };
  if (auto ok = publisher_.create(make, vehicle->rotors.size()); !ok) return ok;
  if (window_ > 0) {
    auto made = bus::Subscription<RecorderState>::create(
        participant(), topics::recorder, bus::Qos::control(),
        [this](const RecorderState& m, std::int64_t) { recorded_ticks_.store(m.ticks_seen); });
    if (!made) return Failure(made.error());
    recorder_.emplace(std::move(*made));
  }
  return inbox_.subscribe(participant());
}

Status PlantComponent::meet_peers() {
  const std::uint32_t listeners = window_ > 0 ? 2 : 1;  // the controller, and the recorder
  const auto deadline = Watch::now() + Seconds(peers_timeout_);
  for (;;) {
    const bool commanded = inbox_.peers() > 0, heard = publisher_.peers() >= listeners;
    if (commanded && heard && (window_ == 0 || recorder_->peers() > 0)) {
      std::this_thread::sleep_for(50ms);  // the other side may know a few milliseconds later
      return {};
    }
    if (!running_) return stopped();
    if (Watch::now() > deadline)
      return fail(ErrorCode::incomplete,
                  "waited " + std::to_string(peers_timeout_) + " s for " +
                      (!commanded ? "an allocator that publishes commands"
                                  : (heard ? "a recorder" : "a controller that follows the ticks")),
                  kName, "Start the missing component in the same domain");
    std::this_thread::sleep_for(10ms);
  }
}

/// In lockstep: executes the command for the tick at t, or fails once the deadline has passed. In real time:
/// the newest command, unless it is stale.
Status PlantComponent::obey(double t) {
  const std::int64_t stamp = to_ns(t);
  if (!lockstep_) {
    const auto command = inbox_.newest();
    if (command.stamp_ns < 0 && t < hold_) return {};
    const double age = 1e-9 * static_cast<double>(stamp - command.stamp_ns);
    if (command.stamp_ns < 0 || age > stale_after_ || age < 0)  // nobody answers a tick that has not been
      return give_up(fail(ErrorCode::incomplete, "the newest command is " + std::to_string(age) + " s old",
                          kName, "See whether controller and allocator are still alive"));
    return execute(command);
  }
  CommandInbox::Command command;
  const bool first = publisher_.ticks() == 1;  // controller and allocator may still be looking for each other
  const auto deadline =
      Watch::now() + Seconds(first ? std::max(command_timeout_, peers_timeout_) : command_timeout_);
  for (int waited = 1; !inbox_.wait_for(stamp, 50ms, command); ++waited) {
    if (!running_) return stopped();
    // they may have met after the first answer, which nobody heard then
    if (first && waited % 6 == 0)
      if (auto ok = publisher_.repeat_tick(); !ok) return ok;
    if (Watch::now() > deadline)
      return give_up(fail(ErrorCode::incomplete,
                          "no command for the tick at " + std::to_string(t) + " s of simulated time", kName,
                          "See whether controller and allocator are still alive"));
  }
  return execute(command);
}

Status PlantComponent::follow_recorder() {
  if (window_ == 0 || !lockstep_) return {};
  const auto deadline = Watch::now() + 10s;
  while (publisher_.ticks() > recorded_ticks_ + window_) {
    if (!running_) return stopped();
    if (Watch::now() > deadline)
      return fail(ErrorCode::incomplete, "the recorder has not kept up for 10 s", kName,
                  "See whether the recorder is alive and its disk is not full");
    std::this_thread::sleep_for(100us);
  }
  return {};
}

Status PlantComponent::run() {
  if (auto ok = meet_peers(); !ok) return ok;
  const auto start = Watch::now();
  const double step = plant_->options().step;
  const auto steps_a_tick = static_cast<std::uint64_t>(std::llround(period_ / step));
  const auto steps = static_cast<std::uint64_t>(std::ceil(duration_ / step));
  SensorFrame frame;
  for (std::uint64_t k = 0; k <= steps; ++k) {
    if (!running_) return stopped();
    const double t = plant_->time();
    const bool held = t < hold_ - 1e-9;
    sensors_->sample(*plant_, frame);
    if (auto ok = publisher_.sensors(frame, *plant_); !ok) return ok;
    if (k % steps_a_tick == 0) {
      if (auto ok = publisher_.truth(*plant_); !ok) return ok;
      const bool last = k + steps_a_tick > steps;
      if (!lockstep_)
        std::this_thread::sleep_until(start + std::chrono::duration_cast<Watch::duration>(Seconds(t)));
      if (auto ok = publisher_.tick(t, period_, last ? Phase::ended : (held ? Phase::held : Phase::free));
          !ok)
        return ok;
      if (last) break;
      if (auto ok = obey(t); !ok) return ok;
      if (auto ok = follow_recorder(); !ok) return ok;
    }
    if (auto ok = plant_->step(held); !ok) return give_up(ok);
  }
  return {};
}

}  // namespace

std::unique_ptr<bus::Component> make_plant_component() { return std::make_unique<PlantComponent>(); }

}  // namespace omniflight::proof
