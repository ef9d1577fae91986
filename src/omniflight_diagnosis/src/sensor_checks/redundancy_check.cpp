#include "redundancy_check.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "../conditioning/quantisation.hpp"
#include "../numerics/log_factor.hpp"
#include "../numerics/statistics.hpp"
#include "../numerics/text.hpp"
#include "findings.hpp"
#include "omniflight_core/frames.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_physics/effect_ids.hpp"
#include "rotor_limit_check.hpp"
#include "tilt_lag.hpp"
#include "vibration_check.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

// Chosen, not measured.
constexpr double kSpeedBlock = 3.0;    // s, block whose mean is one observation
constexpr double kSurely = 5;          // standard errors
constexpr double kLeastGain = 0.0012;  // relative speed error that timing of the telemetry may cause
constexpr double kLeastServo = 0.02;   // s, delay of telemetry and clocks that is not taken for a servo lag

/// Mean with standard error and standard deviation of the observations.
struct Estimate {
  double value = 0, se = 1e9, scatter = 1e9;
  bool is_not(double other, double least) const {
    return std::abs(value - other) > std::max(kSurely * se, least);
  }
};

Estimate mean_of(const std::vector<double>& x) {
  Estimate out;
  if (x.size() < 4) return out;
  const auto n = static_cast<double>(x.size());
  double squares = 0;
  for (double v : x) out.value += v / n;
  for (double v : x) squares += (v - out.value) * (v - out.value);
  out.scatter = std::sqrt(squares / (n - 1));
  out.se = out.scatter / std::sqrt(n);
  return out;
}

ParameterValue value_of(const char* name, const char* symbol, const char* unit, const Estimate& e) {
  return {name, symbol, unit, e.value, e.value - 1.96 * e.se, e.value + 1.96 * e.se};
}

/// Decrease of a fitted straight line from the first to the last element.
Estimate fall_of(const std::vector<double>& x) {
  const auto n = static_cast<Eigen::Index>(x.size());
  if (n < 5) return {};
  Eigen::MatrixXd A(n, 2);
  A << Eigen::VectorXd::Ones(n), Eigen::VectorXd::LinSpaced(n, 0, 1);
  const Eigen::Map<const Eigen::VectorXd> y(x.data(), n);
  const Eigen::Matrix2d inverse = (A.transpose() * A).inverse();
  const Eigen::Vector2d line = inverse * A.transpose() * y;
  const double scatter = (y - A * line).norm() / std::sqrt(static_cast<double>(n - 2));
  return {-line[1], scatter * std::sqrt(inverse(1, 1)), scatter};
}

/// Mean of speed over command of one rotor, and its decrease during the flight.
struct SpeedGain : Estimate {
  Estimate falls;
};

/// For every rotor, over blocks in which it neither reverses nor nearly stops.
std::vector<SpeedGain> speed_gains(const Signal& speed, const Signal& command) {
  std::vector<SpeedGain> out;
  const Eigen::MatrixXd ordered = recording::resample(command, speed.t_s, 0.1);
  const auto n = static_cast<std::size_t>(speed.values.rows());
  for (Eigen::Index r = 0; r < speed.values.cols(); ++r) {
    std::vector<double> gains;
    for (std::size_t i = 0; i < n;) {
      double turned = 0, asked = 0, low = 1e300, high = -1e300;
      std::size_t j = i;
      for (; j < n && speed.t_s[j] < speed.t_s[i] + kSpeedBlock; ++j) {
        const double u = ordered(static_cast<Eigen::Index>(j), r);
        const double w = speed.values(static_cast<Eigen::Index>(j), r);
        if (!std::isfinite(u) || !std::isfinite(w)) continue;
        turned += w, asked += u;
        low = std::min({low, u, w}), high = std::max({high, u, w});
      }
      const bool whole = j < n && j - i > 50 && low * high > 0 && speed.t_s[i] > speed.t_s.front() + 1;
      const double slowest = std::min(std::abs(low), std::abs(high));
      if (whole && slowest > 0.3 * std::max(std::abs(low), std::abs(high))) gains.push_back(turned / asked);
      i = std::max(j, i + 1);
    }
    SpeedGain g;
    static_cast<Estimate&>(g) = mean_of(gains);
    g.falls = fall_of(gains);
    out.push_back(g);
  }
  return out;
}

/// Marks the last finding as indistinguishable from `rival`.
void leave_open(Diagnosis& d, const char* rival) {
  d.findings.back().cannot_be_told_apart_from = {rival};
  d.findings.back().rivals = 1;
}

void judge_steps(const Recording& r, Diagnosis& d) {
  const auto step = speed_step(r);
  if (!step) return;
  add_sensor(
      d, physics::effect_id::command_quantisation, "rotor_speed", "rad/s",
      format("The rotors keep to speeds %.3g rad/s apart, or their telemetry does; their commands do not.",
             *step),
      {{"step", "q", "rad/s", *step, 0.98 * *step, 1.02 * *step}}, *step / std::sqrt(12.0), 0.01 * *step);
}

