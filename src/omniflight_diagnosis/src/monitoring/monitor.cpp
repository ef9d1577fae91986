#include "omniflight_diagnosis/monitor.hpp"

#include <algorithm>
#include <cmath>

#include "../numerics/text.hpp"
#include "omniflight_diagnosis/residual.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kKeep = 5.0;       // s, length of the sample buffers; chosen
constexpr double kForgotten = 1.0;  // s, age above which a residual is stale; chosen
constexpr std::array<const char*, 6> kNames{"force_x",  "force_y",  "force_z",
                                            "torque_x", "torque_y", "torque_z"};

Level of(bool warn, bool error) { return error ? Level::error : warn ? Level::warn : Level::ok; }

}  // namespace

const char* to_string(Level level) {
  switch (level) {
    case Level::ok:
      return "OK";
    case Level::warn:
      return "WARN";
    case Level::error:
      return "ERROR";
    case Level::stale:
      break;
  }
  return "STALE";
}

bool SampleLine::add(double t, const Eigen::Ref<const Eigen::VectorXd>& value) {
  if (!(t > last()) || !std::isfinite(t) || !value.allFinite()) return false;
  samples_.emplace_back(t, value);
  forget_before(t - kKeep);
  return true;
}

double SampleLine::at(double t, Eigen::VectorXd& value) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), t,
                                      [](const auto& s, double time) { return s.first < time; });
  if (after == samples_.begin() || after->first == t) {
    value = after->second;
    return 0;
  }
  const auto before = std::prev(after);
  const double gap = after->first - before->first, share = (t - before->first) / gap;
  value = (1 - share) * before->second + share * after->second;
  return gap;
}

bool SampleLine::held(double t, Eigen::VectorXd& value) const {
  const auto after = std::upper_bound(samples_.begin(), samples_.end(), t,
                                      [](double time, const auto& s) { return time < s.first; });
  if (after == samples_.begin()) return false;
  value = std::prev(after)->second;
  return true;
}

void SampleLine::forget_before(double t) {
  while (samples_.size() > 1 && samples_[1].first <= t) samples_.pop_front();
}

void Trip::update(double t, double value, double limit, double confirm_s) {
  const bool other = on_ ? value < 0.7 * limit : value > limit;
  if (!other)
    since_ = -1;
  else if (since_ < 0)
    since_ = t;
  if (other && t - since_ >= confirm_s) {
    on_ = !on_;
    since_ = -1;
  }
}

Result<Monitor> Monitor::create(const vehicle::Vehicle& vehicle, const MonitorOptions& o) {
  const auto within = [](double x, double low, double high) { return x >= low && x <= high; };
  const auto refuse = [](const char* field, const char* what) -> Error {
    return {ErrorCode::bad_input, what, std::string("monitor.") + field, ""};
  };
  if (!within(o.grid_hz, 20, 2000)) return Failure(refuse("grid_hz", "must be 20 to 2000 Hz"));
  if (!within(o.cutoff_hz, 0.05, 0.4 * o.grid_hz))
    return Failure(refuse("cutoff_hz", "must be 0.05 Hz to 0.4 of grid_hz"));
  if (!(o.warn_sigma > 0 && o.error_sigma >= o.warn_sigma))
    return Failure(refuse("error_sigma", "must not be below warn_sigma, which is above 0"));
  if (!(o.warn_speed > 0 && o.error_speed >= o.warn_speed))
    return Failure(refuse("error_speed", "must not be below warn_speed, which is above 0"));
  if (vehicle.rotors.empty()) return Failure(refuse("vehicle", "has no rotors"));
  return Monitor(vehicle, o);
}

Monitor::Monitor(const vehicle::Vehicle& vehicle, const MonitorOptions& o)
    : vehicle_(vehicle),
      options_(o),
      rotors_(vehicle.rotors.size()),
      wrench_filter_(o.grid_hz, o.cutoff_hz, 6),
      motor_filter_(o.grid_hz, o.cutoff_hz, static_cast<Eigen::Index>(vehicle.rotors.size())),
      lag_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rotors_))),
      deviation_(lag_),
      motor_warn_(rotors_),
      motor_error_(rotors_) {
  double arm = 1e-3;
  for (const vehicle::Rotor& r : vehicle.rotors) arm = std::max(arm, r.p_BR.norm());
  const Tolerance& tol = o.tolerance;
  const double weight = vehicle.mass * o.gravity, level = std::hypot(tol.thrust_scale, tol.world_force);
  const double lateral = vehicle.mass * tol.accelerometer_lateral,
               vertical = vehicle.mass * tol.accelerometer_vertical;
  sigma_ << std::hypot(lateral, level * weight), std::hypot(lateral, level * weight),
      std::hypot(vertical, level * weight), Vec3::Constant(tol.torque_trim * weight * arm);
  const char* const names[] = {"wrench balance", "motors", "sensors"};
  for (std::size_t k = 0; k < checks_.size(); ++k) checks_[k].name = names[k];
}

double Monitor::delay_s() const { return wrench_filter_.delay_s(); }

