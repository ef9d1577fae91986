#include "fine_motion.hpp"

#include <algorithm>
#include <cmath>

#include "attitude_rows.hpp"
#include "force_frame.hpp"
#include "omniflight_diagnosis/filter.hpp"
#include "omniflight_diagnosis/residual.hpp"
#include "sensor_delays.hpp"
#include "structural_resonance.hpp"
#include "tilt_servo.hpp"
#include "velocity_observer.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

/// Lag [s] between rotor speeds and gyro below which they are not shifted. Chosen: about the resolution of
/// linear interpolation on a grid of some milliseconds.
constexpr double kLeastTorqueLag = 0.0015;

/// Signed square, and its inverse. Speeds are averaged as signed squares: thrust is proportional to them, so
/// that wrench and acceleration pass through the same linear filter, also where rotors reverse.
Eigen::MatrixXd squares(const Eigen::MatrixXd& x) { return x.cwiseProduct(x.cwiseAbs()); }
Eigen::MatrixXd roots(const Eigen::MatrixXd& x) { return x.array().abs().sqrt() * x.array().sign(); }

/// Rotor commands [rad/s] through the first-order lags of the vehicle file.
Eigen::MatrixXd modelled_speed(const Eigen::MatrixXd& command, double rate_hz, const vehicle::Vehicle& v) {
  Eigen::MatrixXd speed = command;
  for (Eigen::Index r = 0; r < command.cols(); ++r) {
    const double tau = v.rotors[static_cast<std::size_t>(r)].time_constant;
    for (Eigen::Index i = 1; i < command.rows(); ++i)
      speed(i, r) = lagged_speed(speed(i - 1, r), command(i - 1, r), tau, 1.0 / rate_hz);
  }
  return speed;
}

/// Variance [s^2] of the widest smoothing kernel among the signals of the regression. All of them are
/// smoothed to it: a kernel that attenuates the motion more than the rotors would look like a wrong inertia.
double widest_kernel(const ChosenSignals& c, const Grid& grid) {
  return std::max({kernel_variance(c.rotors.speed, grid, 0),
                   c.gyro ? kernel_variance(*c.gyro, grid, 1) : kernel_variance(c.attitude, grid, 2),
                   c.acc        ? kernel_variance(*c.acc, grid, 0)
                   : c.velocity ? kernel_variance(*c.velocity, grid, 1)
                                : kernel_variance(*c.position, grid, 2)});
}

/// Resamples one signal after the other onto the grid.
class Taking {
 public:
  Taking(const ChosenSignals& signals, const Repaired& repaired, const Grid& grid,
         const vehicle::Vehicle& vehicle, const Options& o, UsedSamples& used, Flight& f)
      : in_(signals),
        grid_(grid),
        vehicle_(vehicle),
        o_(o),
        used_(used),
        f_(f),
        widest_(widest_kernel(signals, grid)),
        repeated_(in_windows(repaired.frozen, grid)),
        limited_(in_windows(repaired.clipped, grid)) {}

  void rotors(FineMotion& m) const;
  void place(FineMotion& m) const;
  void turning(FineMotion& m) const;
  void force(FineMotion& m) const;
  void tilt(const Recording& recording, FineMotion& m) const;
  void rotors_on_the_clock_of_the_gyro(FineMotion& m) const;
  Eigen::MatrixXd take(const Signal& s, const std::string& label, double more = 0) const;
  /// See Flight::kernel_s.
  double kernel_s() const { return std::sqrt(widest_ + 1 / (12 * o_.grid_hz * o_.grid_hz)); }

 private:
  /// Variance [s^2] to add to a signal's kernel to reach the widest.
  double missing(const Signal& s, int derivatives) const {
    return widest_ - kernel_variance(s, grid_, derivatives);
  }
  Eigen::MatrixXd derivative(const Eigen::MatrixXd& x) const { return differentiate(x, grid_.rate_hz); }

  const ChosenSignals& in_;
  const Grid& grid_;
  const vehicle::Vehicle& vehicle_;
  const Options& o_;
  UsedSamples& used_;
  Flight& f_;
  double widest_;
  std::vector<char> repeated_, limited_;
};