void judge_speeds(const Recording& r, Diagnosis& d) {
  const Signal *speed = r.find("rotor_speed"), *command = r.find("rotor_command");
  if (!speed || !command || speed->empty() || command->empty() || speed->width() != command->width()) return;
  const std::vector<SpeedGain> gains = speed_gains(*speed, *command);
  std::vector<double> known;
  for (const Estimate& g : gains)
    if (g.se < 1) known.push_back(g.value);
  if (known.size() < 3) return;
  const double common = median(known);
  int odd = 0, slow = 0, sinking = 0, last = -1;
  double se = 0;
  for (std::size_t k = 0; k < gains.size(); ++k) {
    if (gains[k].se >= 1) continue;
    if (gains[k].is_not(common, kLeastGain)) ++odd, last = static_cast<int>(k);
    if (gains[k].is_not(1, kLeastGain) && gains[k].value < 1) ++slow;
    if (gains[k].falls.is_not(0, 0) && gains[k].falls.value > 0) ++sinking;
    se = std::max(se, gains[k].se);
  }
  if (2 * slow > static_cast<int>(known.size()) && common < 1 - kLeastGain) {
    // a battery discharges, whereas a scale error of the telemetry is constant
    const bool empties = 2 * sinking > static_cast<int>(known.size());
    add_sensor(d, physics::effect_id::battery_sag, "rotor_speed", "1",
               format("The rotors turn %.2f %% slower than they were ordered to, %s", 100 * (1 - common),
                      empties ? "and ever more so, as on a battery that gives way."
                              : "as on a battery that gives way, or by a telemetry that reads low."),
               {}, 1 - common, se);
    d.findings.back().log_factor = log_factor_of_size(1 - common, se, 1 - common);
    if (!empties) leave_open(d, physics::effect_id::rotor_speed_sensor_fault);
  }
  if (odd == 1) {
    const Estimate& g = gains[static_cast<std::size_t>(last)];
    const Estimate scale{g.value / common - 1, g.se, g.scatter};
    add_sensor(
        d, physics::effect_id::rotor_speed_sensor_fault, "rotor_speed", "1",
        format("Rotor %d turns %.2f %% %s than ordered by its own telemetry, the others do not: its sensor, "
               "or its motor.",
               last + 1, 100 * std::abs(scale.value), scale.value < 0 ? "slower" : "faster"),
        {{"rotor", "k", "1", last + 1.0, last + 1.0, last + 1.0}, value_of("scale", "e", "1", scale)},
        std::abs(scale.value), g.se);
  }
}

/// Exponent c of the battery voltage in the speed of rotor r: ln speed = a + b ln duty + c ln voltage, on
/// means over 0.5 s. Empty where the voltage hardly varies independently of the duty cycle.
std::optional<double> voltage_exponent(const Signal& speed, const Eigen::MatrixXd& duty,
                                       const Eigen::MatrixXd& voltage, Eigen::Index r) {
  // Chosen: s; least RMS of ln voltage after regression on ln duty.
  constexpr double kMean = 0.5, kMoves = 0.001;
  std::vector<Vec3> rows;  // ln of speed, duty, voltage
  for (std::size_t i = 0; i < speed.t_s.size();) {
    Vec3 sum = Vec3::Zero();
    std::size_t j = i;
    bool turns = true;
    for (; j < speed.t_s.size() && speed.t_s[j] < speed.t_s[i] + kMean; ++j) {
      const auto row = static_cast<Eigen::Index>(j);
      const Vec3 now(speed.values(row, r), duty(row, r), voltage(row, 0));
      turns = turns && now.allFinite() && (now.array() > 0).all();
      sum += now;
    }
    if (turns && j - i > 20 && speed.t_s[j - 1] - speed.t_s[i] > 0.8 * kMean)
      rows.push_back((sum / static_cast<double>(j - i)).array().log().matrix());
    i = std::max(j, i + 1);
  }
  if (rows.size() < 16) return std::nullopt;
  Eigen::MatrixXd X(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t k = 0; k < rows.size(); ++k) X.row(static_cast<Eigen::Index>(k)) = rows[k].transpose();
  X.rowwise() -= X.colwise().mean().eval();
  const double duties = X.col(1).squaredNorm();
  if (!(duties > 0)) return std::nullopt;
  const Eigen::VectorXd own = X.col(2) - X.col(1).dot(X.col(2)) / duties * X.col(1);
  if (own.squaredNorm() < kMoves * kMoves * static_cast<double>(rows.size())) return std::nullopt;
  return own.dot(X.col(0)) / own.squaredNorm();
}

