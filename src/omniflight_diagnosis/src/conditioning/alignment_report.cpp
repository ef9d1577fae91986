#include "omniflight_diagnosis/alignment_report.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "attitude_rows.hpp"
#include "decimate.hpp"
#include "omniflight_recording/alignment.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

// Chosen, not measured. Lags of motors, radios and filters stay within kUsualReach; only a clock error
// exceeds it.
constexpr double kUsualReach = 0.2, kFarReach = 2.0;  // s, half widths of the normal and of the wide search
constexpr double kSlowPeriod = 0.04;                  // s, sample period of the wide search
constexpr double kLeast = 0.6;                        // least correlation of a lag that is reported
// Correlation above which no wide search is made, and gain in correlation that it must bring.
constexpr double kClear = 0.8, kClearer = 0.15;

Signal derivative(const Signal& s) {
  Signal out = s;
  const Eigen::Index n = s.size() - 1;
  out.t_s.resize(static_cast<std::size_t>(std::max<Eigen::Index>(0, n)));
  out.values.resize(std::max<Eigen::Index>(0, n), s.width());
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    out.t_s[k] = 0.5 * (s.t_s[k] + s.t_s[k + 1]);
    out.values.row(i) = (s.values.row(i + 1) - s.values.row(i)) / (s.t_s[k + 1] - s.t_s[k]);
  }
  return out;
}

/// Acceleration [m/s^2, world] from specific force and attitude.
Signal world_acceleration(const Signal& acc, const Signal& attitude) {
  Signal out = acc;
  const Eigen::MatrixXd q = recording::resample(attitude, acc.t_s, 0.1);
  Eigen::Index m = 0;
  out.t_s.clear();
  for (Eigen::Index i = 0; i < acc.size(); ++i) {
    if (!q.row(i).allFinite()) continue;
    Vec3 a = quaternion(q, i) * Vec3(acc.values.row(i));
    a.z() -= kGravity;
    out.values.row(m++) = a.transpose();
    out.t_s.push_back(acc.t_s[static_cast<std::size_t>(i)]);
  }
  out.values.conservativeResize(m, Eigen::NoChange);
  return out;
}

Signal only(const Signal& s, Eigen::Index column) {
  Signal out = s;
  out.values = s.values.col(column);
  return out;
}

/// Sum of squares of the speeds: proportional to thrust where all rotors are alike.
Signal total_thrust(const Signal& speed) {
  Signal out = speed;
  out.values = speed.values.rowwise().squaredNorm();
  return out;
}

/// Signal minus its moving average over 1 s: offsets and drifts carry no information on the lag.
Signal quick_part(const Signal& s) {
  Signal out = s;
  const auto half =
      std::max<Eigen::Index>(2, static_cast<Eigen::Index>(0.5 / std::max(1e-4, s.median_period_s())));
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(s.size() + 1, s.width());
  for (Eigen::Index i = 0; i < s.size(); ++i) sum.row(i + 1) = sum.row(i) + s.values.row(i);
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    const Eigen::Index a = std::max<Eigen::Index>(0, i - half), b = std::min(s.size(), i + half + 1);
    out.values.row(i) -= (sum.row(b) - sum.row(a)) / static_cast<double>(b - a);
  }
  return out;
}

/// A lag beyond kUsualReach at which the decimated signals correlate better, by kClearer, than at `usual`.
std::optional<recording::LagEstimate> far_lag(const Signal& a, const Signal& b, double usual) {
  const Signal x = quick_part(decimate(a, kSlowPeriod)), y = quick_part(decimate(b, kSlowPeriod));
  const auto far = recording::estimate_lag(x, y, {.max_lag_s = kFarReach, .same_sign = true});
  if (!far || !(std::abs(far->lag_s) > kUsualReach)) return std::nullopt;
  // a periodic motion correlates at several lags: the second-best peak (rival) must be clearly lower
  if (!(far->correlation > std::max(kLeast, std::max(usual, far->rival) + kClearer))) return std::nullopt;
  return *far;
}

