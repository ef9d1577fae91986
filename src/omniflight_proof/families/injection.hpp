// Effects injected into recordings of real flights. The motion stays as it was flown; a force along body z
// and torques are added by the rotor speeds that would have held that motion against them. Noise, sensors and
// unmodelled physics are real, the effect is hidden.
#pragma once

#include <functional>

#include "case_shape.hpp"
#include "family.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::proof {

/// What is held against an injection: speeds, motion and noise of the real flight on the time base of its
/// rotor speeds.
class RealFlight {
 public:
  /// Refuses recordings without rotor speeds, gyroscope, accelerometer, pose, or of less than 8 s in the air.
  static Result<RealFlight> create(recording::Recording recording, const vehicle::Vehicle& vehicle);

  const recording::Recording& recording() const { return recording_; }
  const vehicle::Vehicle& vehicle() const { return vehicle_; }
  std::size_t size() const { return t_.size(); }
  double period() const { return period_; }
  double time(std::size_t i) const { return t_[i]; }
  bool flying(std::size_t i) const { return flying_[i]; }
  Vec3 position(std::size_t i) const { return position_.row(static_cast<Eigen::Index>(i)).transpose(); }
  Mat3 R(std::size_t i) const { return attitude_[i].toRotationMatrix(); }
  Vec3 force(std::size_t i) const { return force_.row(static_cast<Eigen::Index>(i)).transpose(); }
  Vec3 rate(std::size_t i) const { return rate_.row(static_cast<Eigen::Index>(i)).transpose(); }
  Vec3 turning(std::size_t i) const { return turning_.row(static_cast<Eigen::Index>(i)).transpose(); }
  vehicle::RotorVector thrust(std::size_t i) const;
  double speed(std::size_t i, int k) const { return speed_(static_cast<Eigen::Index>(i), k); }
  double floor() const { return floor_; }
  /// Standard deviation of the nominal wrench residual in blocks of 20 ms: Fz, Mx, My, Mz; Fx and Fy are not
  /// judged.
  const std::array<double, 6>& noise() const { return noise_; }

 private:
  recording::Recording recording_;
  vehicle::Vehicle vehicle_;
  std::vector<double> t_;
  std::vector<char> flying_;
  Eigen::MatrixXd position_, force_, rate_, turning_, speed_;
  std::vector<Quat> attitude_;
  double period_ = 0, floor_ = 0;
  std::array<double, 6> noise_{};
};

/// What can be injected: force along body z and torque that the world exerts, for an amplitude in the
/// vehicle's measure.
struct Injectable {
  std::string id, realisation;
  bool law = true, unseen = false;
  double smallest = 1e-4, typical = 0.05, largest = 0.3;
  /// Fz, Mx, My, Mz at sample i.
  std::function<Eigen::Vector4d(const RealFlight&, std::size_t i, double a, const Shape&)> wrench = {};
  std::function<std::vector<TrueParameter>(const RealFlight&, double a, const Shape&)> parameters = {};
  std::vector<std::string> variables = {};
};
const std::vector<Injectable>& injectables();

struct Injected {
  recording::Recording recording;
  std::array<double, 6> rms{};  ///< N, N m of what the rotors counter
  double sigma = 0;
  std::string channel;
  double limited = 0;  ///< share of samples at which a rotor would leave its range
};

/// Rotor speeds: least change of thrusts, first-order motor lag, whole steps of what the log resolves. Duty
/// cycles and commands lead by the lag.
Injected inject(const RealFlight& flight, const Injectable& what, double amplitude, const Shape& shape);

}  // namespace omniflight::proof
