#include "sensor_faults.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "../numerics/log_factor.hpp"
#include "../numerics/statistics.hpp"
#include "omniflight_physics/effect_ids.hpp"
#include "quantisation.hpp"
#include "rotor_limits.hpp"

namespace omniflight::diagnosis {
namespace {

/// True where a column keeps exactly one value for longer than `hold_s`.
std::vector<char> stuck(const recording::Signal& s, Eigen::Index column, double hold_s) {
  const Eigen::Index n = s.size();
  std::vector<char> out(static_cast<std::size_t>(n), 0);
  for (Eigen::Index i = 0; i < n;) {
    Eigen::Index j = i;
    while (j < n && s.values(j, column) == s.values(i, column)) ++j;
    const double length = s.t_s[static_cast<std::size_t>(j - 1)] - s.t_s[static_cast<std::size_t>(i)];
    if (length > hold_s) std::fill(out.begin() + i, out.begin() + j, 1);
    i = j;
  }
  return out;
}

/// Least nonzero speed [rad/s] of any rotor: telemetry that times revolutions reads zero below.
double slowest_reading(const recording::Signal& speed) {
  double least = 1e300;
  for (Eigen::Index c = 0; c < speed.width(); ++c)
    for (Eigen::Index i = 0; i < speed.size(); ++i)
      if (const double s = std::abs(speed.values(i, c)); s > 0) least = std::min(least, s);
  return least;
}

/// Flags of the samples at which a constant speed is legitimate: the command is constant as well, or it is
/// below the least speed that the telemetry reads.
std::vector<char> obeys(const recording::Recording& r, const recording::Signal& speed, Eigen::Index column,
                        const std::vector<char>& still) {
  // Chosen: settling time [s] of a motor; relative range of a constant command; command over least reading.
  constexpr double kLag = 0.1, kStill = 2e-3;
  constexpr double kUnread = 1.25;
  const recording::Signal* command = r.find("rotor_command");
  if (!command) command = r.find("pwm");
  std::vector<char> out(still.size(), 0);
  if (!command || command->width() != speed.width()) return out;
  const Eigen::MatrixXd asked = recording::resample(*command, speed.t_s, kLag);
  const double slowest = r.find("rotor_command") ? slowest_reading(speed) : 0.0;
  for (std::size_t i = 0; i < still.size();) {
    std::size_t j = i;
    double low = 1e300, high = -1e300;
    for (; j < still.size() && still[j] == still[i]; ++j) {
      if (speed.t_s[j] < speed.t_s[i] + kLag) continue;
      const double value = asked(static_cast<Eigen::Index>(j), column);
      low = std::min(low, value), high = std::max(high, value);
    }
    if (still[i] && low <= high && high - low <= kStill * std::abs(high))
      std::fill(out.begin() + static_cast<std::ptrdiff_t>(i), out.begin() + static_cast<std::ptrdiff_t>(j),
                1);
    i = j;
  }
  for (std::size_t i = 0; i < still.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (still[i] && speed.values(k, column) == 0 && std::abs(asked(k, column)) < kUnread * slowest)
      out[i] = 1;
  }
  return out;
}

/// Median of speed over duty cycle [rad/s] of a running rotor; 0 with fewer than 50 samples.
double speed_over_duty(const recording::Signal& speed, const Eigen::MatrixXd& duty, Eigen::Index rotor) {
  std::vector<double> ratio;
  for (Eigen::Index i = 0; i < speed.size(); ++i)
    if (duty(i, rotor) > 0.05) ratio.push_back(std::abs(speed.values(i, rotor)) / duty(i, rotor));
  if (ratio.size() < 50) return 0;
  return median(std::move(ratio));
}

/// Adds rotors whose speed at a duty cycle deviates from the median rotor by more than motors of one type
/// differ.
void compare_with_duty(const recording::Recording& r, std::vector<SensorFault>& faults) {
  constexpr double kMotorsDiffer = 0.3;  // relative, three standard deviations; chosen
  const recording::Signal *speed = r.find("rotor_speed"), *pwm = r.find("pwm");
  if (!speed || !pwm || speed->width() < 3 || speed->width() != pwm->width() || r.find("rotor_command"))
    return;
  const Eigen::MatrixXd duty = recording::resample(*pwm, speed->t_s, 0.1);
  std::vector<double> ratio;
  for (Eigen::Index c = 0; c < speed->width(); ++c) ratio.push_back(speed_over_duty(*speed, duty, c));
  std::vector<double> sorted = ratio;
  std::sort(sorted.begin(), sorted.end());
  const double usual = sorted[sorted.size() / 2];
  if (!(sorted.front() > 0)) return;
  for (std::size_t c = 0; c < ratio.size(); ++c) {
    const double e = ratio[c] / usual - 1;
    const std::string name = "rotor" + std::to_string(c + 1) + "_speed";
    if (std::abs(e) < kMotorsDiffer ||
        std::any_of(faults.begin(), faults.end(), [&](const SensorFault& f) { return f.channel == name; }))
      continue;
    faults.push_back({physics::effect_id::rotor_speed_sensor_fault, name,
                      "The speed of rotor " + std::to_string(c + 1) + " reads " +
                          std::to_string(static_cast<int>(std::lround(100 * (1 + e)))) +
                          " % of what its duty cycle gives on the other rotors: its sensor's scale is wrong.",
                      1.0, log_factor_of_size(e, kMotorsDiffer / 3, std::abs(e))});
  }
}

/// Whether the load on the battery varied: standard deviation of the summed drive above 0.5 % (chosen).
bool varies(const recording::Signal* drive) {
  if (!drive || drive->size() < 50) return false;
  const Eigen::VectorXd sum = drive->values.cwiseAbs().rowwise().sum();
  const double spread =
      (sum.array() - sum.mean()).matrix().norm() / std::sqrt(static_cast<double>(sum.size()));
  return spread > 0.005 * sum.mean();
}

}  // namespace

bool voltage_never_changes(const recording::Recording& r) {
  const recording::Signal* vbat = r.find("vbat");
  return vbat && vbat->size() > 50 && vbat->t_s.back() - vbat->t_s.front() > 3.0 &&
         vbat->values.maxCoeff() - vbat->values.minCoeff() < 1e-6;
}

std::vector<SensorFault> find_sensor_faults(const recording::Recording& recording) {
  std::vector<SensorFault> faults;
  if (const recording::Signal* speed = recording.find("rotor_speed"); speed && speed->width() >= 2) {
    const RotorLimits limits = rotor_limits(recording);  // a rotor at a limit is no sensor fault
    std::vector<std::vector<char>> columns;
    for (Eigen::Index c = 0; c < speed->width(); ++c) columns.push_back(stuck(*speed, c, 0.2));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const std::vector<char> asked = obeys(recording, *speed, static_cast<Eigen::Index>(c), columns[c]);
      int bad = 0;  // stuck while at least half of the others move
      for (std::size_t i = 0; i < columns[c].size(); ++i) {
        if (!columns[c][i] || asked[i] || (!limits.held.empty() && limits.held[c][i])) continue;
        std::size_t moving = 0;
        for (const auto& other : columns) moving += !other[i];
        bad += 2 * moving >= columns.size() - 1;
      }
      const double share = static_cast<double>(bad) / static_cast<double>(columns[c].size());
      if (share < 0.02) continue;
      const std::string name = "rotor" + std::to_string(c + 1) + "_speed";
      faults.push_back({physics::effect_id::rotor_speed_sensor_fault, name,
                        "The speed of rotor " + std::to_string(c + 1) + " stands still for " +
                            std::to_string(static_cast<int>(std::lround(100 * share))) +
                            " % of the flight while the other rotors move: its sensor is stuck.",
                        share, log_factor_of_repeats(bad)});
    }
  }
  // quantised speeds are constant between steps, on most rotors: no sensor fault
  const recording::Signal* all = recording.find("rotor_speed");
  const bool most = all && 2 * static_cast<Eigen::Index>(faults.size()) > all->width();
  if (!faults.empty() && (most || speed_step(recording))) faults.clear();
  compare_with_duty(recording, faults);
  const bool by_duty = varies(recording.find("pwm")) || varies(recording.find("motor_power"));
  if (voltage_never_changes(recording) && (by_duty || varies(recording.find("rotor_speed")))) {
    const recording::Signal& vbat = *recording.find("vbat");
    const std::string span = std::to_string(static_cast<int>(vbat.t_s.back() - vbat.t_s.front()));
    // With closed-loop speed control on a regulated supply the voltage may well be constant: then it is a
    // rival.
    faults.push_back(
        {physics::effect_id::battery_sensor_fault,
         "vbat",
         "The battery voltage never changes in " + span +
             " s of flight, whatever the motors draw: its sensor is frozen" +
             (by_duty ? "." : ", or a supply holds it to the last digit."),
         1.0,
         log_factor_of_repeats(vbat.size()),
         {},
         by_duty ? std::vector<std::string>{} : std::vector<std::string>{"a supply on the ground"}});
  }
  return faults;
}

std::vector<char> frozen_samples(const recording::Signal& rotor_speed, const std::string& channel,
                                 const std::vector<double>& t_s) {
  std::vector<char> out(t_s.size(), 0);
  const int rotor = channel.size() > 5 ? std::atoi(channel.c_str() + 5) - 1 : -1;
  if (rotor < 0 || rotor >= rotor_speed.width()) return out;
  const std::vector<char> bad = stuck(rotor_speed, rotor, 0.2);
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    const auto next = std::lower_bound(rotor_speed.t_s.begin(), rotor_speed.t_s.end(), t_s[i]);
    const auto k =
        std::min<std::ptrdiff_t>(next - rotor_speed.t_s.begin(), static_cast<std::ptrdiff_t>(bad.size()) - 1);
    out[i] = bad[static_cast<std::size_t>(k)];
  }
  return out;
}

}  // namespace omniflight::diagnosis
