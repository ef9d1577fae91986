#include "family_laboratory.hpp"

#include <fmt/format.h>

#include <cmath>

namespace omniflight::proof {
namespace {

SensorConfig draw_sensors(const Coordinates& where, const FamilyVehicle& v, double step, BoxRandom& random) {
  SensorConfig c;
  const bool small = v.nominal.mass < 0.1;
  c.imu_rate = std::min(1 / step, std::max(500.0, where.imu_hz));
  c.accelerometer_noise = random.between_log(0.05, small ? 0.35 : 0.2);
  c.gyro_noise = random.between_log(0.002, small ? 0.012 : 0.006);
  c.mocap_rate = where.pose_hz;
  c.mocap_position_noise = random.between_log(1e-4, 5e-4);
  c.mocap_attitude_noise = random.between_log(5e-4, small ? 3e-3 : 1.5e-3);
  c.mocap_latency = step * std::round(random.between(0.004, 0.012) / step);
  c.mocap_dropout = 0.002;
  c.rotor_rate = where.speed_hz;
  c.half_period_quantisation = !small && random.chance(0.5);
  if (!c.half_period_quantisation) {
    const auto& r = v.nominal.rotors[0];
    c.rotor_noise = random.between_log(5e-4, 3e-3) * r.speed(v.weight() / v.nominal.rotor_count());
  }
  c.battery_rate = 10;
  c.battery_noise = 0.01;
  return c;
}

ControllerKind kind_of(const std::string& word) {
  return word == "cascade"   ? ControllerKind::cascade
         : word == "indi"    ? ControllerKind::indi
         : word == "sliding" ? ControllerKind::sliding
                             : ControllerKind::geometric;
}

void draw_controller(Laboratory& lab, const Coordinates& where, const std::string& decoy, BoxRandom& random) {
  FamilyFlight& f = lab.flight;
  f.flown.kind = kind_of(where.controller);
  f.flown.gains = draw_gains(f.vehicle, random);
  f.flown.feedforward = random.chance(0.75);
  f.flown.filter_hz = random.between(12, 20);
  if (decoy == "retuned controller") {
    f.flown.gains.kp *= 0.6, f.flown.gains.kv *= 0.8, f.flown.gains.ki *= 0.5;
    f.flown.gains.kR *= 0.65, f.flown.gains.kw *= 0.8;
  }
  f.told = f.flown;
  if (where.told_gains == "wrong") {  // an old sheet of gains: the controller does differ from what is told
    f.told.gains.kp *= random.between(1.2, 1.6);
    f.told.gains.kR *= random.between(0.6, 0.85);
    lab.present.emplace_back("controller_mismatch");
  }
  // told gains of a cascade are those of the same error terms; its integrals differ
  if (where.told_gains == "told" && where.controller == "cascade")
    lab.present.emplace_back("controller_mismatch");
  f.logging.commanded_attitude = !f.vehicle.fully_actuated && random.chance(0.5);
}

Turbulence draw_turbulence(const Coordinates& where, const FamilyVehicle& v, BoxRandom& random) {
  Turbulence t;
  t.kind = where.turbulence == "dryden"   ? Turbulence::Kind::dryden
           : where.turbulence == "heavy"  ? Turbulence::Kind::heavy
           : where.turbulence == "bursts" ? Turbulence::Kind::bursts
                                          : Turbulence::Kind::ou;
  t.force_rms = v.weight() * random.between(0.006, 0.016);
  t.torque_rms = v.weight() * v.arm() * random.between(0.003, 0.007);
  t.correlation_time = random.between_log(0.12, 0.8);
  return t;
}

}  // namespace

std::array<double, 6> residual_noise(const FamilyFlight& f, const Coordinates& where) {
  const vehicle::Vehicle& v = f.vehicle.nominal;
  const SensorConfig& s = f.sensors;
  std::array<double, 6> out{};
  const double block = where.imu() ? 0.02 : 0.1;
  const double n = std::max(1.0, block * (where.imu() ? where.imu_hz : where.pose_hz));
  const double acceleration = where.imu() ? s.accelerometer_noise / std::sqrt(n)
                                          : s.mocap_position_noise * std::sqrt(6 / n) / (block * block);
  const double turning = where.imu() ? s.gyro_noise * std::sqrt(2 / n) / block
                                     : s.mocap_attitude_noise * std::sqrt(6 / n) / (block * block);
  const auto rotors = static_cast<double>(v.rotor_count());
  const double thrust = f.vehicle.weight() / rotors, speed = v.rotors[0].speed(thrust);
  const double of_thrust = where.speed() ? 2 * thrust * s.rotor_noise / speed * std::sqrt(rotors) /
                                               std::sqrt(std::max(1.0, block * where.speed_hz))
                                         : 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto k = static_cast<int>(c);
    out[c] = std::hypot(v.mass * acceleration, (f.vehicle.fully_actuated ? 0.5
                                                : c == 2                 ? 1.0
                                                                         : 0.0) *
                                                   of_thrust);
    const double lever = c == 2 ? v.rotors[0].drag_ratio : 0.6 * f.vehicle.arm();
    out[c + 3] = std::hypot(v.inertia(k, k) * turning, lever * of_thrust);
  }
  return out;
}

