// The residuals of a diagnosis on the bus while the flight goes on, as ROS 2 tools know them: /diagnostics.
// It only listens; a flight is the same with and without it.
#include <fmt/format.h>

#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "conversions.hpp"
#include "factories.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_diagnosis/monitor.hpp"
#include "omniflight_files/files.hpp"
#include "plant_publisher.hpp"

namespace omniflight::components {
namespace {

using diagnosis::Check;
using diagnosis::Level;
using msgs::diagnostic_msgs::DiagnosticArray;
using msgs::omniflight_msgs::Tick;

/// What the checks came to over the whole flight.
struct Story {
  Level worst = Level::ok;
  double since = 0;  ///< s, stamp of the tick
  std::string message;
};

class MonitorComponent final : public bus::Component {
 public:
  MonitorComponent() : Component("monitor") {}
  ~MonitorComponent() override { stop(); }

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "monitor");
    const std::string vehicle_name = p.text("vehicle", {});
    const std::string overrides = p.text("vehicle_set", "");
    summary_file_ = p.text("summary_file", "");
    period_ = p.number("period_s", 0.1, 0.01, 10);
    silence_ = p.number("silence_s", 2.0, 0.1, 600);
    diagnosis::MonitorOptions o;
    const auto read = [&](const char* key, double& value, double low, double high) {
      value = p.number(key, value, low, high);
    };
    const std::vector<double> imu = p.numbers("imu_position_m", std::vector<double>(3, 0.0), 3);
    if (imu.size() == 3) o.imu_position = Vec3(imu[0], imu[1], imu[2]);
    read("grid_hz", o.grid_hz, 20, 2000);
    read("cutoff_hz", o.cutoff_hz, 0.05, 100);
    read("max_gap_s", o.max_gap_s, 0.001, 10);
    read("settle_s", o.settle_s, 0, 60);
    read("confirm_s", o.confirm_s, 0, 60);
    read("warn_sigma", o.warn_sigma, 0.1, 1e6);
    read("error_sigma", o.error_sigma, 0.1, 1e6);
    read("warn_speed", o.warn_speed, 1e-3, 10);
    read("error_speed", o.error_speed, 1e-3, 10);
    read("imu_stale_s", o.imu_stale_s, 0.001, 60);
    read("mocap_stale_s", o.mocap_stale_s, 0.001, 60);
    read("rotors_stale_s", o.rotors_stale_s, 0.001, 60);
    read("mocap_frozen_s", o.mocap_frozen_s, 0.001, 60);
    if (auto ok = p.finish(); !ok) return ok;
    auto vehicle = vehicle::load_vehicle(vehicle_name, split(overrides));
    if (!vehicle) return Failure(vehicle.error());
    auto monitor = diagnosis::Monitor::create(*vehicle, o);
    if (!monitor) return Failure(monitor.error());
    monitor_.emplace(std::move(*monitor));
    vehicle_ = vehicle->name;
    auto out = advertise<DiagnosticArray>(topics::diagnostics, bus::Qos::standard());
    if (!out) return Failure(out.error());
    publisher_.emplace(std::move(*out));
    return subscribe();
  }

  Status subscribe() {
    using namespace msgs;
    Status ok = listen<sensor_msgs::Imu>(imu_, topics::imu, 512, [this](const auto& m) {
      monitor_->add_imu(to_s(m.header.stamp), get(m.linear_acceleration), get(m.angular_velocity));
    });
    if (ok)
      ok = listen<geometry_msgs::PoseStamped>(mocap_, topics::mocap, 512, [this](const auto& m) {
        monitor_->add_mocap(to_s(m.header.stamp), get(m.pose.position), get_quaternion(m.pose.orientation));
      });
    if (ok)
      ok = listen<omniflight_msgs::RotorTelemetry>(rotors_, topics::rotors, 512, [this](const auto& m) {
        monitor_->add_rotors(to_s(m.header.stamp), bus::view(m.velocity), m.alpha);
      });
    if (ok)
      ok = listen<actuator_msgs::Actuators>(command_, topics::command, 512, [this](const auto& m) {
        monitor_->add_command(to_s(m.header.stamp), bus::view(m.velocity));
      });
    if (ok) ok = listen<Tick>(tick_, topics::tick, 512, [this](const Tick& m) { take(m); });
    return ok;
  }
  template <class T, class Take>
  Status listen(std::optional<bus::Subscription<T>>& slot, const char* topic, int depth, Take take) {
    auto made = bus::Subscription<T>::create(participant(), topic, bus::Qos::bulk(depth),
                                             [this, take](const T& m, std::int64_t) {
                                               const std::lock_guard lock(mutex_);
                                               take(m);
                                             });
    if (!made) return Failure(made.error());
    slot.emplace(std::move(*made));
    return {};
  }