Eigen::MatrixXd Taking::take(const Signal& s, const std::string& label, double more) const {
  Channel c = on_grid(s, grid_, o_, more);
  std::vector<char> gap = negated(c.valid);
  for (std::size_t i = 0; i < gap.size(); ++i) gap[i] = gap[i] && !repeated_[i] && !limited_[i];
  used_.exclude(gap, o_.margin_s, "gap in " + label);
  return std::move(c.x);
}

void Taking::rotors(FineMotion& m) const {
  const Signal& measured = in_.rotors.speed;
  Signal squared = measured;
  squared.values = squares(measured.values);
  m.rotor_speed = roots(take(squared, measured.name, missing(measured, 0)));
  // Angular momentum is linear in the speed: the root of a filtered square is not differentiable at zero.
  Signal itself = squared;
  itself.values = roots(squared.values);
  m.rotor_turning = on_grid(itself, grid_, o_, missing(measured, 1)).x;
  if (f_.speed_from_command)
    for (Eigen::MatrixXd* x : {&m.rotor_speed, &m.rotor_turning})
      *x = modelled_speed(*x, grid_.rate_hz, vehicle_);
}

void Taking::place(FineMotion& m) const {
  const Eigen::MatrixXd nothing = Eigen::MatrixXd::Zero(grid_.size(), 3);
  f_.has_position = in_.position.has_value();
  m.position = in_.position ? take(*in_.position, "position") : nothing;
  m.velocity = in_.velocity   ? take(*in_.velocity, "velocity")
               : in_.position ? derivative(m.position)
                              : nothing;
  if (!in_.position)
    f_.notes.push_back("No position: effects that depend on height or place are not offered.");
  if (!in_.velocity && !in_.position) f_.notes.push_back("No velocity: drag is not offered.");
}

void Taking::turning(FineMotion& m) const {
  f_.has_gyro = in_.gyro != nullptr;
  m.rate = in_.gyro ? take(*in_.gyro, "gyro", missing(*in_.gyro, 1))
                    : rate_from_attitude(on_grid(in_.attitude, grid_, o_, missing(in_.attitude, 2)).x,
                                         grid_.rate_hz);
  m.angular_acceleration = derivative(m.rate);
}

void Taking::force(FineMotion& m) const {
  const double gravity = o_.environment.gravity;
  f_.has_accelerometer = in_.acc != nullptr;
  if (in_.acc) {
    m.specific_force = take(*in_.acc, "acc", missing(*in_.acc, 0));
    if ((in_.velocity || in_.position) &&
        force_is_in_world(m.specific_force, derivative(m.velocity), m.attitude, used_.flags(), gravity)) {
      turn_into_body(m.attitude, m.specific_force);
      f_.notes.push_back("'acc' follows the world's axes, not the body's: it was turned into the body.");
    }
    if (in_.velocity || !in_.position || !o_.assumes(Assumption::velocity_observer)) return;
    Eigen::MatrixXd acceleration = m.specific_force;
    turn_into_world(m.attitude, acceleration);
    acceleration.col(2).array() -= gravity;
    m.velocity = observed_velocity(m.position, m.velocity, acceleration, used_.flags(), grid_.rate_hz);
    return;
  }
  m.specific_force =
      in_.velocity ? derivative(on_grid(*in_.velocity, grid_, o_, missing(*in_.velocity, 1)).x)
                   : derivative(derivative(on_grid(*in_.position, grid_, o_, missing(*in_.position, 2)).x));
  m.specific_force.col(2).array() += gravity;
  turn_into_body(m.attitude, m.specific_force);
  f_.notes.push_back("No accelerometer: acceleration is the derivative of the velocity.");
}

void Taking::tilt(const Recording& recording, FineMotion& m) const {
  m.alpha = Eigen::MatrixXd::Zero(grid_.size(), 1);
  if (const auto tilt = rotor_tilt(recording, vehicle_)) {
    m.alpha = take(tilt->alpha, "alpha");
    f_.has_alpha = true;
    if (tilt->modelled)
      f_.notes.push_back(
          recording.find("alpha")
              ? "The recorded tilt angle is what the servo was set to: it lacks the lag and play that the "
                "vehicle file tells, with which the rotors follow it."
              : "No measured tilt angle: the rotors follow its command as the vehicle file tells.");
  } else if (vehicle_.tilt.kind != vehicle::TiltKind::none) {
    f_.notes.push_back("No tilt angle: it is taken as zero.");
  }
}

