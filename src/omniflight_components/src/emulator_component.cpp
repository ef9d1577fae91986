// The lab without the lab: boards on lines of their own, a simulated vehicle behind them, motion capture on
// the bus. A person at the rope is played too: the vehicle is held until the flight begins and caught when it
// ends.
#include <atomic>
#include <filesystem>

#include "conversions.hpp"
#include "factories.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_gateway/board_emulator.hpp"
#include "plant_parameters.hpp"
#include "plant_publisher.hpp"
#include "threaded_component.hpp"
#include "wall_pace.hpp"

namespace omniflight::components {
namespace {

using msgs::omniflight_msgs::Tick;

/// The simulator as the physics behind the boards.
class PlantBehindBoards final : public gateway::EmulatedPlant {
 public:
  explicit PlantBehindBoards(simulation::Plant& plant) : plant_(plant) {}
  void set_command(std::span<const double> speed) override {
    (void)plant_.set_command(speed, plant_.config().initial_alpha);
  }
  gateway::PlantSample sample() override {
    gateway::PlantSample s = last_;
    const auto speeds = plant_.rotor_speed();
    s.rotor_speed_radps.assign(speeds.begin(), speeds.end());
    return s;
  }
  void set_sensors(const simulation::SensorFrame& frame) {
    if (frame.imu) {
      last_.specific_force_B = frame.imu_sample.specific_force_B;
      last_.w_WB_B = frame.imu_sample.gyro_B;
    }
    if (frame.battery) last_.battery_V = frame.battery_sample.voltage;
  }

 private:
  simulation::Plant& plant_;
  gateway::PlantSample last_;
};

class Emulator final : public ThreadedComponent {
 public:
  Emulator() : ThreadedComponent("emulator") {}
  ~Emulator() override { stop(); }

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "emulator");
    const std::string links = p.text("link_directory", {}), line = p.text("line", "socket");
    epoch_ns_ = p.integer("epoch_ns", 0, 0);
    auto read = read_plant_parameters(p);
    if (!read) return Failure(read.error());
    if (line != "socket" && line != "pty")
      return bad_input("must be socket or pty, is '" + line + "'", "emulator.line",
                       "Take socket, or pty to go through the kernel's path of a serial device");
    parameters_ = std::move(*read);
    if (auto ok = make_plant(parameters_, plant_, sensors_); !ok) return ok;
    behind_.emplace(*plant_);
    std::error_code ec;
    std::filesystem::create_directories(links, ec);
    auto config = gateway::EmulatorConfig::omnimorph();
    config.link_directory = links;
    config.line = line == "pty" ? gateway::LineKind::pseudo_terminal : gateway::LineKind::socket;
    auto boards = gateway::BoardEmulator::create(std::move(config), *behind_);
    if (!boards) return Failure(boards.error());
    boards_.emplace(std::move(*boards));
    if (auto ok =
            create_publishers(publisher_, parameters_.vehicle.rotor_count(), PlantPublisher::Part::world);
        !ok)
      return ok;
    auto tick =
        bus::Subscription<Tick>::create(participant(), topics::tick, bus::Qos::bulk(64),
                                        [this](const Tick& m, std::int64_t) { phase_.store(m.phase); });
    if (!tick) return Failure(tick.error());
    tick_.emplace(std::move(*tick));
    return {};
  }
  Status on_cleanup() override {
    stop();
    tick_.reset();
    publisher_.destroy();
    boards_.reset();
    return {};
  }

  Status run() override {
    const WallPace pace(epoch_ns_);
    const double step = parameters_.plant.step;
    double offset = pace.now();
    simulation::SensorFrame frame;
    for (std::uint64_t k = 0; running(); ++k) {
      // the plant counts from zero; its samples carry flight time
      const double t = offset + plant_->time();
      const bool free = phase_.load() == static_cast<std::uint8_t>(FlightPhase::free);
      sensors_->sample(*plant_, frame);
      behind_->set_sensors(frame);
      if (frame.mocap) {
        simulation::MocapSample pose = frame.mocap_sample;
        pose.t += offset;
        if (auto ok = publisher_.mocap(pose, t); !ok) return ok;
      }
      if (k % 2 == 0)
        if (auto ok = publisher_.truth(*plant_, offset); !ok) return ok;
      if (auto ok = boards_->step(t); !ok) return ok;
      if (auto ok = plant_->step(!free); !ok) return ok;
      // time that the machine slept through is left out: a burst of samples would carry one time
      if (const double late = pace.now() - (t + step); late > 0.05) offset += late;
      pace.sleep_until(t + step);
    }
    return {};
  }

  PlantParameters parameters_;
  std::int64_t epoch_ns_ = 0;
  std::optional<simulation::Plant> plant_;
  std::optional<simulation::SensorSuite> sensors_;
  std::optional<PlantBehindBoards> behind_;
  std::optional<gateway::BoardEmulator> boards_;
  PlantPublisher publisher_;
  std::optional<bus::Subscription<Tick>> tick_;
  std::atomic<std::uint8_t> phase_{0};
};

}  // namespace

std::unique_ptr<bus::Component> make_emulator() { return std::make_unique<Emulator>(); }

}  // namespace omniflight::components
