#include "input_validation.hpp"

#include <algorithm>
#include <cmath>

#include "../numerics/statistics.hpp"
#include "../numerics/text.hpp"
#include "conventions.hpp"
#include "signal_rows.hpp"
#include "thrust_source.hpp"
#include "tilt_servo.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

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

/// 90 % quantile of |gyro| [rad/s]; 0 without a gyro.
double turning(const Recording& r) {
  const Signal* gyro = r.find("gyro");
  return gyro ? quantile(norms(*gyro), 0.9) : 0.0;
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
