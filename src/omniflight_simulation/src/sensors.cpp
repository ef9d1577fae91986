#include "omniflight_simulation/sensors.hpp"

#include <algorithm>
#include <cmath>

#include "imu.hpp"
#include "omniflight_core/half_period.hpp"

namespace omniflight::simulation {
namespace {

/// The steps nearest to the instants k / rate, none early: the mean rate is exact for every rate.
class Schedule {
 public:
  Schedule(double rate, double step) : steps_(std::max(1.0, 1.0 / (rate * step))) {}
  bool due(std::uint64_t step) {
    if (static_cast<double>(step) < std::ceil(static_cast<double>(next_) * steps_ - 1e-6)) return false;
    ++next_;
    return true;
  }

 private:
  double steps_;
  std::uint64_t next_ = 0;
};

/// Motion capture: poses that arrive later, or not at all.
class Mocap {
 public:
  Mocap(const SensorConfig& config, const physics::Sensing& sensing, double step, std::uint64_t seed)
      : config_(config),
        sensing_(sensing),
        schedule_(config.mocap_rate, step),
        random_(seed, "mocap"),
        stale_random_(seed, "mocap stale"),
        latency_(static_cast<std::uint64_t>(std::llround(config.mocap_latency / step))) {
    in_flight_.resize(static_cast<std::size_t>(config.mocap_latency * config.mocap_rate) + 4);
  }

  bool sample(const Plant& plant, std::uint64_t step, MocapSample& out) {
    if (schedule_.due(step)) expose(plant, step);
    if (tail_ == head_ || in_flight_[tail_ % in_flight_.size()].arrival > step) return false;
    out = in_flight_[tail_++ % in_flight_.size()].sample;
    return true;
  }

 private:
  Vec3 normal3(double scale) { return scale * Vec3(random_.normal(), random_.normal(), random_.normal()); }

  void expose(const Plant& plant, std::uint64_t step) {
    const RigidState& body = plant.body();
    const Quat tilt = exp_rotation(sensing_.mocap_tilt);
    Delayed d;
    d.arrival = step + latency_;
    // the pose of (1 + skew) t + offset is stamped t
    d.sample.t = (plant.time() - sensing_.mocap_clock_offset) / (1 + sensing_.mocap_clock_skew);
    d.sample.p_WB =
        tilt * (body.p_WB + body.q_WB * sensing_.mocap_offset) + normal3(config_.mocap_position_noise);
    d.sample.q_WB = tilt * body.q_WB * exp_rotation(sensing_.mocap_misalignment) *
                    exp_rotation(normal3(config_.mocap_attitude_noise));
    if (config_.mocap_stamp_jitter > 0) d.sample.t += config_.mocap_stamp_jitter * random_.normal();
    if (sensing_.stale_mocap > 0 && stale_random_.uniform() < sensing_.stale_mocap && exposed_) {
      d.sample.p_WB = last_.p_WB;
      d.sample.q_WB = last_.q_WB;
    }
    last_ = d.sample;
    exposed_ = true;
    if (!lost()) in_flight_[head_++ % in_flight_.size()] = d;
  }

  /// Gaps begin and end at random, so that a share `mocap_dropout` of the frames is missing in gaps of
  /// `mocap_dropout_length` frames on average.
  bool lost() {
    const double p = config_.mocap_dropout, draw = random_.uniform();
    if (config_.mocap_dropout_length <= 1) return draw < p;
    const double end = 1 / config_.mocap_dropout_length;
    in_gap_ = in_gap_ ? draw >= end : draw < end * p / (1 - p);
    return in_gap_;
  }

