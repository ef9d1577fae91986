#include "case_log.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::proof {

void Log::put(const char* name, double t, const double* values, std::size_t width, double resolution) {
  Column& c = columns_[name];
  c.width = width;
  const double when = std::round(t * 1e6) / 1e6;
  if (!c.t.empty() && when <= c.t.back()) return;  // a repeated stamp carries nothing new
  c.t.push_back(when);
  const double per = std::round(1 / resolution);  // a whole number, so that the quotient prints short
  for (std::size_t k = 0; k < width; ++k) c.values.push_back(std::round(values[k] * per) / per);
}

void Log::sensors(const SensorFrame& f) {
  if (f.imu) {
    put("acc", f.imu_sample.t, f.imu_sample.specific_force_B.data(), 3, 1e-4);
    put("gyro", f.imu_sample.t, f.imu_sample.gyro_B.data(), 3, 1e-5);
  }
  if (f.mocap) {
    const Quat& q = f.mocap_sample.q_WB;
    const double wxyz[] = {q.w(), q.x(), q.y(), q.z()};
    put("position", f.mocap_sample.t, f.mocap_sample.p_WB.data(), 3, 1e-6);
    put("attitude", f.mocap_sample.t, wxyz, 4, 1e-6);
  }
  if (f.rotor) {
    put("rotor_speed", f.rotor_sample.t, f.rotor_sample.speed.data(), rotors_, 1e-2);
    put("alpha", f.rotor_sample.t, &f.rotor_sample.alpha, 1, 1e-5);
  }
  if (f.battery) {
    put("vbat", f.battery_sample.t, &f.battery_sample.voltage, 1, 1e-3);
    put("ibat", f.battery_sample.t, &f.battery_sample.current, 1, 1e-3);
  }
}

void Log::command(double t, const std::vector<double>& speeds, double alpha) {
  put("rotor_command", t, speeds.data(), rotors_, 1e-2);
  put("alpha_command", t, &alpha, 1, 1e-5);
}

void Log::reasons(double t, const Reference& r, const Vec6& demand, const Vec6& achieved,
                  const vehicle::RotorVector& thrust) {
  const double q[] = {r.q_WB.w(), r.q_WB.x(), r.q_WB.y(), r.q_WB.z()};
  put("ref_position", t, r.p_WB.data(), 3, 1e-5);
  put("ref_attitude", t, q, 4, 1e-6);
  put("ref_velocity", t, r.v_WB_W.data(), 3, 1e-5);
  put("ref_angular_velocity", t, r.w_WB_B.data(), 3, 1e-5);
  put("ref_acceleration", t, r.a_WB_W.data(), 3, 1e-5);
  put("ref_angular_acceleration", t, r.dw_WB_B.data(), 3, 1e-4);
  put("qddr", t, demand.data(), 6, 1e-4);
  put("qdd", t, achieved.data(), 6, 1e-4);
  put("thrust_command", t, thrust.data(), rotors_, 1e-4);
}

recording::Recording Log::finish() {
  recording::Recording out;
  double begin = 1e300, end = -1e300;
  for (const auto& [name, c] : columns_)
    if (!c.t.empty()) {
      begin = std::min(begin, c.t.front());
      end = std::max(end, c.t.back());
    }
  for (const auto& [name, c] : columns_) {
    const auto* spec = recording::find_spec(name);
    recording::Signal s{name, spec ? spec->unit : "", {}, {}, name};
    s.t_s.reserve(c.t.size());
    for (const double t : c.t) s.t_s.push_back(std::round((t - begin) * 1e6) / 1e6);
    s.values = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        c.values.data(), static_cast<Eigen::Index>(c.t.size()), static_cast<Eigen::Index>(c.width));
    out.signals.emplace(name, std::move(s));
  }
  out.duration_s = std::max(0.0, end - begin);
  return out;
}

}  // namespace omniflight::proof
