#include "plant_publisher.hpp"

namespace omniflight::proof {
namespace {

template <class M>
void put(M& field, const Vec3& v) {
  field.x = v.x();
  field.y = v.y();
  field.z = v.z();
}

}  // namespace

void PlantPublisher::prepare(std::size_t rotors) {
  bus::resize(rotor_message_->velocity, rotors);
  bus::resize(truth_message_->rotor_velocity, rotors);
  bus::set_text(imu_message_->header.frame_id, "base_link");
  bus::set_text(mocap_message_->header.frame_id, "map");
  bus::set_text(truth_message_->header.frame_id, "map");
  imu_message_->orientation_covariance[0] = -1.0;  // no orientation
}

void PlantPublisher::destroy() {
  imu_.reset();
  mocap_.reset();
  rotor_.reset();
  battery_.reset();
  truth_.reset();
  tick_.reset();
}

Status PlantPublisher::sensors(const SensorFrame& f, const MujocoPlant& plant) {
  if (f.imu) {
    const std::int64_t ns = to_ns(f.imu_sample.t);
    imu_message_->header.stamp = bus::stamp(ns);
    put(imu_message_->linear_acceleration, f.imu_sample.specific_force_B);
    put(imu_message_->angular_velocity, f.imu_sample.gyro_B);
    ++tick_message_->imu_count;
    if (auto ok = imu_->publish(*imu_message_, ns); !ok) return ok;
  }
  if (f.mocap) {
    const MocapSample& s = f.mocap_sample;
    mocap_message_->header.stamp = bus::stamp(to_ns(s.t));
    put(mocap_message_->pose.position, s.p_WB);
    auto& q = mocap_message_->pose.orientation;
    q.x = s.q_WB.x();
    q.y = s.q_WB.y();
    q.z = s.q_WB.z();
    q.w = s.q_WB.w();
    ++tick_message_->mocap_count;
    if (auto ok = mocap_->publish(*mocap_message_, to_ns(plant.time())); !ok) return ok;
  }
  if (f.rotor) {
    const std::int64_t ns = to_ns(f.rotor_sample.t);
    rotor_message_->header.stamp = bus::stamp(ns);
    rotor_message_->seq = tick_message_->rotor_count++;
    bus::assign(rotor_message_->velocity, {f.rotor_sample.speed.data(), plant.rotor_speed().size()});
    rotor_message_->alpha = f.rotor_sample.alpha;
    if (auto ok = rotor_->publish(*rotor_message_, ns); !ok) return ok;
  }
  if (f.battery) {
    const std::int64_t ns = to_ns(f.battery_sample.t);
    battery_message_->header.stamp = bus::stamp(ns);
    battery_message_->voltage = static_cast<float>(f.battery_sample.voltage);
    battery_message_->current =
        static_cast<float>(-f.battery_sample.current);  // ROS: negative while discharging
    battery_message_->present = true;
    if (auto ok = battery_->publish(*battery_message_, ns); !ok) return ok;
  }
  return {};
}

Status PlantPublisher::truth(const MujocoPlant& plant) {
  auto& m = *truth_message_;
  const RigidState& s = plant.body();
  const std::int64_t ns = to_ns(plant.time());
  m.header.stamp = bus::stamp(ns);
  for (int k = 0; k < 3; ++k) {
    m.position[k] = s.p_WB[k];
    m.velocity[k] = s.v_WB_W[k];
    m.angular_velocity[k] = s.w_WB_B[k];
    m.attitude[k + 1] = s.q_WB.vec()[k];
  }
  m.attitude[0] = s.q_WB.w();
  bus::assign(m.rotor_velocity, plant.rotor_speed());
  m.alpha = plant.true_alpha();
  m.mechanical_power = plant.mechanical_power();
  const Vec6 wrench = plant.unmodelled_wrench();
  std::copy_n(wrench.data(), 6, m.external_wrench);
  return truth_->publish(m, ns);
}

Status PlantPublisher::tick(double t, double period, Phase phase) {
  tick_message_->header.stamp = bus::stamp(to_ns(t));
  tick_message_->period = period;
  tick_message_->phase = static_cast<std::uint8_t>(phase);
  ++tick_message_->index;
  return tick_->publish(*tick_message_, to_ns(t));
}

Status PlantPublisher::repeat_tick() {
  return tick_->publish(*tick_message_, bus::nanoseconds(tick_message_->header.stamp));
}

}  // namespace omniflight::proof
