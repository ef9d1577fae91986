#include "family_log.hpp"

#include <cmath>

namespace omniflight::proof {

bool FamilyLog::off(double now) const {
  const double t = now - begin_;
  if (t < 0) return true;
  return std::any_of(what_.gaps.begin(), what_.gaps.end(),
                     [&](const Gap& g) { return t >= g.from && t < g.until; });
}

void FamilyLog::put(const char* name, double t, const double* values, std::size_t width, double resolution) {
  Column& c = columns_[name];
  c.width = width;
  const double when = std::round((t - begin_) * 1e6) / 1e6;
  if (when < 0 || (!c.t.empty() && when <= c.t.back())) return;
  c.t.push_back(when);
  const double per = std::round(1 / resolution);
  for (std::size_t k = 0; k < width; ++k) c.values.push_back(std::round(values[k] * per) / per);
}

bool FamilyLog::due(double& next, double now, double rate) const {
  if (now + 1e-9 < next) return false;
  if (next < now - 1) next = now;
  next += 1 / rate;
  return true;
}

void FamilyLog::sensors(double now, const SensorFrame& f) {
  const bool nothing = off(now);
  const auto rotors = static_cast<std::size_t>(vehicle_.rotor_count());
  if (f.imu && imu_count_++ % what_.imu_every == 0 && what_.imu && !nothing) {
    put("acc", f.imu_sample.t, f.imu_sample.specific_force_B.data(), 3, 1e-4);
    put("gyro", f.imu_sample.t, f.imu_sample.gyro_B.data(), 3, 1e-5);
  }
  if (nothing) return;
  if (f.mocap) {
    const Quat& q = f.mocap_sample.q_WB;
    const double wxyz[] = {q.w(), q.x(), q.y(), q.z()};
    put("position", f.mocap_sample.t, f.mocap_sample.p_WB.data(), 3, 1e-6);
    put("attitude", f.mocap_sample.t, wxyz, 4, 1e-6);
  }
  if (f.rotor && what_.speed) put("rotor_speed", f.rotor_sample.t, f.rotor_sample.speed.data(), rotors, 1e-2);
  if (f.rotor && vehicle_.tilt.kind != vehicle::TiltKind::none)
    put("alpha", f.rotor_sample.t, &f.rotor_sample.alpha, 1, 1e-5);
  if (f.battery && what_.battery) {
    put("vbat", f.battery_sample.t, &f.battery_sample.voltage, 1, 1e-3);
    put("ibat", f.battery_sample.t, &f.battery_sample.current, 1, 1e-3);
  }
}

void FamilyLog::reasons(double now, const Reference& r, const ControlOutput& u,
                        const std::vector<double>& speeds, const vehicle::RotorVector& thrust) {
  if (off(now)) return;
  const auto rotors = static_cast<std::size_t>(vehicle_.rotor_count());
  if ((what_.command || what_.duty) && due(next_command_, now, what_.command_hz)) {
    if (what_.duty) {
      std::array<double, vehicle::kMaxRotors> duty{};
      for (std::size_t i = 0; i < rotors; ++i)
        duty[i] = std::pow(std::max(0.0, thrust[static_cast<int>(i)]) / vehicle_.rotors[i].max_thrust,
                           1 / what_.duty_exponent);
      put("pwm", now, duty.data(), rotors, 1e-4);
    } else {
      put("rotor_command", now, speeds.data(), rotors, 1e-2);
    }
    if (vehicle_.tilt.kind != vehicle::TiltKind::none) put("alpha_command", now, &r.alpha, 1, 1e-5);
  }
  if (!due(next_reference_, now, what_.reference_hz)) return;
  if (what_.reference) {
    const Quat asked = what_.commanded_attitude ? u.attitude : r.q_WB;
    const double q[] = {asked.w(), asked.x(), asked.y(), asked.z()};
    put("ref_position", now, r.p_WB.data(), 3, 1e-5);
    put("ref_attitude", now, q, 4, 1e-6);
    put("ref_velocity", now, r.v_WB_W.data(), 3, 1e-5);
    put("ref_acceleration", now, r.a_WB_W.data(), 3, 1e-5);
    if (!what_.commanded_attitude) {
      put("ref_angular_velocity", now, r.w_WB_B.data(), 3, 1e-5);
      put("ref_angular_acceleration", now, r.dw_WB_B.data(), 3, 1e-4);
    }
  }
  if (what_.reasons) {
    put("qddr", now, u.demand.data(), 6, 1e-4);
    put("qdd", now, u.achieved.data(), 6, 1e-4);
    put("thrust_command", now, thrust.data(), rotors, 1e-5);
  }
}

recording::Recording FamilyLog::finish() {
  recording::Recording out;
  for (const auto& [name, c] : columns_) {
    if (c.t.empty()) continue;
    const auto* spec = recording::find_spec(name);
    recording::Signal s{name, spec ? spec->unit : "", c.t, {}, name};
    s.values = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        c.values.data(), static_cast<Eigen::Index>(c.t.size()), static_cast<Eigen::Index>(c.width));
    out.duration_s = std::max(out.duration_s, c.t.back());
    out.signals.emplace(name, std::move(s));
  }
  return out;
}

}  // namespace omniflight::proof
