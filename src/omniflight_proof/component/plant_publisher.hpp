// What a plant publishes: sensor samples, true state, ticks with their counts. Publishing allocates nothing.
#pragma once

#include <functional>
#include <optional>

#include "omniflight_bus/publisher.hpp"
#include "omniflight_proof/plant.hpp"
#include "omniflight_proof/sensors.hpp"
#include "topics.hpp"

namespace omniflight::proof {

enum class Phase : std::uint8_t { held = 0, free = 1, ended = 2 };

inline std::int64_t to_ns(double t_s) { return std::llround(t_s * 1e9); }

class PlantPublisher {
 public:
  template <class T>
  using Slot = std::optional<bus::Publisher<T>>;

  /// advertise(slot, topic, qos) creates one publisher; the component counts what it sends.
  template <class Advertise>
  Status create(Advertise&& advertise, std::size_t rotors) {
    const bus::Qos deep = bus::Qos::bulk(512);
    for (Status ok :
         {advertise(imu_, topics::imu, deep), advertise(mocap_, topics::mocap, deep),
          advertise(rotor_, topics::rotors, deep), advertise(battery_, topics::battery, bus::Qos::bulk(64)),
          advertise(truth_, topics::truth, deep), advertise(tick_, topics::tick, deep)})
      if (!ok) return ok;
    prepare(rotors);
    return {};
  }
  void destroy();

  Status sensors(const SensorFrame& frame, const MujocoPlant& plant);
  Status truth(const MujocoPlant& plant);
  /// Ends a control period: every sample sent so far belongs to it.
  Status tick(double t, double period, Phase phase);
  Status repeat_tick();

  std::uint64_t ticks() const { return tick_message_->index; }
  /// Subscriptions that every topic the controller follows has at least.
  std::uint32_t peers() const { return std::min({tick_->peers(), imu_->peers(), mocap_->peers()}); }

 private:
  void prepare(std::size_t rotors);
  Slot<msgs::sensor_msgs::Imu> imu_;
  Slot<msgs::geometry_msgs::PoseStamped> mocap_;
  Slot<msgs::omniflight_msgs::RotorTelemetry> rotor_;
  Slot<msgs::sensor_msgs::BatteryState> battery_;
  Slot<msgs::omniflight_msgs::TruthState> truth_;
  Slot<msgs::omniflight_msgs::Tick> tick_;
  bus::Message<msgs::sensor_msgs::Imu> imu_message_;
  bus::Message<msgs::geometry_msgs::PoseStamped> mocap_message_;
  bus::Message<msgs::omniflight_msgs::RotorTelemetry> rotor_message_;
  bus::Message<msgs::sensor_msgs::BatteryState> battery_message_;
  bus::Message<msgs::omniflight_msgs::TruthState> truth_message_;
  bus::Message<msgs::omniflight_msgs::Tick> tick_message_;
};

}  // namespace omniflight::proof