  Status on_activate() override {
    {
      const std::lock_guard lock(mutex_);
      running_ = true;
    }
    thread_ = std::thread([this] { work(); });
    return {};
  }
  Status on_deactivate() override {
    stop();
    return write_summary();
  }
  Status on_cleanup() override {
    stop();
    tick_.reset();
    command_.reset();
    rotors_.reset();
    mocap_.reset();
    imu_.reset();
    publisher_.reset();
    monitor_.reset();
    return {};
  }
  void stop() {
    {
      const std::lock_guard lock(mutex_);
      running_ = false;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  /// Under the lock. Every period_ of flight time the checks are said, like the answers of the others inside
  /// the call that brought the tick: a recording is the same every time.
  void take(const Tick& m) {
    now_ = to_s(m.header.stamp);
    ++heard_;
    if (m.phase == static_cast<std::uint8_t>(FlightPhase::ended)) ended_ = true;
    if (ended_ || now_ < due_) return;
    due_ = now_ + period_;
    const bool free = m.phase == static_cast<std::uint8_t>(FlightPhase::free);
    const auto& checks = monitor_->assess(now_, free);
    bus::resize(message_->status, checks.size());
    for (std::size_t k = 0; k < checks.size(); ++k) {
      fill(bus::view(message_->status)[k], checks[k]);
      if (free) remember(stories_[k], checks[k]);  // before, a sensor may not have said anything yet
    }
    publish();
  }
  void remember(Story& story, const Check& check) {
    // a residual is stale until the first sample has passed its filter
    if (check.level == Level::stale || check.level <= story.worst) return;
    story = {check.level, now_, check.message};
  }
  void publish() {
    message_->header.stamp = bus::stamp(to_ns(now_));
    if (auto ok = publisher_->publish(*message_, to_ns(now_)); !ok) finish(ok);
  }
  void fill(msgs::diagnostic_msgs::DiagnosticStatus& out, const Check& check) {
    out.level = static_cast<std::uint8_t>(check.level);
    bus::set_text(out.name, "omniflight: " + check.name);
    bus::set_text(out.message, check.message);
    bus::set_text(out.hardware_id, vehicle_);
    bus::resize(out.values, check.values.size());
    for (std::size_t k = 0; k < check.values.size(); ++k) {
      bus::set_text(bus::view(out.values)[k].key, check.values[k].key);
      bus::set_text(bus::view(out.values)[k].value, fmt::format("{:.6g}", check.values[k].value));
    }
  }

  /// Says when the flight has fallen silent: without ticks nothing else here runs.
  void work() {
    std::unique_lock lock(mutex_);
    std::uint64_t heard = 0;
    auto last = std::chrono::steady_clock::now();
    bool silent = false;
    while (running_) {
      wake_.wait_for(lock, std::chrono::milliseconds(50), [&] { return !running_; });
      const auto now = std::chrono::steady_clock::now();
      if (heard != heard_ || ended_) {
        heard = heard_;
        last = now;
        silent = false;
      } else if (!silent && heard_ > 0 && std::chrono::duration<double>(now - last).count() > silence_) {
        silent = true;
        const Check gone{
            "flight", Level::error, fmt::format("no tick for {:.1f} s of wall time", silence_), {}};
        bus::resize(message_->status, 1);
        fill(bus::view(message_->status)[0], gone);
        remember(stories_[3], gone);
        publish();
      }
    }
  }

  Status write_summary() {
    if (summary_file_.empty()) return {};
    const std::lock_guard lock(mutex_);
    static const char* const names[] = {"wrench balance", "motors", "sensors", "flight"};
    Level worst = Level::ok;
    nlohmann::json checks = nlohmann::json::array();
    for (std::size_t k = 0; k < stories_.size(); ++k) {
      const Story& s = stories_[k];
      worst = std::max(worst, s.worst);
      checks.push_back({{"name", names[k]}, {"worst", diagnosis::to_string(s.worst)}});
      if (s.worst != Level::ok) checks.back().update({{"from_s", s.since}, {"message", s.message}});
    }
    const nlohmann::json j = {{"schema", "omniflight.monitor/1"},
                              {"worst", heard_ > 0 ? diagnosis::to_string(worst) : "STALE"},
                              {"vehicle", vehicle_},
                              {"checks", checks}};
    return files::write_file_atomic(summary_file_, j.dump(2) + "\n");
  }

  std::string summary_file_, vehicle_;
  double period_ = 0.1, silence_ = 2;
  std::mutex mutex_;  ///< guards everything below up to the thread
  std::condition_variable wake_;
  std::optional<diagnosis::Monitor> monitor_;
  double now_ = 0, due_ = -1;
  std::uint64_t heard_ = 0;
  bool running_ = false, ended_ = false;
  std::array<Story, 4> stories_;
  bus::Message<DiagnosticArray> message_;
  std::thread thread_;
  std::optional<bus::Publisher<DiagnosticArray>> publisher_;
  std::optional<bus::Subscription<msgs::sensor_msgs::Imu>> imu_;
  std::optional<bus::Subscription<msgs::geometry_msgs::PoseStamped>> mocap_;
  std::optional<bus::Subscription<msgs::omniflight_msgs::RotorTelemetry>> rotors_;
  std::optional<bus::Subscription<msgs::actuator_msgs::Actuators>> command_;
  std::optional<bus::Subscription<Tick>> tick_;
};

}  // namespace

std::unique_ptr<bus::Component> make_monitor() { return std::make_unique<MonitorComponent>(); }

}  // namespace omniflight::components
