#include "input_validation.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "../numerics/statistics.hpp"
#include "../numerics/text.hpp"
#include "attitude_rows.hpp"
#include "omniflight_diagnosis/filter.hpp"
#include "thrust_source.hpp"
#include "tilt_servo.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

std::vector<double> norms(const Signal& s) {
  std::vector<double> out;
  for (Eigen::Index i = 0; i < s.size(); ++i) out.push_back(s.values.row(i).norm());
  return out;
}

const Signal* first_of(const Recording& r, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const Signal* s = r.find(name)) return s;
  return nullptr;
}

/// Spans [m] of height and of horizontal position, 2 % to 98 % quantile; negative without a position.
struct Travel {
  double up = -1, across = -1;
  bool moved() const { return up > 0.08 || across > 0.1; }
};

Travel travel(const Recording& r) {
  Travel t;
  const Signal* p = first_of(r, {"position", "est_position"});
  if (!p || p->width() != 3) return t;
  std::array<double, 3> span{};
  for (Eigen::Index c = 0; c < 3; ++c) {
    std::vector<double> x(p->values.col(c).begin(), p->values.col(c).end());
    span[static_cast<std::size_t>(c)] = quantile(x, 0.98) - quantile(x, 0.02);
  }
  t.up = span[2];
  t.across = std::hypot(span[0], span[1]);
  return t;
}

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

/// Sum of the nominal thrusts [N, body] at a row of speeds [rad/s] and a tilt [rad]; NaN is taken as 0.
template <class Row>
Vec3 thrust_of(const vehicle::Vehicle& vehicle, const Row& speed, double tilt) {
  Vec3 f = Vec3::Zero();
  for (int k = 0; k < vehicle.rotor_count(); ++k)
    f += vehicle.rotors[static_cast<std::size_t>(k)].thrust(speed[k]) *
         vehicle.rotor_axis(k, std::isfinite(tilt) ? tilt : 0.0);
  return f;
}

/// 90 % quantile of |gyro| [rad/s]; 0 without a gyro.
double turning(const Recording& r) {
  const Signal* gyro = r.find("gyro");
  return gyro ? quantile(norms(*gyro), 0.9) : 0.0;
}

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

void check_magnitudes(const Recording& r, const vehicle::Vehicle& vehicle, std::vector<std::string>& out) {
  if (const Signal* w = r.find("gyro"))
    if (const double top = quantile(norms(*w), 0.99); top > 40)
      out.push_back(
          format("'gyro' reaches %.0f rad/s, more than any gyro measures: it looks like degrees "
                 "per second",
                 top));
  if (const Signal* a = r.find("acc")) {
    const double middle = quantile(norms(*a), 0.5);
    if (middle > 0.6 && middle < 1.6)
      out.push_back(
          format("'acc' has a median magnitude of %.2f m/s2: it looks like g instead of m/s2", middle));
    else if (middle > 300)
      out.push_back(
          format("'acc' has a median magnitude of %.0f m/s2: it looks like mm/s2, cm/s2 or mg", middle));
  }
  if (const Signal* alpha = r.find("alpha"))
    if (const double top = quantile(norms(*alpha), 0.99); top > std::max(3.2, 1.5 * vehicle.tilt.max))
      out.push_back(format("'alpha' reaches %.1f rad, the vehicle tilts to %.2f rad: it looks like degrees",
                           top, vehicle.tilt.max));
  if (const Signal* u = r.find("pwm"))
    if (const double top = quantile(norms(*u), 0.99); top > 2.0 * std::sqrt(static_cast<double>(u->width())))
      out.push_back(format("'pwm' reaches %.0f; it must be normalised to 0..1", top));
  if (const Signal* v = r.find("vbat"))
    if (const double middle = quantile(norms(*v), 0.5); middle > 500)
      out.push_back(format("'vbat' is %.0f V: it looks like millivolts", middle));
  double fastest = 1e18;
  Eigen::Index samples = 0;
  for (const auto& [name, s] : r.signals)
    if (s.size() > 20 && s.median_period_s() > 0) {
      fastest = std::min(fastest, s.median_period_s());
      samples = std::max(samples, s.size());
    }
  if (samples > 50 && fastest > 0.8 && fastest < 1e17)
    out.push_back(
        format("the samples are %.3g s apart: the time looks like milliseconds or microseconds", fastest));
  if (samples > 50 && fastest < 2e-5)
    out.push_back(format("the samples are %.3g s apart: the time is in another unit than seconds", fastest));
  const Signal* p = r.find("position");
  const Signal* v = r.find("velocity");
  if (p && v && p->width() == 3 && v->width() == 3 && p->size() > 50) {
    Signal path = *p;
    std::vector<double> ratio;
    for (Eigen::Index i = 10; i < p->size(); i += 10) {
      const double dt = p->t_s[static_cast<std::size_t>(i)] - p->t_s[static_cast<std::size_t>(i - 10)];
      const std::vector<double> t{
          0.5 * (p->t_s[static_cast<std::size_t>(i)] + p->t_s[static_cast<std::size_t>(i - 10)])};
      const double speed = recording::resample(*v, t).row(0).norm();
      if (speed > 0.05 && dt > 0)
        ratio.push_back((p->values.row(i) - p->values.row(i - 10)).norm() / dt / speed);
    }
    const double middle = quantile(ratio, 0.5);
    if (ratio.size() > 10 && middle > 300)
      out.push_back(
          format("'position' changes %.0f times as fast as 'velocity' says: it looks like millimetres, or "
                 "the time like milliseconds",
                 middle));
    else if (ratio.size() > 10 && middle < 0.02)
      out.push_back(
          format("'position' changes only %.4f times as fast as 'velocity' says: unit of position, "
                 "velocity or time",
                 middle));
  }
}

