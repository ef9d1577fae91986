#include "conventions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "../numerics/statistics.hpp"
#include "attitude_rows.hpp"
#include "omniflight_diagnosis/filter.hpp"
#include "signal_rows.hpp"
#include "tilt_servo.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

/// One hypothesis about the conventions of attitude, accelerometer, gyro and velocity.
struct Reading {
  const char* says;  ///< objection if it fits; empty: as recorded
  std::function<Quat(const Quat&)> attitude = [](const Quat& q) { return q; };
  double acc_scale = 1, gyro_scale = 1;
  bool gravity_missing = false, body_velocity = false;
};

std::vector<Reading> readings() {
  const auto xyzw = [](const Quat& q) { return Quat(q.z(), q.w(), q.x(), q.y()); };
  std::vector<Reading> out(1, Reading{""});
  Reading r{"the attitude looks like x, y, z, w order: gravity and the rates fit with the scalar last"};
  r.attitude = xyzw;
  out.push_back(r);
  r = Reading{"the attitude looks shifted by one: its scalar stands in qx instead of qw"};
  r.attitude = [](const Quat& q) { return Quat(q.x(), q.y(), q.z(), q.w()); };
  out.push_back(r);
  r = Reading{"the attitude looks like body<-world: gravity and the rates fit its conjugate"};
  r.attitude = [](const Quat& q) { return q.conjugate(); };
  out.push_back(r);
  r = Reading{"the attitude looks like x, y, z, w order and body<-world"};
  r.attitude = [xyzw](const Quat& q) { return xyzw(q).conjugate(); };
  out.push_back(r);
  r = Reading{"'acc' looks like g instead of m/s2"};
  r.acc_scale = kGravity;
  out.push_back(r);
  r = Reading{"'acc' looks like the opposite sign (-9.81 at rest, z down) instead of specific force"};
  r.acc_scale = -1;
  out.push_back(r);
  r = Reading{"'acc' looks as if gravity had been removed from it; specific force (+9.81 at rest) is needed"};
  r.gravity_missing = true;
  out.push_back(r);
  r = Reading{"'gyro' looks like degrees per second instead of rad/s"};
  r.gyro_scale = kPi / 180;
  out.push_back(r);
  r = Reading{"'velocity' looks like body axes instead of world axes"};
  r.body_velocity = true;
  out.push_back(r);
  return out;
}

/// Signals on one slow grid, to compare the hypotheses.
struct Motion {
  static constexpr double kRate = 50, kCutoff = 4;  // Hz, grid and low pass; chosen
  std::vector<Quat> q;
  Eigen::MatrixXd acc, gyro, velocity, from_position;  ///< rows samples; empty when not recorded
  bool acc_from_rotors = false;                        ///< no accelerometer: acc is nominal thrust over mass
};

/// Nominal thrust of measured or commanded speeds over mass [m/s^2, body].
std::optional<Signal> specific_thrust(const Recording& r, const vehicle::Vehicle& vehicle) {
  const Signal* speed = first_of(r, {"rotor_speed", "rotor_command"});
  if (!speed || speed->empty() || speed->width() != vehicle.rotor_count()) return std::nullopt;
  const Eigen::MatrixXd tilt = tilt_at(r, vehicle, speed->t_s);
  Signal out;
  out.t_s = speed->t_s;
  out.values = Eigen::MatrixXd::Zero(speed->size(), 3);
  for (Eigen::Index i = 0; i < speed->size(); ++i) {
    const Vec3 f = thrust_of(vehicle, speed->values.row(i), tilt.size() > 0 ? tilt(i, 0) : 0.0);
    out.values.row(i) = f.transpose() / vehicle.mass;
  }
  return out;
}

Motion motion(const Recording& r, const vehicle::Vehicle& vehicle) {
  Motion m;
  const Signal* q = first_of(r, {"attitude", "est_attitude"});
  if (!q || q->size() < 50) return m;
  const Signal* a = r.find("acc");
  const auto thrust = a ? std::nullopt : specific_thrust(r, vehicle);
  if (thrust) a = &*thrust, m.acc_from_rotors = true;
  const Signal* w = r.find("gyro");
  const Signal* v = first_of(r, {"velocity", "est_velocity"});
  const Signal* p = first_of(r, {"position", "est_position"});
  double from = q->t_s.front(), to = q->t_s.back();
  for (const Signal* s : {a, w, v, p})
    if (s) from = std::max(from, s->t_s.front()), to = std::min(to, s->t_s.back());
  const double n = (to - from) * Motion::kRate;
  if (!(n > 100)) return m;
  std::vector<double> t;
  for (int i = 0; i < std::min(n, 60000.0); ++i) t.push_back(from + i / Motion::kRate);
  const Eigen::MatrixXd x = recording::resample(*q, t);
  for (Eigen::Index i = 0; i < x.rows(); ++i) m.q.push_back(quaternion(x, i));
  const auto smooth = [&](const Signal* s) -> Eigen::MatrixXd {
    if (!s || s->width() != 3) return {};
    return low_pass(recording::resample(*s, t), Motion::kRate, Motion::kCutoff);
  };
  m.acc = smooth(a);
  m.gyro = smooth(w);
  m.velocity = smooth(v);
  if (p) m.from_position = differentiate(smooth(p), Motion::kRate);
  return m;
}