Laboratory draw_laboratory(const Coordinates& where, const FamilyVehicle& vehicle, const std::string& decoy,
                           double vigour, BoxRandom& random) {
  Laboratory lab;
  FamilyFlight& f = lab.flight;
  f.vehicle = vehicle;
  f.step = where.imu_hz > 500 ? 0.001 : 0.002;
  f.world.timestep = 0.001;
  f.seed = random.bits() >> 12;
  f.sensors = draw_sensors(where, vehicle, f.step, random);
  f.logging.imu = where.imu();
  f.logging.imu_every = std::max(1, static_cast<int>(std::lround(f.sensors.imu_rate / where.imu_hz)));
  f.logging.speed = where.speed();
  f.logging.duty = where.duty();
  f.logging.command = !where.duty();
  f.logging.command_hz = std::min(where.speed_hz, 250.0);
  f.logging.reference = where.reference;
  f.logging.reasons = where.reference && random.chance(0.5);
  f.logging.battery = random.chance(0.3);
  f.lead = where.start == "rest" ? 0 : random.between(6, 9);
  f.path = family_path(where, vehicle, f.lead, vigour * (decoy == "quick flight" ? 1.4 : 1.0), random);
  if (where.start == "segments") {
    const int count = 1 + static_cast<int>(random.index(where.length > 40 ? 4 : 2));
    for (int k = 0; k < count; ++k) {
      const double at = where.length * (k + random.between(0.35, 0.65)) / (count + 0.4);
      f.logging.gaps.push_back({at, at + random.between(0.4, 3)});
    }
  }
  f.world.turbulence = draw_turbulence(where, vehicle, random);
  f.world.tilt.time_constant = vehicle.servo_lag;
  f.world.tilt.backlash = vehicle.servo_backlash;
  if (where.noise == "coloured") f.world.sensors.noise_correlation_time = random.between(0.003, 0.012);
  if (where.noise == "outliers") f.world.sensors.outlier_share = random.between(0.002, 0.01);
  draw_controller(lab, where, decoy, random);
  lab.told_sensors = f.sensors;
  lab.told_turbulence = *f.world.turbulence;
  lab.sensor_noise = residual_noise(f, where);
  if (decoy == "noisy sensors") {
    f.sensors.accelerometer_noise *= 2.5, f.sensors.gyro_noise *= 2.5;
    f.sensors.mocap_position_noise *= 2.5, f.sensors.mocap_attitude_noise *= 2;
  } else if (decoy == "slow turbulence") {
    f.world.turbulence->correlation_time = 2;
  } else if (decoy == "strong turbulence") {
    f.world.turbulence->force_rms *= 2, f.world.turbulence->torque_rms *= 2;
  }
  if (where.calibration != "exact") {
    const bool told = where.calibration == "told";
    lab.calibration = {random.between_log(5e-4, told ? 6e-3 : 2e-3),
                       random.between_log(2e-4, told ? 4e-3 : 1.5e-3),
                       random.between_log(3e-4, told ? 4e-3 : 2e-3), random.between_log(0.005, 0.03),
                       random.between_log(3e-4, 2e-3)};
  }
  lab.noise_told = where.calibration != "not told" || random.chance(0.5);
  return lab;
}