void Taking::rotors_on_the_clock_of_the_gyro(FineMotion& m) const {
  if (!in_.gyro) return;
  GyroDelays delays;
  for (const Alignment& a : f_.alignment)
    if (a.early == "gyro" && a.late == "attitude") {
      delays.behind_pose = a;
      delays.behind_pose->lag_s = -a.lag_s;
    }
  if (!f_.speed_from_command) {
    const RotorExcitation rotors =
        rotor_excitation(m.rotor_speed, m.rotor_turning, m.alpha, grid_.rate_hz, vehicle_);
    const RotorRegression regression(m.angular_acceleration,
                                     in_.acc ? m.specific_force : Eigen::MatrixXd(0, 3), rotors,
                                     grid_.rate_hz, used_.flags());
    delays.behind_rotors = lag_behind_rotors(regression);
    if (o_.assumes(Assumption::late_thrust))
      delays.as_response = thrust_response(regression, o_.tolerance.rotor_clock);
    if (const auto mode = structural_resonance(regression, o_.tolerance.rotor_clock, o_.temperature);
        mode && !(delays.as_response && delays.as_response->log_factor > o_.temperature * mode->log_factor)) {
      delays.as_response.reset();
      f_.faults.push_back(as_fault(*mode));
    }
  }
  if (auto late = what_is_late(delays, vehicle_, o_)) f_.faults.push_back(std::move(*late));
  if (delays.as_response) m.rotor_speed = responding(m.rotor_speed, *delays.as_response, grid_.rate_hz);
  const std::optional<TorqueLag>& lag = delays.behind_rotors;
  if (!lag) return;
  f_.alignment.push_back(
      {"rotor_speed (torque)", "gyro", lag->lag_s, lag->se_s, 0, 0, std::sqrt(lag->explained)});
  if (!delays.as_response && std::abs(lag->lag_s) > kLeastTorqueLag + 3 * lag->se_s)
    for (Eigen::MatrixXd* s : {&m.rotor_speed, &m.rotor_turning}) *s = delayed(*s, lag->lag_s, grid_.rate_hz);
}

}  // namespace

Result<Grid> fine_grid(const ChosenSignals& signals, const std::string& file, const Options& o) {
  double from = -1e18, to = 1e18, fastest = 1e18;
  for (const Signal* s : signals.all()) {
    from = std::max(from, s->t_s.front());
    to = std::min(to, s->t_s.back());
    if (s->median_period_s() > 0) fastest = std::min(fastest, s->median_period_s());
  }
  if (!(to - from > 2.0) || !(fastest < 1.0))
    return bad_input("the needed signals overlap for less than 2 s", file, "Give a longer recording");
  if (to - from > 7200) return bad_input("longer than two hours", file, "Give a part of the recording");
  Grid grid;
  grid.step = std::clamp(static_cast<int>(std::lround(1.0 / fastest / o.grid_hz)), 3, 15);
  grid.rate_hz = o.grid_hz * grid.step;
  const int fine = static_cast<int>((to - from) * grid.rate_hz);
  for (int i = 0; i < fine; ++i) grid.t.push_back(from + i / grid.rate_hz);
  return grid;
}

FineMotion fine_motion(const ChosenSignals& signals, const Repaired& repaired, const Grid& grid,
                       const vehicle::Vehicle& vehicle, const Options& o, UsedSamples& used, Flight& f) {
  f.alignment = signals.alignment;
  const Taking taking(signals, repaired, grid, vehicle, o, used, f);
  f.kernel_s = taking.kernel_s();
  FineMotion m;
  m.attitude = taking.take(signals.attitude, "attitude");
  taking.rotors(m);
  taking.place(m);
  taking.turning(m);
  taking.force(m);
  taking.tilt(repaired.recording, m);
  taking.rotors_on_the_clock_of_the_gyro(m);
  return m;
}

}  // namespace omniflight::diagnosis
