#include "plant_publisher.hpp"

#include "conversions.hpp"

namespace omniflight::components {

void PlantPublisher::destroy() {
  imu_.reset();
  mocap_.reset();
  rotor_.reset();
  battery_.reset();
  tick_.reset();
  truth_.reset();
}

Status PlantPublisher::imu(const simulation::ImuSample& s) {
  imu_message_->header.stamp = bus::stamp(to_ns(s.t));
  put(imu_message_->linear_acceleration, s.specific_force_B);
  put(imu_message_->angular_velocity, s.gyro_B);
  tick_message_->imu_count += counted_;
  return imu_->publish(*imu_message_, to_ns(s.t));
}

Status PlantPublisher::mocap(const simulation::MocapSample& s, double now_s) {
  mocap_message_->header.stamp = bus::stamp(to_ns(s.t));
  put(mocap_message_->pose.position, s.p_WB);
  put_quaternion(mocap_message_->pose.orientation, s.q_WB);
  tick_message_->mocap_count += counted_;
  return mocap_->publish(*mocap_message_, to_ns(now_s));
}

Status PlantPublisher::rotors(double t_s, std::span<const double> speed, std::span<const double> current,
                              double alpha) {
  rotor_message_->header.stamp = bus::stamp(to_ns(t_s));
  rotor_message_->seq = tick_message_->rotor_count++;
  bus::assign(rotor_message_->velocity, speed);
  bus::assign(rotor_message_->current, current);
  rotor_message_->alpha = alpha;
  return rotor_->publish(*rotor_message_, to_ns(t_s));
}

Status PlantPublisher::battery(const simulation::BatterySample& s) {
  battery_message_->header.stamp = bus::stamp(to_ns(s.t));
  battery_message_->voltage = static_cast<float>(s.voltage);
  battery_message_->current = static_cast<float>(-s.current);  // ROS: negative while discharging
  battery_message_->present = true;
  return battery_->publish(*battery_message_, to_ns(s.t));
}

Status PlantPublisher::truth(const simulation::Plant& plant, double time_offset) {
  auto& m = *truth_message_;
  const std::int64_t ns = to_ns(plant.time() + time_offset);
  m.header.stamp = bus::stamp(ns);
  put(m.position, plant.body().p_WB);
  put(m.attitude, plant.body().q_WB);
  put(m.velocity, plant.body().v_WB_W);
  put(m.angular_velocity, plant.body().w_WB_B);
  bus::assign(m.rotor_velocity, plant.rotor_speed());
  m.alpha = plant.alpha();
  m.mechanical_power = plant.mechanical_power();
  put(m.external_wrench, plant.effect_wrench());
  return truth_->publish(m, ns);
}

Status PlantPublisher::frame(const simulation::SensorFrame& f, const simulation::Plant& plant) {
  Status status;
  const auto run = [&](bool due, auto&& publish) {
    if (due && status) status = publish();
  };
  run(f.imu, [&] { return imu(f.imu_sample); });
  run(f.mocap, [&] { return mocap(f.mocap_sample, plant.time()); });
  run(f.rotor, [&] {
    const auto n = static_cast<std::size_t>(plant.vehicle().rotor_count());
    return rotors(f.rotor_sample.t, {f.rotor_sample.speed.data(), n}, {}, f.rotor_sample.alpha);
  });
  run(f.battery, [&] { return battery(f.battery_sample); });
  return status;
}

Status PlantPublisher::tick(double t_s, double period_s, FlightPhase phase) {
  tick_message_->header.stamp = bus::stamp(to_ns(t_s));
  tick_message_->period = period_s;
  tick_message_->phase = static_cast<std::uint8_t>(phase);
  ++tick_message_->index;
  return tick_->publish(*tick_message_, to_ns(t_s));
}

}  // namespace omniflight::components