void compare(const Signal& a, const Signal& b, const std::string& early, const std::string& late,
             std::vector<Alignment>& out) {
  if (a.size() < 100 || b.size() < 100) return;
  const double period = std::clamp(std::max(a.median_period_s(), b.median_period_s()), 0.004, 0.05);
  Signal x = quick_part(decimate(a, period)), y = quick_part(decimate(b, period));
  auto whole = recording::estimate_lag(x, y, {.max_lag_s = kUsualReach});
  const double usual = whole ? std::abs(whole->correlation) : 0;
  if (const auto far = usual < kClear ? far_lag(a, b, usual) : std::nullopt) {
    Signal moved = y;
    for (double& t : moved.t_s) t -= far->lag_s;
    const auto near = recording::estimate_lag(x, moved, {.max_lag_s = kUsualReach});
    if (near && std::abs(near->correlation) > kLeast) {
      whole = near;
      whole->lag_s += far->lag_s;
    } else {  // only the decimated signals correlate: keep their lag, with the error of their resolution
      x = quick_part(decimate(a, kSlowPeriod));
      y = quick_part(decimate(b, kSlowPeriod));
      whole = *far;
      whole->standard_error_s = std::hypot(whole->standard_error_s, kSlowPeriod / std::sqrt(12.0));
    }
  }
  if (!whole || !(std::abs(whole->correlation) > kLeast)) return;
  Alignment r{early, late, whole->lag_s, whole->standard_error_s, 0, 0, whole->correlation, 0};
  for (double& t : y.t_s) t -= whole->lag_s;
  const double from = std::max(x.t_s.front(), y.t_s.front()), to = std::min(x.t_s.back(), y.t_s.back());
  std::vector<std::array<double, 3>> windows;  // time, lag, weight
  for (double t = from; t + 5.0 <= to; t += 5.0) {
    const auto part = recording::estimate_lag(x, y, {.max_lag_s = kUsualReach, .from_s = t, .to_s = t + 5.0});
    if (!part || !(std::abs(part->correlation) > 0.4)) continue;
    windows.push_back(
        {t + 2.5, whole->lag_s + part->lag_s, 1.0 / std::pow(std::max(2e-4, part->standard_error_s), 2)});
  }
  if (windows.size() >= 4) {
    double w = 0, wt = 0, wl = 0;
    for (const auto& [t, lag, weight] : windows) w += weight, wt += weight * t, wl += weight * lag;
    double tt = 0, tl = 0, chi = 0;
    for (const auto& [t, lag, weight] : windows)
      tt += weight * std::pow(t - wt / w, 2), tl += weight * (t - wt / w) * (lag - wl / w);
    r.skew = tl / tt;
    r.at_s = wt / w;
    for (const auto& [t, lag, weight] : windows)
      chi += weight * std::pow(lag - wl / w - r.skew * (t - wt / w), 2);
    // scale the standard errors by the scatter of the windows where it exceeds their own errors
    const double scatter = std::max(1.0, chi / static_cast<double>(windows.size() - 2));
    r.skew_se = std::sqrt(scatter / tt);
    r.lag_se = std::max(r.lag_se, std::sqrt(scatter / w));
  }
  out.push_back(r);
}

}  // namespace

std::vector<Alignment> align_signals(const Recording& r) {
  std::vector<Alignment> out;
  const Signal *gyro = r.find("gyro"), *acc = r.find("acc"), *speed = r.find("rotor_speed");
  const Signal* attitude = r.find("attitude");
  const Signal* known = attitude ? attitude : r.find("est_attitude");
  for (const char* name : {"attitude", "est_attitude"})
    if (const Signal* q = r.find(name); gyro && q)
      compare(*gyro, recording::rate_of_attitude(*q), "gyro", name, out);
  const Signal *place = r.find("position"), *believed = r.find("est_position");
  if (place && believed && place->width() == 3 && believed->width() == 3)
    compare(derivative(*believed), derivative(*place), "est_position", "position", out);
  if (acc && known) {
    const Signal a = world_acceleration(*acc, *known);
    for (const char* name : {"velocity", "est_velocity"})
      if (const Signal* v = r.find(name); v && v->width() == 3) compare(a, derivative(*v), "acc", name, out);
  }
  for (const char* name : {"rotor_command", "pwm"})
    if (const Signal* u = r.find(name); u && speed && u->width() == speed->width()) {
      compare(*u, *speed, name, "rotor_speed", out);
      break;
    }
  if (acc && speed) compare(only(*acc, 2), total_thrust(*speed), "acc", "rotor_speed (thrust)", out);
  return out;
}

}  // namespace omniflight::diagnosis
