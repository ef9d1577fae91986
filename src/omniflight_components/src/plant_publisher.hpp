// What the plant side of the bus publishes, whoever plays it: simulator, emulator or gateway.
#pragma once

#include <optional>

#include "omniflight_bus/publisher.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_simulation/plant.hpp"
#include "omniflight_simulation/sensors.hpp"

namespace omniflight::components {

/// Phases of a Tick.
enum class FlightPhase : std::uint8_t { held = 0, free = 1, ended = 2 };

/// Publishers of sensor samples and ticks with their counts. Publishing allocates nothing.
class PlantPublisher {
 public:
  /// Which of them a component owns: all (a simulator), what boards measure, or what the world around
  /// measures.
  enum class Part { all, boards, world };
  /// Creates what a component needs; advertise is the component's own function, so that counts are reported.
  template <class Advertise>
  Status create(Advertise&& advertise, int rotors, Part part = Part::all) {
    const auto make = [&](auto& slot, const char* topic, const bus::Qos& qos) -> Status {
      auto made = advertise(slot, topic, qos);
      return made;
    };
    counted_ = part == Part::all;
    Status ok;
    const auto need = [&](Part of, auto& slot, const char* topic, int depth) {
      if (ok && (part == Part::all || part == of)) ok = make(slot, topic, bus::Qos::bulk(depth));
    };
    need(Part::boards, imu_, topics::imu, 512);
    need(Part::boards, rotor_, topics::rotors, 512);
    need(Part::boards, battery_, topics::battery, 64);
    need(Part::boards, tick_, topics::tick, 512);
    need(Part::world, mocap_, mocap_topic_.c_str(), 512);
    need(Part::world, truth_, topics::truth, 512);
    if (!ok) return ok;
    bus::resize(rotor_message_->velocity, static_cast<std::size_t>(rotors));
    bus::resize(rotor_message_->current, static_cast<std::size_t>(rotors));
    bus::resize(truth_message_->rotor_velocity, static_cast<std::size_t>(rotors));
    bus::set_text(imu_message_->header.frame_id, "base_link");
    bus::set_text(mocap_message_->header.frame_id, "map");
    bus::set_text(truth_message_->header.frame_id, "map");
    for (double* covariance :
         {imu_message_->orientation_covariance, imu_message_->angular_velocity_covariance,
          imu_message_->linear_acceleration_covariance})
      covariance[0] = covariance == imu_message_->orientation_covariance ? -1.0 : 0.0;
    return {};
  }
  void destroy();
  /// Before create(): the topic of poses, where a motion capture of its own stands between.
  void name_mocap(std::string topic) { mocap_topic_ = std::move(topic); }

  Status imu(const simulation::ImuSample& sample);
  Status mocap(const simulation::MocapSample& sample, double now_s);
  /// speed [rad/s] of each rotor.
  Status rotors(double t_s, std::span<const double> speed, std::span<const double> current, double alpha);
  Status battery(const simulation::BatterySample& sample);
  /// time_offset [s] is added to the plant's own time.
  Status truth(const simulation::Plant& plant, double time_offset = 0.0);
  Status frame(const simulation::SensorFrame& frame, const simulation::Plant& plant);
  /// Ends a control period: everything counted so far belongs to it.
  Status tick(double t_s, double period_s, FlightPhase phase);

  /// The last tick once more, for those who were not there yet.
  Status repeat_tick() {
    return tick_->publish(*tick_message_, bus::nanoseconds(tick_message_->header.stamp));
  }
  /// Subscriptions that every sensor topic has at least.
  std::uint32_t sensor_peers() const { return std::min(imu_->peers(), mocap_->peers()); }

  std::uint64_t ticks() const { return tick_message_->index; }
  const bus::Publisher<msgs::omniflight_msgs::Tick>& tick_publisher() const { return *tick_; }

 private:
  template <class T>
  using Slot = std::optional<bus::Publisher<T>>;
  Slot<msgs::sensor_msgs::Imu> imu_;
  Slot<msgs::geometry_msgs::PoseStamped> mocap_;
  Slot<msgs::omniflight_msgs::RotorTelemetry> rotor_;
  Slot<msgs::sensor_msgs::BatteryState> battery_;
  Slot<msgs::omniflight_msgs::Tick> tick_;
  Slot<msgs::omniflight_msgs::TruthState> truth_;
  /// Ticks tell how many samples belong to them. Boards fly in real time: there a sample that was lost, or
  /// sent before the controller listened, must not be waited for.
  bool counted_ = true;
  std::string mocap_topic_ = topics::mocap;
  bus::Message<msgs::sensor_msgs::Imu> imu_message_;
  bus::Message<msgs::geometry_msgs::PoseStamped> mocap_message_;
  bus::Message<msgs::omniflight_msgs::RotorTelemetry> rotor_message_;
  bus::Message<msgs::sensor_msgs::BatteryState> battery_message_;
  bus::Message<msgs::omniflight_msgs::Tick> tick_message_;
  bus::Message<msgs::omniflight_msgs::TruthState> truth_message_;
};

}  // namespace omniflight::components