/// Body rates [rad/s] of the attitudes, low-passed like the gyro.
Eigen::MatrixXd rate_of(const std::vector<Quat>& q) {
  Eigen::MatrixXd rate = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(q.size()), 3);
  for (std::size_t i = 1; i + 1 < q.size(); ++i)
    rate.row(static_cast<Eigen::Index>(i)) =
        0.5 * Motion::kRate * log_rotation(q[i - 1].conjugate() * q[i + 1]).transpose();
  return low_pass(rate, Motion::kRate, Motion::kCutoff);
}

/// Whether the gyro can be compared with the attitude: the body turns (RMS above 0.05 rad/s), or the gyro is
/// proportional to the attitude rate at a larger scale (wrong unit).
bool gyro_is_judged(const Motion& m) {
  if (m.gyro.size() == 0) return false;
  const Eigen::MatrixXd rate = rate_of(m.q);
  const auto rms = [](const Eigen::MatrixXd& x) {
    return x.norm() / std::sqrt(static_cast<double>(x.rows()));
  };
  const double alike = m.gyro.cwiseProduct(rate).sum() / std::max(1e-12, m.gyro.norm() * rate.norm());
  return rms(rate) > 0.05 || (rms(m.gyro) > 0.5 && alike > 0.7);
}

/// Normalised misfit of this hypothesis, the mean over: acceleration against dv/dt, gyro against attitude
/// rate, velocity against dp/dt. 0: consistent; 1: as large as the signals themselves. The constants added to
/// the denominators, in (m/s^2)^2, (rad/s)^2 and (m/s)^2, keep noise at rest from deciding.
double contradiction(const Motion& m, const Reading& r, bool gyro_tells) {
  const auto n = static_cast<Eigen::Index>(m.q.size());
  std::vector<Quat> q;
  for (const Quat& x : m.q) q.push_back(r.attitude(x));
  const Eigen::Index lo = 25, size = n - 50;
  double sum = 0;
  int parts = 0;
  Eigen::MatrixXd v = m.velocity.size() > 0 ? m.velocity : m.from_position;
  if (r.body_velocity)
    for (Eigen::Index i = 0; i < v.rows(); ++i)
      v.row(i) = (q[static_cast<std::size_t>(i)] * Vec3(v.row(i))).transpose();
  if (m.acc.size() > 0 && v.size() > 0) {
    Eigen::MatrixXd world(n, 3);
    for (Eigen::Index i = 0; i < n; ++i) {
      Vec3 a = q[static_cast<std::size_t>(i)] * Vec3(r.acc_scale * m.acc.row(i).transpose());
      if (!r.gravity_missing) a.z() -= kGravity;
      world.row(i) = a.transpose();
    }
    const Eigen::MatrixXd truth = differentiate(v, Motion::kRate);
    const Eigen::MatrixXd e = (low_pass(world, Motion::kRate, Motion::kCutoff) - truth).middleRows(lo, size);
    sum += e.squaredNorm() / (truth.middleRows(lo, size).squaredNorm() + 0.3 * static_cast<double>(size));
    ++parts;
  }
  if (gyro_tells) {
    const Eigen::MatrixXd rate = rate_of(q).middleRows(lo, size);
    const Eigen::MatrixXd w = r.gyro_scale * m.gyro.middleRows(lo, size);
    sum += (w - rate).squaredNorm() / (w.squaredNorm() + 0.01 * static_cast<double>(size));
    ++parts;
  }
  if (m.velocity.size() > 0 && m.from_position.size() > 0) {
    const Eigen::MatrixXd e = (v - m.from_position).middleRows(lo, size);
    sum += e.squaredNorm() / (v.middleRows(lo, size).squaredNorm() + 0.02 * static_cast<double>(size));
    ++parts;
  }
  return parts > 0 ? sum / parts : 0.0;
}

}  // namespace

void check_conventions(const Recording& r, const vehicle::Vehicle& vehicle, std::vector<std::string>& out) {
  const Motion m = motion(r, vehicle);
  if (m.q.size() < 100) return;
  const std::vector<Reading> all = readings();
  const bool gyro_tells = gyro_is_judged(m);
  const double as_read = contradiction(m, all[0], gyro_tells);
  double best = as_read;
  const char* says = "";
  for (const Reading& x : all)
    if (m.acc_from_rotors && (x.acc_scale != 1 || x.gravity_missing))
      continue;  // hypotheses about an accelerometer that was not recorded
    else if (const double c = contradiction(m, x, gyro_tells); c < best)
      best = c, says = x.says;
  if (as_read > 0.2 && best < 0.4 * as_read) out.emplace_back(says);
}

}  // namespace omniflight::diagnosis