/// |Sum of nominal thrusts|; 0 when unknown. `ratio`: median while the rotors turn, over mass times median
/// |specific force|. `top`: 95 % quantile over the weight.
struct Lift {
  double ratio = 0, top = 0;
};

Lift lift(const Recording& r, const Signal* speed, const vehicle::Vehicle& vehicle, const Options& o) {
  Lift out;
  if (speed->width() != vehicle.rotor_count()) return out;
  const Signal* acc = r.find("acc");
  const std::size_t stride = std::max<std::size_t>(1, speed->t_s.size() / 4000);
  std::vector<double> t;
  for (std::size_t i = 0; i < speed->t_s.size(); i += stride) t.push_back(speed->t_s[i]);
  const Eigen::MatrixXd tilt = tilt_at(r, vehicle, t);
  std::vector<double> thrust;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double a = tilt.size() > 0 ? tilt(static_cast<Eigen::Index>(i), 0) : 0.0;
    const auto row = static_cast<Eigen::Index>(i * stride);
    thrust.push_back(thrust_of(vehicle, speed->values.row(row), a).norm());
  }
  out.top = quantile(thrust, 0.95);
  std::vector<double> flying;
  for (double f : thrust)
    if (f > 0.3 * out.top) flying.push_back(f);
  const double force =
      vehicle.mass * (acc ? std::max(1.0, quantile(norms(*acc), 0.5)) : o.environment.gravity);
  out.ratio = quantile(flying, 0.5) / force;
  out.top /= vehicle.mass * o.environment.gravity;
  return out;
}

/// Checks of a recording whose thrust is modelled from duty cycle or power: full drive is taken as
/// max_thrust.
void check_modelled(const Recording& r, const vehicle::Vehicle& vehicle, const Options& o, const Travel& way,
                    std::vector<std::string>& out) {
  const Signal* u = first_of(r, {"pwm", "motor_power", "thrust_model", "thrust_command"});
  if (u && quantile(norms(*u), 0.95) < 1e-6) {
    out.emplace_back("the motors never turn: this vehicle never flew");
    return;
  }
  const double weight = vehicle.mass * o.environment.gravity;
  double most = 0;
  for (const vehicle::Rotor& rotor : vehicle.rotors) most += rotor.max_thrust;
  if (most < weight) {
    out.push_back(
        format("vehicle '%s' cannot fly: its rotors give at most %.3g N together, its weight is %.3g N "
               "(mass %.4g kg). Its mass or its max_thrust is wrong",
               vehicle.name.c_str(), most, weight, vehicle.mass));
    return;
  }
  const auto source = thrust_source(r, vehicle);
  if (!source || source->kind != SpeedSource::modelled) return;
  const Lift l = lift(r, &source->speed, vehicle, o);
  constexpr double kLeast = 0.25, kMost = 4.0;  // tolerated thrust over weight: max_thrust is a rough figure
  const double rate = turning(r);
  const bool still = way.up >= 0 && !way.moved() && rate < 0.15;
  const bool stands = still && std::max(way.up, way.across) < 0.005 && rate < 0.05;  // calmer than any hover
  if (stands || l.top < (still ? 2 * kLeast : kLeast))
    out.push_back(format(
        "%sthe motors are driven to %.0f %% of the weight at most: this vehicle never flew, or '%s' (mass "
        "%.4g kg) is another one",
        still ? "nothing moves, and " : "", 100 * l.top, vehicle.name.c_str(), vehicle.mass));
  else if (l.ratio > kMost)
    out.push_back(
        format("vehicle '%s' does not fit this recording: driven like this its rotors carry %.2g times its "
               "weight of %.3g N. Its mass (%.4g kg) or its max_thrust is wrong",
               vehicle.name.c_str(), l.ratio, weight, vehicle.mass));
}

