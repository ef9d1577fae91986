#include "thrust_source.hpp"

#include <algorithm>
#include <cmath>

#include "../numerics/text.hpp"
#include "rotor_limits.hpp"

namespace omniflight::diagnosis {
namespace {

/// Speeds [rad/s] that assume the largest speed at full duty and mean voltage; the scale is calibrated later.
recording::Signal from_duty(const recording::Signal& duty, const recording::Signal* voltage,
                            const vehicle::Vehicle& vehicle) {
  recording::Signal out = duty;
  Eigen::VectorXd relative = Eigen::VectorXd::Ones(duty.size());
  if (voltage && voltage->size() > 1) {
    const double mean = voltage->values.mean();
    const Eigen::MatrixXd v = recording::resample(*voltage, duty.t_s);
    for (Eigen::Index i = 0; i < v.rows(); ++i)
      if (std::isfinite(v(i, 0)) && mean > 0) relative[i] = std::clamp(v(i, 0) / mean, 0.3, 3.0);
  }
  for (Eigen::Index r = 0; r < out.width(); ++r) {
    const double top = vehicle.rotors[static_cast<std::size_t>(r)].max_speed();
    for (Eigen::Index i = 0; i < out.size(); ++i)
      out.values(i, r) = top * std::pow(std::max(0.0, duty.values(i, r)) * relative[i], kDutyToSpeed);
  }
  return out;
}

}  // namespace

std::optional<ThrustSource> thrust_source(const recording::Recording& r, const vehicle::Vehicle& vehicle) {
  ThrustSource out;
  const auto fits = [&](const recording::Signal* s) { return s && s->width() == vehicle.rotor_count(); };
  if (const auto* s = r.find("rotor_speed"); fits(s)) {
    out.speed = *s;
    if (const auto slowest = fill_slow_readings(r, vehicle, out.speed))
      out.note = format(
          "The telemetry reads no rotor slower than %.3g rad/s: such rotors are taken to follow "
          "their commands.",
          *slowest);
    return out;
  }
  if (const auto* s = r.find("rotor_command"); fits(s)) {
    out.kind = SpeedSource::commanded;
    out.speed = *s;
    out.note =
        "No rotor speeds: they are computed from the commands with the vehicle's time constants, so that "
        "what alters the drives is told by the wrench alone.";
    return out;
  }
  out.kind = SpeedSource::modelled;
  const auto* vbat = r.find("vbat");
  if (const auto* s = r.find("thrust_model"); fits(s)) {
    out.speed = *s;
    for (Eigen::Index k = 0; k < s->width(); ++k)
      for (Eigen::Index i = 0; i < s->size(); ++i)
        out.speed.values(i, k) =
            vehicle.rotors[static_cast<std::size_t>(k)].speed(std::max(0.0, s->values(i, k)));
    out.note = "No rotor speeds: thrust is the vehicle's own model of it; ";
  } else if (const auto* u = r.find("pwm"); fits(u)) {
    out.speed = from_duty(*u, vbat, vehicle);
    out.note = vbat ? "No rotor speeds: thrust is modelled from duty cycle and battery voltage; "
                    : "No rotor speeds and no battery voltage: thrust is modelled from the duty cycle; ";
  } else if (const auto* m = r.find("motor_power"); fits(m)) {
    out.speed = from_duty(*m, nullptr, vehicle);
    for (Eigen::Index k = 0; k < m->width(); ++k)  // commanded power is proportional to thrust
      for (Eigen::Index i = 0; i < m->size(); ++i)
        out.speed.values(i, k) = vehicle.rotors[static_cast<std::size_t>(k)].max_speed() *
                                 std::sqrt(std::max(0.0, m->values(i, k)));
    out.note = "No rotor speeds: thrust is modelled from the commanded power; ";
  } else {
    return std::nullopt;
  }
  out.note +=
      "its scale is taken from this flight, so mass and thrust scale cannot be told, and torques are known "
      "within "
      "the difference of the motors only.";
  return out;
}

}  // namespace omniflight::diagnosis
