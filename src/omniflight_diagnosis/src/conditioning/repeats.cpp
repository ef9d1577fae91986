#include "repeats.hpp"

#include <algorithm>
#include <cmath>

#include "../numerics/statistics.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Signal;

// Chosen, not measured.
constexpr double kLeastFreeze = 0.15;  // s, shortest freeze
constexpr double kBeyondUsual = 5;  // a freeze over the 99 % quantile of the time for which a value is held
// Jump into or out of a freeze or plateau over the median step between values: of a noisy signal, and of a
// smooth one, which may come to rest by itself.
constexpr double kJump = 0.3;
constexpr double kSmoothJump = 3;
constexpr double kLeastLevels = 50;  // resolution steps in the range, below which it reaches its ends anyway
// Samples of a freeze; of a lasting plateau at a limit; at a limit in all, where no plateau lasts.
constexpr Eigen::Index kLeastRepeats = 4, kLeastPlateau = 3, kLeastOften = 10;

/// Distance of two rows; for quaternions of the nearer sign.
double apart(const Signal& s, Eigen::Index a, Eigen::Index b) {
  const double d = (s.values.row(a) - s.values.row(b)).norm();
  return recording::is_attitude(s.name) ? std::min(d, (s.values.row(a) + s.values.row(b)).norm()) : d;
}

/// Runs of x at its maximum (sign 1) or minimum (-1), if they are frequent enough for a limit of the sensor.
std::vector<Rows> plateaus(const Eigen::VectorXd& x, double sign) {
  const Eigen::Index n = x.size();
  const Eigen::VectorXd y = sign * x;
  const double top = y.maxCoeff(), range = top - y.minCoeff();
  std::vector<double> steps;
  for (Eigen::Index i = 1; i < n; ++i)
    if (y[i] != y[i - 1]) steps.push_back(std::abs(y[i] - y[i - 1]));
  if (steps.size() < 50 || range < kLeastLevels * quantile(steps, 0.01)) return {};
  const double jump = kJump * quantile(steps, 0.5);
  std::vector<Rows> out;
  Eigen::Index at_top = 0, near = 0;
  int lasting = 0;
  for (Eigen::Index i = 0; i < n;) {
    if (y[i] != top) {
      near += y[i] > top - 0.05 * range;
      ++i;
      continue;
    }
    Eigen::Index j = i;
    while (j < n && y[j] == top) ++j;
    const bool sudden = (i > 0 && top - y[i - 1] > jump) || (j < n && top - y[j] > jump);
    if (sudden) {
      at_top += j - i;
      lasting += j - i >= kLeastPlateau;
      out.push_back({i, j});
    }
    i = j;
  }
  const bool often = at_top >= kLeastOften && out.size() >= kLeastOften / 2;
  if ((lasting < 2 && !often) || 2 * at_top < near) return {};
  return out;
}

}  // namespace

std::vector<Rows> equal_rows(const Eigen::MatrixXd& values) {
  std::vector<Rows> out;
  for (Eigen::Index i = 0; i < values.rows();) {
    Eigen::Index j = i + 1;
    while (j < values.rows() && values.row(j) == values.row(i)) ++j;
    out.push_back({i, j});
    i = j;
  }
  return out;
}

std::vector<char> driven(const recording::Recording& r, const Signal& s) {
  std::vector<char> out(s.t_s.size(), 1);
  const Signal* drive = nullptr;
  for (const char* name : {"rotor_speed", "rotor_command", "pwm", "motor_power"})
    if (!drive) drive = r.find(name);
  if (!drive || drive->size() < 20) return out;
  Signal effort = *drive;
  effort.values = drive->values.rowwise().squaredNorm();
  const std::vector<double> all(effort.values.data(), effort.values.data() + effort.values.size());
  const double enough = 0.4 * quantile(all, 0.75);
  const Eigen::MatrixXd x = recording::resample(effort, s.t_s);
  for (Eigen::Index i = 0; i < x.rows(); ++i) out[static_cast<std::size_t>(i)] = x(i, 0) > enough;
  return out;
}

std::vector<Rows> frozen(const Signal& s, const std::vector<char>& in_flight) {
  std::vector<Rows> out;
  const std::vector<Rows> runs = equal_rows(s.values);
  const double period = s.median_period_s();
  if (runs.size() < 50 || !(period > 0)) return out;
  const auto length = [&](const Rows& r) { return time_of(s, r.end - 1) - time_of(s, r.begin) + period; };
  std::vector<double> held, steps, bends;
  for (std::size_t k = 2; k < runs.size(); ++k) {
    if (!in_flight[static_cast<std::size_t>(runs[k].begin)]) continue;
    held.push_back(length(runs[k]));
    steps.push_back(apart(s, runs[k].begin, runs[k - 1].begin));
    bends.push_back(std::abs(apart(s, runs[k].begin, runs[k - 2].begin) - 2 * steps.back()));
  }
  if (held.size() < 50) return out;
  const double least = std::max(kLeastFreeze, kBeyondUsual * quantile(held, 0.99));
  // smooth signal: two steps lead twice as far as one
  const double step = quantile(steps, 0.5);
  const double jump = (quantile(bends, 0.5) < 0.25 * step ? kSmoothJump : kJump) * step;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const Rows& r = runs[k];
    if (r.end - r.begin < kLeastRepeats || length(r) < least) continue;
    const bool sudden = (k > 0 && apart(s, runs[k - 1].begin, r.begin) > jump) ||
                        (k + 1 < runs.size() && apart(s, runs[k + 1].begin, r.begin) > jump);
    const auto flying = std::count(in_flight.begin() + r.begin, in_flight.begin() + r.end, 1);
    if (sudden && 10 * flying >= 8 * (r.end - r.begin)) out.push_back(r);
  }
  return out;
}

Clipped clipped(const Signal& s) {
  Clipped out;
  const std::vector<Rows> runs = equal_rows(s.values);
  if (runs.size() < 100) return out;
  std::vector<char> bad(runs.size(), 0);
  for (Eigen::Index c = 0; c < s.width(); ++c) {
    Eigen::VectorXd x(static_cast<Eigen::Index>(runs.size()));
    for (std::size_t k = 0; k < runs.size(); ++k)
      x[static_cast<Eigen::Index>(k)] = s.values(runs[k].begin, c);
    for (const double sign : {1.0, -1.0})
      for (const Rows& p : plateaus(x, sign)) {
        std::fill(bad.begin() + p.begin, bad.begin() + p.end, 1);
        out.low = std::min(out.low, x[p.begin]);
        out.high = std::max(out.high, x[p.begin]);
      }
  }
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (!bad[k]) continue;
    if (k > 0 && bad[k - 1])
      out.runs.back().end = runs[k].end;
    else
      out.runs.push_back(runs[k]);
  }
  return out;
}

std::vector<Eigen::Index> written_twice(const Signal& s) {
  std::vector<Eigen::Index> out;
  std::vector<double> periods;
  for (std::size_t i = 1; i < s.t_s.size(); ++i) periods.push_back(s.t_s[i] - s.t_s[i - 1]);
  const double close = 0.2 * quantile(periods, 0.75);  // the median would be zero if half were copies
  for (Eigen::Index i = 1; i < s.size(); ++i)
    if (time_of(s, i) - time_of(s, i - 1) < close && s.values.row(i) == s.values.row(i - 1)) out.push_back(i);
  return out;
}

}  // namespace omniflight::diagnosis
