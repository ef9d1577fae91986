// The lab without the lab: boards on lines of their own, a simulated vehicle behind them, motion capture on
// the bus. A person at the rope is played too: the vehicle is held until the flight begins and caught when it
// ends.
#include <atomic>
#include <cstdio>
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

/// s that boards whose motors turn outlive the order to end: their power does not hang on this computer. The
/// host's ramp (0.5 s), or the boards' own watchdog and ramp (1 s), stop the motors before.
constexpr double kPowered = 3.0;

/// What arrives at the boards, a line a piece: CLOCK_MONOTONIC [ns], board, bytes as hexadecimal digits.
class LineLog {
 public:
  Status open(const std::string& path) {
    file_.reset(std::fopen(path.c_str(), "w"));
    if (!file_) return bad_input("cannot be written", path, "Name a file in a folder that exists");
    std::setvbuf(file_.get(), nullptr, _IOLBF, BUFSIZ);  // whoever reads along sees whole lines
    return {};
  }
  void note(std::size_t board, std::span<const std::uint8_t> bytes) {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    std::fprintf(file_.get(), "%lld %zu ", static_cast<long long>(std::chrono::nanoseconds(now).count()),
                 board);
    for (const std::uint8_t b : bytes) std::fprintf(file_.get(), "%02x", b);
    std::fputc('\n', file_.get());
  }
  void close() { file_.reset(); }

 private:
  struct Closer {
    void operator()(std::FILE* f) const { std::fclose(f); }
  };
  std::unique_ptr<std::FILE, Closer> file_;
};

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
    const std::string line_log = p.text("line_log", "");
    publisher_.name_mocap(p.text("mocap_topic", topics::mocap));
    epoch_ns_ = p.integer("epoch_monotonic_ns", 0, 0);
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
    if (!line_log.empty()) {
      if (auto ok = line_log_.open(line_log); !ok) return ok;
      config.on_received = [this](std::size_t board, std::span<const std::uint8_t> bytes) {
        line_log_.note(board, bytes);
      };
    }
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
    line_log_.close();
    return {};
  }

  Status run() override {
    const WallPace pace(epoch_ns_);
    const double step = parameters_.plant.step;
    double offset = pace.now();
    simulation::SensorFrame frame;
    std::optional<double> ordered_to_end;
    for (std::uint64_t k = 0;; ++k) {
      // the plant counts from zero; its samples carry flight time
      const double t = offset + plant_->time();
      if (!running()) {
        if (!ordered_to_end) ordered_to_end = t;
        if (!boards_->any_motor_on() || t > *ordered_to_end + kPowered) return {};
      }
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
  }

  PlantParameters parameters_;
  std::int64_t epoch_ns_ = 0;
  std::optional<simulation::Plant> plant_;
  std::optional<simulation::SensorSuite> sensors_;
  std::optional<PlantBehindBoards> behind_;
  LineLog line_log_;
  std::optional<gateway::BoardEmulator> boards_;
  PlantPublisher publisher_;
  std::optional<bus::Subscription<Tick>> tick_;
  std::atomic<std::uint8_t> phase_{0};
};

}  // namespace

std::unique_ptr<bus::Component> make_emulator() { return std::make_unique<Emulator>(); }

}  // namespace omniflight::components