void Monitor::add_imu(double t, const Vec3& specific_force, const Vec3& rate) {
  Vec6 x;
  x << specific_force, rate;
  (void)imu_.add(t, x);
}

void Monitor::add_mocap(double t, const Vec3& position, const Quat& attitude) {
  if (!(t > mocap_t_) || !position.allFinite() || !attitude.coeffs().allFinite()) return;
  mocap_t_ = t;
  Eigen::Matrix<double, 7, 1> pose;
  pose << position, attitude.coeffs();
  if (pose != pose_ || mocap_changed_ < 0) mocap_changed_ = t;
  pose_ = pose;
}

void Monitor::add_rotors(double t, std::span<const double> speed, double alpha) {
  if (speed.size() != rotors_) return;
  Eigen::VectorXd x(static_cast<Eigen::Index>(rotors_) + 1);
  std::copy(speed.begin(), speed.end(), x.begin());
  x[x.size() - 1] = alpha;
  (void)rotor_.add(t, x);
}

void Monitor::add_command(double t, std::span<const double> speed) {
  if (speed.size() != rotors_) return;
  (void)command_.add(t, Eigen::Map<const Eigen::VectorXd>(speed.data(), static_cast<Eigen::Index>(rotors_)));
}

void Monitor::start_anew() {
  wrench_filter_.reset();
  motor_filter_.reset();
  next_ = motor_next_ = wrench_t_ = motor_t_ = -1;
  for (Trip& trip : warn_) trip.reset();
  for (Trip& trip : error_) trip.reset();
  for (Trip& trip : motor_warn_) trip.reset();
  for (Trip& trip : motor_error_) trip.reset();
}

/// Computes the residual at all grid times up to t [s] that IMU and rotor telemetry both cover.
void Monitor::advance_wrench(double t) {
  const double period = 1.0 / options_.grid_hz;
  if (imu_.empty() || rotor_.empty()) return;
  const double from = std::max({imu_.first() + period, rotor_.first(), released_});
  if (next_ < from) next_ = from;
  const double until = std::min({t, imu_.last() - period, rotor_.last()});
  Eigen::VectorXd before, now, after, rotor;
  physics::Situation s;
  physics::Environment environment;
  environment.gravity = options_.gravity;
  for (; next_ <= until; next_ += period) {
    const double gap = std::max({imu_.at(next_ - period, before), imu_.at(next_, now),
                                 imu_.at(next_ + period, after), rotor_.at(next_, rotor)});
    if (gap > options_.max_gap_s) {
      wrench_filter_.reset();
      continue;
    }
    RigidState body;
    body.w_WB_B = now.tail<3>();
    const double alpha = vehicle_.tilt.kind == vehicle::TiltKind::none ? 0.0 : rotor[rotor.size() - 1];
    physics::prepare(vehicle_, body, alpha, {rotor.data(), rotors_}, {}, environment, s);
    s.dw_WB_B = (after.tail<3>() - before.tail<3>()) * (0.5 * options_.grid_hz);
    const Vec3 at_origin = now.head<3>() - beside_origin(options_.imu_position, body.w_WB_B, s.dw_WB_B);
    filtered_ = wrench_residual(s, at_origin, vehicle_.center_of_mass);
    wrench_filter_.step(filtered_);
    wrench_t_ = next_;
    if (next_ < released_ + options_.settle_s) continue;
    for (std::size_t c = 0; c < 6; ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      const double size = std::abs(filtered_[i]) / sigma_[i];
      warn_[c].update(next_, size, options_.warn_sigma, options_.confirm_s);
      error_[c].update(next_, size, options_.error_sigma, options_.confirm_s);
    }
  }
  imu_.forget_before(next_ - 2 * period);
}

/// Compares measured speeds with the commands through the nominal lag, up to t [s].
void Monitor::advance_motors(double t) {
  const double period = 1.0 / options_.grid_hz;
  if (rotor_.empty() || command_.empty()) return;
  const double from = std::max({rotor_.first(), command_.first(), released_});
  Eigen::VectorXd command, rotor;
  if (motor_next_ < from) {
    motor_next_ = from;
    if (from <= rotor_.last()) {
      rotor_.at(from, rotor);
      lag_ = rotor.head(lag_.size());
    } else {
      motor_next_ = -1;
      return;
    }
  }
  const double until = std::min({t, rotor_.last(), command_.last()});
  for (; motor_next_ <= until; motor_next_ += period) {
    if (!command_.held(motor_next_ - 0.5 * period, command)) command_.held(motor_next_, command);
    if (rotor_.at(motor_next_, rotor) > options_.max_gap_s) motor_filter_.reset();
    for (std::size_t k = 0; k < rotors_; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const vehicle::Rotor& r = vehicle_.rotors[k];
      lag_[i] = lagged_speed(lag_[i], command[i], r.time_constant, period);
      deviation_[i] = (rotor[i] - lag_[i]) / r.max_speed();
    }
    motor_filter_.step(deviation_);
    motor_t_ = motor_next_;
    if (motor_next_ < released_ + options_.settle_s) continue;
    for (std::size_t k = 0; k < rotors_; ++k) {
      const double size = std::abs(deviation_[static_cast<Eigen::Index>(k)]);
      motor_warn_[k].update(motor_next_, size, options_.warn_speed, options_.confirm_s);
      motor_error_[k].update(motor_next_, size, options_.error_speed, options_.confirm_s);
    }
  }
  command_.forget_before(motor_next_ - period);
}