void judge_voltage(const Recording& r, Diagnosis& d) {
  const Signal *speed = r.find("rotor_speed"), *duty = r.find("pwm"), *voltage = r.find("vbat");
  if (!speed || !duty || !voltage || speed->empty() || duty->empty() || voltage->empty()) return;
  if (speed->width() != duty->width() || r.find("rotor_command")) return;
  const Eigen::MatrixXd u = recording::resample(*duty, speed->t_s, 0.1);
  const Eigen::MatrixXd v = recording::resample(*voltage, speed->t_s, 0.5);
  std::vector<double> exponents;
  for (Eigen::Index k = 0; k < speed->width(); ++k)
    if (const auto c = voltage_exponent(*speed, u, v, k)) exponents.push_back(*c);
  const Estimate open_loop = mean_of(exponents);  // one observation per rotor
  if (!open_loop.is_not(0, 0.3)) return;
  add_sensor(
      d, physics::effect_id::battery_sag, "rotor_speed", "1",
      format(
          "Speeds follow duty cycle times the battery's voltage to the power %.2f: a model from duty cycle "
          "to speed needs the voltage.",
          open_loop.value),
      {value_of("open_loop", "o", "1", open_loop)}, open_loop.value, open_loop.se);
}

void judge_tilt(const Recording& r, const vehicle::Tilt& servo, Diagnosis& d) {
  const TiltLags lags = tilt_lags(r, servo, kSpeedBlock);
  const Estimate lag = mean_of(lags.lag);
  if (!lag.is_not(lags.told, kLeastServo)) return;
  Estimate beyond = lag;  // the effect is an addition to the lag of the vehicle file
  beyond.value -= lags.told;
  const std::string text =
      lags.told > 0
          ? format("The tilt follows its command %.0f ms late, %.0f ms %s than the vehicle file says.",
                   1e3 * lag.value, 1e3 * std::abs(beyond.value), beyond.value > 0 ? "later" : "sooner")
          : format("The tilt follows its command %.0f ms late, the vehicle file has no such lag.",
                   1e3 * lag.value);
  add_sensor(d, physics::effect_id::tilt_servo_lag, "alpha", "s", text,
             {value_of("time_constant", "tau_a", "s", beyond)}, std::abs(beyond.value), beyond.se);
}

/// Gyro bias of one axis: intercept of the block means `off` (gyro minus attitude rate) over the mean rates
/// `turned` (blocks x 3), which absorb scale and misalignment with prior deviation kSkewed.
Estimate at_rest(const Eigen::VectorXd& off, const Eigen::MatrixXd& turned) {
  constexpr double kSkewed = 0.03;  // 1 or rad; chosen
  constexpr Eigen::Index kUnknowns = 4;
  Estimate out;
  if (off.size() < 2 * kUnknowns) return out;
  Eigen::MatrixXd X(off.size(), kUnknowns);
  X << Eigen::VectorXd::Ones(off.size()), turned;
  const double spread = (off.array() - off.mean()).matrix().squaredNorm() / static_cast<double>(off.size());
  Eigen::MatrixXd H = X.transpose() * X;
  H.diagonal().tail(3).array() += std::max(spread, 1e-16) / (kSkewed * kSkewed);
  const Eigen::LDLT<Eigen::MatrixXd> solver(H);
  const Eigen::VectorXd x = solver.solve(X.transpose() * off);
  const Eigen::VectorXd one = solver.solve(Eigen::VectorXd::Unit(kUnknowns, 0));
  out.value = x[0];
  out.scatter = std::sqrt((off - X * x).squaredNorm() / static_cast<double>(off.size() - kUnknowns));
  out.se = out.scatter * std::sqrt(one[0]);
  return out;
}