void check_vehicle(const Recording& r, const vehicle::Vehicle& vehicle, const Options& o,
                   std::vector<std::string>& out) {
  const Signal* speed = first_of(r, {"rotor_speed", "rotor_command"});
  const Travel way = travel(r);
  const bool known = way.up >= 0;
  if (!speed) return check_modelled(r, vehicle, o, way, out);
  const Lift l = lift(r, speed, vehicle, o);
  if (l.top <= 0) {
    out.emplace_back("the rotors never turn: this vehicle never flew");
    return;
  }
  if (known && !way.moved() && l.ratio < 0.9 && turning(r) < 0.15) {
    out.push_back(
        format("nothing moves (%.0f mm) and the rotors carry %.0f %% of the weight at most: this vehicle "
               "never flew",
               1e3 * std::max(way.up, way.across), 100 * l.top));
    return;
  }
  if (l.ratio > 0.25 && l.ratio < 4.0) return;
  std::string guess;
  if (l.ratio > 45 && l.ratio < 180) guess = "; the rotor speeds look like rev/min instead of rad/s";
  if (l.ratio > 1.0 / 80 && l.ratio < 1.0 / 20)
    guess = "; the rotor speeds look like rev/s (Hz) instead of rad/s";
  out.push_back(format(
      "vehicle '%s' does not fit this recording: at these rotor speeds its rotors carry %.2g times "
      "its weight of %.3g N. Its mass (%.4g kg), its thrust coefficient or the unit of the rotor "
      "speeds is wrong%s",
      vehicle.name.c_str(), l.ratio, vehicle.mass * o.environment.gravity, vehicle.mass, guess.c_str()));
}

}  // namespace

Result<std::vector<std::string>> validate_input(const Recording& r, const vehicle::Vehicle& vehicle,
                                                const Options& o) {
  Eigen::Index most = 0;
  for (const auto& [name, s] : r.signals) {
    most = std::max(most, s.size());
    for (const recording::SignalSpec& spec : recording::canonical_signals())
      if (name == spec.name && spec.width > 0 && !s.empty() && s.width() != spec.width)
        return bad_input("signal '" + name + "' has " + std::to_string(s.width()) + " components, it needs " +
                             std::to_string(spec.width),
                         r.file, "Record all of them");
    if (!s.values.allFinite())
      return bad_input("signal '" + name + "' holds values that are not finite", r.file);
  }
  for (const char* name : {"rotor_speed", "rotor_command", "pwm", "motor_power"})
    if (const Signal* s = r.find(name); s && s->width() != vehicle.rotor_count())
      return bad_input("the recording has " + std::to_string(s->width()) + " rotors ('" + name +
                           "'), vehicle '" + vehicle.name + "' has " + std::to_string(vehicle.rotor_count()),
                       r.file, "Name the right vehicle with --vehicle");
  if (most == 0) return bad_input("holds no sample of any signal", r.file, "Give a recording of a flight");
  if (most < 20)
    return bad_input("holds " + std::to_string(most) + (most == 1 ? " sample" : " samples") +
                         " only; a diagnosis needs some seconds of flight",
                     r.file, "Give a longer recording");
  std::vector<std::string> out;
  for (const recording::Note& note : r.notes)
    if (note.kind == recording::Note::Kind::damage && note.text.find("runs backwards") != std::string::npos)
      out.push_back(note.text);
  check_magnitudes(r, vehicle, out);
  check_conventions(r, vehicle, out);
  check_vehicle(r, vehicle, o, out);
  return out;
}

}  // namespace omniflight::diagnosis
