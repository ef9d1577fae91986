// Faults on a schedule: what breaks when in a simulated flight, read from a YAML file.
//
//   schema: omniflight.faults/1
//   faults:
//     - {at_s: 10, kind: rotor_loss, rotor: 3}
//     - {at_s: 12, kind: sensor_freeze, sensor: mocap, for_s: 0.5}
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "omniflight_simulation/plant.hpp"
#include "omniflight_simulation/sensors.hpp"

namespace omniflight::simulation {

enum class FaultKind {
  rotor_loss,     ///< a rotor has no power; its speed decays with its lag
  stuck_rotor,    ///< a rotor turns at one speed whatever is commanded
  sensor_freeze,  ///< a sensor repeats its last sample under new stamps
  sensor_loss,    ///< a sensor is silent
  gust,           ///< a force and torque that swell and die down as 1 - cos
  rope_snag,      ///< a rope that hangs from the vehicle is caught where it is now
};
enum class FaultySensor { imu, mocap, rotor_speed, battery };

struct Fault {
  FaultKind kind = FaultKind::rotor_loss;
  double at = 0;                                              ///< s of simulated time, hold included
  double duration = std::numeric_limits<double>::infinity();  ///< s; rotor faults may last for ever
  std::size_t rotor = 0;                                      ///< index from 0 (the file counts from 1)
  double speed = std::numeric_limits<double>::quiet_NaN();    ///< rad/s of a stuck rotor; NaN: as it is then
  FaultySensor sensor = FaultySensor::imu;
  Vec3 force_W = Vec3::Zero();   ///< N, peak of a gust, world axes, at the body origin
  Vec3 torque_B = Vec3::Zero();  ///< Nm, peak, body axes
  Vec3 point_B = Vec3::Zero();   ///< m, where the rope is tied to the vehicle
  double slack = 0;              ///< m of rope between that point and where it is caught
  double stiffness = 0;          ///< N/m
  double damping = 0;            ///< N s/m, while the rope is taut
};

/// Reads a schedule for a vehicle with that many rotors. Refuses unknown kinds and fields, times and rotors
/// out of range, and two faults of the same rotor, sensor or rope at the same time; errors name file, line,
/// field and unit.
Result<std::vector<Fault>> load_faults(const std::string& path, int rotor_count);
Result<std::vector<Fault>> read_faults(files::YamlReader yaml, int rotor_count);
std::string to_string(FaultKind kind);

/// Carries a schedule out. Each fault begins with the first step at or after its time and lasts exactly so
/// many steps; nothing is allocated while flying. Must outlive the plant's use of it and stay where it is.
class FaultInjector final : public Disturbance {
 public:
  explicit FaultInjector(std::vector<Fault> faults);
  FaultInjector(const FaultInjector&) = delete;
  FaultInjector& operator=(const FaultInjector&) = delete;

  /// Before every step of the plant.
  void before_step(Plant& plant);
  /// After every SensorSuite::sample, at the same instant.
  void alter(double t, SensorFrame& frame);
  void add_wrench(const physics::Situation& situation, physics::Wrench& out) const override;
  const std::vector<Fault>& faults() const { return faults_; }
  /// Faults that have begun by the last before_step, and not ended.
  std::size_t active() const;

 private:
  struct Progress {
    bool begun = false, ended = false;
    Vec3 caught_W = Vec3::Zero();  ///< m, where the rope is held
  };
  bool acts(const Fault& fault, FaultySensor sensor, double t) const;

  std::vector<Fault> faults_;
  std::vector<Progress> progress_;
  SensorFrame last_;
  bool seen_[4] = {false, false, false, false};
};

}  // namespace omniflight::simulation