void leave_uncalibrated(Laboratory& lab, BoxRandom& random) {
  FamilyFlight& f = lab.flight;
  const Calibration& c = lab.calibration;
  if (c.thrust_scale > 0) {
    RotorChange all;
    all.rotor = 0;
    all.thrust_scale = 1 + c.thrust_scale * std::clamp(random.normal(), -2.5, 2.5);
    f.world.rotors.insert(f.world.rotors.begin(), all);
  }
  for (int k = 0; k < 3; ++k) {
    f.world.body.com_shift_B[k] += f.vehicle.arm() * c.trim * random.normal();
    f.sensors.accelerometer_bias[k] = c.accelerometer * random.normal();
    f.sensors.gyro_bias[k] = c.gyro * random.normal();
    if (k < 2) f.world.sensors.mocap_rotation_W[k] += c.level * random.normal();
  }
}

std::string told_yaml(const Laboratory& lab, const Coordinates& where) {
  const auto gain = [](const Vec3& v) {
    return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v.x(), v.y(), v.z());
  };
  std::string out = fmt::format("rates_hz: {{mocap: {:.6g}", where.pose_hz);
  if (where.imu()) out += fmt::format(", imu: {:.6g}", where.imu_hz);
  if (where.speed()) out += fmt::format(", rotor_speed: {:.6g}", where.speed_hz);
  out += "}\n";
  const SensorConfig& s = lab.told_sensors;
  const bool tolerances = where.calibration != "not told";
  const Calibration& c = lab.calibration;
  if (lab.noise_told) {
    out += "sensors:\n";
    if (where.imu()) {
      out += fmt::format("  accelerometer: {{noise_rms_mps2: {:.4g}", s.accelerometer_noise);
      if (tolerances) out += fmt::format(", bias_mps2: {:.4g}", std::max(1e-3, c.accelerometer));
      out += fmt::format("}}\n  gyro: {{noise_rms_radps: {:.4g}", s.gyro_noise);
      if (tolerances) out += fmt::format(", bias_radps: {:.4g}", std::max(1e-4, c.gyro));
      out += "}\n";
    }
    out += fmt::format("  mocap: {{position_noise_m: {:.4g}, attitude_noise_rad: {:.4g}}}\n",
                       s.mocap_position_noise, s.mocap_attitude_noise);
    if (where.speed() && s.half_period_quantisation)
      out += "  rotor_speed: {method: half_period, tick_us: 1}\n";
    out += fmt::format(
        "ambient: {{turbulence_force_rms_N: {:.4g}, turbulence_torque_rms_Nm: {:.4g}, correlation_time_s: "
        "{:.4g}}}\n",
        lab.told_turbulence.force_rms, lab.told_turbulence.torque_rms, lab.told_turbulence.correlation_time);
  }
  if (where.told_gains != "not told") {
    const Gains& g = lab.flight.told.gains;
    out += "controller:\n  kp: " + gain(g.kp) + "\n  kv: " + gain(g.kv) + "\n  ki: " + gain(g.ki) +
           "\n  kR: " + gain(g.kR) + "\n  kw: " + gain(g.kw) + "\n  kI: " + gain(g.kI) + "\n";
  }
  if (tolerances)
    out += fmt::format("tolerance: {{thrust_scale: {:.4g}, world_force: {:.4g}, torque_trim: {:.4g}}}\n",
                       std::max(1e-4, c.thrust_scale), std::max(1e-4, c.level), std::max(1e-4, c.trim));
  out +=
      fmt::format("environment: {{floor_z_m: {:.4g}, air_density_kgpm3: 1.2}}\n", lab.flight.world.floor_z);
  return out;
}

}  // namespace omniflight::proof