  struct Delayed {
    std::uint64_t arrival = 0;
    MocapSample sample;
  };
  SensorConfig config_;
  physics::Sensing sensing_;
  Schedule schedule_;
  Random random_, stale_random_;
  std::uint64_t latency_;
  std::vector<Delayed> in_flight_;  ///< a ring of poses that have not arrived
  std::size_t head_ = 0, tail_ = 0;
  MocapSample last_;
  bool exposed_ = false, in_gap_ = false;
};

physics::Sensing sensing_of(const physics::Model& model) {
  physics::Sensing sensing;
  for (const auto& e : model.effects) e.effect->alter_sensing(e.theta.data(), sensing);
  return sensing;
}

}  // namespace

struct SensorSuite::Impl {
  SensorConfig config;
  physics::Sensing sensing;
  double step;
  Imu imu;
  Mocap mocap;
  Schedule imu_due, rotor_due, battery_due;
  Random rotor_random, battery_random;
  std::uint64_t count = 0;
  double energy = 0;  ///< J drawn so far
  double frozen_speed = 0;
  bool frozen = false;

  Impl(const SensorConfig& c, const physics::Sensing& s, double h, std::uint64_t seed)
      : config(c),
        sensing(s),
        step(h),
        imu(c, s, h, seed),
        mocap(c, s, h, seed),
        imu_due(c.imu_rate, h),
        rotor_due(c.rotor_rate, h),
        battery_due(c.battery_rate, h),
        rotor_random(seed, "rotor"),
        battery_random(seed, "battery") {}

  double board_time(double t) const { return (1 + config.board_clock_skew) * t + config.board_clock_offset; }

  void rotors(const Plant& plant, RotorSample& out) {
    out.t = board_time(plant.time());
    out.alpha = plant.alpha();
    const auto speeds = plant.rotor_speed();
    for (std::size_t i = 0; i < speeds.size(); ++i) {
      double s = speeds[i] + config.rotor_noise * rotor_random.normal();
      if (config.half_period_quantisation) s = speed_from_half_period(half_period_from_speed(s));
      if (static_cast<int>(i) == sensing.rotor_fault) {
        s = (1 + sensing.rotor_fault_scale) * s + sensing.rotor_fault_bias;
        if (plant.time() >= sensing.rotor_fault_freeze) {
          if (!frozen) frozen_speed = s, frozen = true;
          s = frozen_speed;
        }
      }
      out.speed[i] = s;
    }
  }

  void battery(const Plant& plant, double electrical, BatterySample& out) {
    const double open =
        std::max(1.0, config.battery_voltage - (config.battery_sag + sensing.battery_drop) * energy);
    const double current = electrical / open;
    const double volts = open - (config.battery_resistance + sensing.battery_resistance) * current;
    out.t = board_time(plant.time());
    out.voltage = (1 + sensing.voltage_scale) * volts + sensing.voltage_bias;
    if (config.battery_noise > 0) out.voltage += config.battery_noise * battery_random.normal();
    out.current = (1 + sensing.current_scale) * current;
  }
};

SensorSuite::SensorSuite(const SensorConfig& config, const physics::Model& model, double step,
                         std::uint64_t seed)
    : impl_(std::make_unique<Impl>(config, sensing_of(model), step, seed)) {}
SensorSuite::SensorSuite(SensorSuite&&) noexcept = default;
SensorSuite& SensorSuite::operator=(SensorSuite&&) noexcept = default;
SensorSuite::~SensorSuite() = default;

void SensorSuite::sample(const Plant& plant, SensorFrame& frame) {
  Impl& m = *impl_;
  const double electrical = plant.mechanical_power() / m.config.drive_efficiency;
  if (m.count > 0) m.energy += electrical * m.step;
  m.imu.follow(plant);
  frame.imu = m.imu_due.due(m.count);
  if (frame.imu) {
    m.imu.sample(frame.imu_sample);
    frame.imu_sample.t = m.board_time(plant.time());
  }
  frame.mocap = m.mocap.sample(plant, m.count, frame.mocap_sample);
  frame.rotor = m.rotor_due.due(m.count);
  if (frame.rotor) m.rotors(plant, frame.rotor_sample);
  frame.battery = m.battery_due.due(m.count);
  if (frame.battery) m.battery(plant, electrical, frame.battery_sample);
  ++m.count;
}

}  // namespace omniflight::simulation