void Monitor::assess_wrench(double t) {
  Check& c = checks_[0];
  c.values.clear();
  if (released_ < 0 || t - wrench_t_ > kForgotten) {
    c.level = released_ < 0 ? Level::ok : Level::stale;
    c.message =
        released_ < 0 ? "held, not judged" : "no IMU or no rotor telemetry: the wrench cannot be balanced";
    return;
  }
  Eigen::Index worst = 0;
  (filtered_.cwiseAbs().cwiseQuotient(sigma_)).maxCoeff(&worst);
  bool warn = false, error = false;
  for (std::size_t k = 0; k < 6; ++k) {
    warn = warn || warn_[k].on();
    error = error || error_[k].on();
  }
  c.level = of(warn, error);
  const double in_sigma = filtered_[worst] / sigma_[worst];
  c.message = format("%s %+.3g %s is %.1f sigma of the tolerance", kNames[static_cast<std::size_t>(worst)],
                     filtered_[worst], worst < 3 ? "N" : "Nm", std::abs(in_sigma));
  for (std::size_t k = 0; k < 6; ++k)
    c.values.push_back(
        {std::string(kNames[k]) + (k < 3 ? " [N]" : " [Nm]"), filtered_[static_cast<Eigen::Index>(k)]});
  c.values.push_back({"largest [sigma]", std::abs(in_sigma)});
  c.values.push_back({"latency [s]", t - wrench_t_ + delay_s()});
}

void Monitor::assess_motors(double t) {
  Check& c = checks_[1];
  c.values.clear();
  if (released_ < 0 || t - motor_t_ > kForgotten) {
    c.level = released_ < 0 ? Level::ok : Level::stale;
    c.message = released_ < 0 ? "held, not judged" : "no commands or no rotor telemetry";
    return;
  }
  Eigen::Index worst = 0;
  deviation_.cwiseAbs().maxCoeff(&worst);
  bool warn = false, error = false;
  for (std::size_t k = 0; k < rotors_; ++k) {
    warn = warn || motor_warn_[k].on();
    error = error || motor_error_[k].on();
    c.values.push_back({"rotor" + std::to_string(k + 1) + " [rad/s]",
                        deviation_[static_cast<Eigen::Index>(k)] * vehicle_.rotors[k].max_speed()});
  }
  c.level = of(warn, error);
  c.message =
      format("rotor %d differs most from the nominal lag of its command: %+.1f %% of its largest speed",
             static_cast<int>(worst) + 1, 100 * deviation_[worst]);
  c.values.push_back({"latency [s]", t - motor_t_ + motor_filter_.delay_s()});
}

void Monitor::assess_sensors(double t, bool free) {
  Check& c = checks_[2];
  c.values.clear();
  c.level = Level::ok;
  c.message.clear();
  const auto say = [&](Level level, const std::string& what) {
    c.level = std::max(c.level, level);
    c.message += (c.message.empty() ? "" : "; ") + what;
  };
  const auto look = [&](const char* name, double last, double limit) {
    const bool never = !(last >= 0);
    const double age = never ? 1e3 : std::max(0.0, t - last);
    c.values.push_back({std::string(name) + " age [s]", age});
    if (never)
      say(free ? Level::error : Level::stale, std::string("no ") + name);
    else if (age > limit)
      say(age > 4 * limit ? Level::error : Level::warn, format("%s is %.2f s old", name, age));
  };
  look("imu", imu_.last(), options_.imu_stale_s);
  look("mocap", mocap_t_, options_.mocap_stale_s);
  look("rotors", rotor_.last(), options_.rotors_stale_s);
  const double frozen = mocap_t_ - mocap_changed_;
  c.values.push_back({"mocap unchanged for [s]", frozen});
  if (free && frozen > options_.mocap_frozen_s)
    say(Level::warn, format("mocap has repeated one pose for %.2f s", frozen));
  if (c.message.empty()) c.message = "all fresh";
}

const std::array<Check, 3>& Monitor::assess(double t, bool free) {
  if (!free) {
    if (released_ >= 0) start_anew();
    released_ = -1;
    for (SampleLine* line : {&imu_, &rotor_, &command_}) line->forget_before(t - 0.5);
  } else {
    if (released_ < 0) released_ = t;
    advance_motors(t);
    advance_wrench(t);
    rotor_.forget_before(std::min(next_ < 0 ? t : next_, motor_next_ < 0 ? t : motor_next_) - 0.1);
  }
  assess_wrench(t);
  assess_motors(t);
  assess_sensors(t, free);
  return checks_;
}

}  // namespace omniflight::diagnosis