void judge_gyro(const Recording& r, const Options& o, Diagnosis& d) {
  const Signal *gyro = r.find("gyro"), *attitude = r.find("attitude");
  if (!gyro || !attitude || gyro->width() != 3 || attitude->width() != 4) return;
  if (gyro->size() < 100 || attitude->size() < 100) return;
  const auto at = [&](Eigen::Index i) {
    const auto q = attitude->values.row(i);
    return Quat(q[0], q[1], q[2], q[3]).normalized();
  };
  const Eigen::MatrixXd rate = recording::resample(*gyro, attitude->t_s, 0.1);
  std::vector<Vec3> off, mean_rate;
  const Eigen::Index n = attitude->values.rows();
  for (Eigen::Index i = 1; i + 1 < n;) {
    Vec3 sum = Vec3::Zero(), turning = Vec3::Zero();
    int count = 0;
    const double from = attitude->t_s[static_cast<std::size_t>(i)];
    Eigen::Index j = i;
    for (; j + 1 < n && attitude->t_s[static_cast<std::size_t>(j)] < from + kSpeedBlock; ++j) {
      const double dt =
          attitude->t_s[static_cast<std::size_t>(j) + 1] - attitude->t_s[static_cast<std::size_t>(j) - 1];
      if (!(dt > 0 && dt < 0.1) || !rate.row(j).allFinite() || !attitude->values.row(j - 1).allFinite() ||
          !attitude->values.row(j + 1).allFinite())
        continue;
      const Vec3 turned = log_rotation(at(j - 1).conjugate() * at(j + 1)) / dt;
      sum += Vec3(rate.row(j)) - turned;
      turning += turned;
      ++count;
    }
    if (count > 50) {
      off.emplace_back(sum / count);
      mean_rate.emplace_back(turning / count);
    }
    i = std::max(j, i + 1);
  }
  const auto blocks = static_cast<Eigen::Index>(off.size());
  Eigen::MatrixXd all_off(blocks, 3), rates(blocks, 3);
  for (Eigen::Index k = 0; k < blocks; ++k) {
    all_off.row(k) = off[static_cast<std::size_t>(k)].transpose();
    rates.row(k) = mean_rate[static_cast<std::size_t>(k)].transpose();
  }
  static constexpr const char* kNames[] = {"bias_x", "bias_y", "bias_z"};
  static constexpr const char* kSymbols[] = {"b_x", "b_y", "b_z"};
  std::vector<ParameterValue> parameters;
  double largest = 0, noise = 1e-9, from_told = 0;
  bool seen = false;
  for (std::size_t c = 0; c < 3; ++c) {
    const Estimate b = at_rest(all_off.col(static_cast<Eigen::Index>(c)), rates);
    seen = seen || b.is_not(0, 3 * b.scatter);  // a bias is constant: it exceeds the scatter of the blocks
    from_told += b.value * b.value / (b.se * b.se + o.tolerance.gyro_bias * o.tolerance.gyro_bias);
    parameters.push_back(value_of(kNames[c], kSymbols[c], "rad/s", b));
    if (std::abs(b.value) > largest) largest = std::abs(b.value), noise = b.se;
  }
  if (seen && from_told > chi_squared_quantile(kBeyondTold, 3))
    add_sensor(d, physics::effect_id::gyro_error, "gyro", "rad/s",
               format("The gyro is off by up to %.2g rad/s against the measured attitude.", largest),
               std::move(parameters), largest, noise);
}

}  // namespace

void check_redundancy(const Recording& r, const vehicle::Vehicle& vehicle, const Options& o, Diagnosis& d) {
  if (!is_named(d, physics::effect_id::command_quantisation)) judge_steps(r, d);
  add_rotor_limits(r, vehicle, d);
  if (!is_named(d, physics::effect_id::rotor_speed_sensor_fault) &&
      !is_named(d, physics::effect_id::actuator_saturation))
    judge_speeds(r, d);
  if (vehicle.tilt.kind != vehicle::TiltKind::none && !is_named(d, physics::effect_id::tilt_servo_lag))
    judge_tilt(r, vehicle.tilt, d);
  judge_gyro(r, o, d);
  add_vibration(r, vehicle, o, d);
  if (!is_named(d, physics::effect_id::battery_sag)) judge_voltage(r, d);
}

void add_kinematics(const Kinematics& kinematics, Diagnosis& d) {
  for (const Kinematics::Part& part : kinematics.parts) {
    const physics::Effect* effect = physics::find_effect(part.effect);
    if (!effect) continue;
    const auto& parameters = effect->info().parameters;
    std::vector<ParameterValue> values;
    std::string text;
    Eigen::Index largest = 0;
    for (Eigen::Index k = 0; k < part.value.size(); ++k) {
      const physics::Parameter& p = parameters[static_cast<std::size_t>(k)];
      values.push_back(value_of(p.name.c_str(), p.symbol.c_str(), p.unit.c_str(),
                                {part.value[k], part.se[k], part.se[k]}));
      text += format("%s%s %.3g %s", k > 0 ? ", " : "", p.name.c_str(), part.value[k], p.unit.c_str());
      if (std::abs(part.value[k]) > std::abs(part.value[largest])) largest = k;
    }
    add_sensor(d, part.effect.c_str(), part.effect == physics::effect_id::mocap_tilt ? "position" : "acc",
               parameters.front().unit.c_str(),
               format("The accelerometer and the measured position do not tell of one motion; %s: %s.",
                      effect->info().term.c_str(), text.c_str()),
               std::move(values), std::abs(part.value[largest]), part.se[largest]);
    Finding& f = d.findings.back();
    f.cannot_be_told_apart_from = part.as_well;
    f.rivals = static_cast<int>(part.as_well.size());
    for (const std::string& other : part.as_well) d.next_flight.separates.emplace_back(part.effect, other);
    if (f.rivals > 0) d.next_flight.manoeuvres.push_back(effect->info().separated_by);
  }
}

}  // namespace omniflight::diagnosis
