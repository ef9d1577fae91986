#include "commanded_wrench.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <mutex>
#include <span>
#include <tuple>

#include "omniflight_physics/actuators.hpp"
#include "predetermined.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kSettles = 0.5;  ///< s, simulated before a stretch so that initial speeds decay; chosen
/// s, bounds of the simulation step; chosen for run time, since speeds are averaged over 25 ms afterwards.
constexpr double kFinest = 0.002, kCoarsest = 0.005;

double step_of(const vehicle::Vehicle& vehicle) {
  double quickest = kCoarsest;
  for (const vehicle::Rotor& rotor : vehicle.rotors)
    if (rotor.time_constant > 0) quickest = std::min(quickest, rotor.time_constant / 6);
  return std::max(kFinest, quickest);
}

/// Width [s] of the box with the variance of Flight::kernel_s.
double kernel_width(const Flight& f) { return std::sqrt(12.0) * f.kernel_s; }

/// Moving averages of the rows of `values` (spaced by `step`) over `width`, centred at from + k period for k
/// < count; times in s; count x rows.
Eigen::MatrixXd box_means(const Eigen::MatrixXd& values, double step, double from, double period,
                          double width, int count) {
  Eigen::MatrixXd sum(values.cols() + 1, values.rows());  // cumulative
  sum.row(0).setZero();
  for (Eigen::Index i = 0; i < values.cols(); ++i) sum.row(i + 1) = sum.row(i) + values.col(i).transpose();
  const auto until = [&](double t) -> Eigen::RowVectorXd {
    const double at = std::clamp(t / step, 0.0, static_cast<double>(values.cols()));
    const auto k = std::min(static_cast<Eigen::Index>(at), values.cols() - 1);
    return sum.row(k) + (at - static_cast<double>(k)) * values.col(k).transpose();
  };
  Eigen::MatrixXd out(count, values.rows());
  for (int k = 0; k < count; ++k) {
    const double t = from + k * period, end = step * static_cast<double>(values.cols());
    const double low = std::clamp(t - 0.5 * width, 0.0, end - step),
                 high = std::clamp(t + 0.5 * width, low + step, end);
    out.row(k) = (until(high) - until(low)) * (step / (high - low));
  }
  return out;
}

/// Part of a track from the last sample before `begin` to the first after `end` [s]; its times count from
/// `begin`.
CommandTrack part_between(const CommandTrack& track, double begin, double end) {
  const auto first = std::max<std::ptrdiff_t>(
      0, std::upper_bound(track.t.begin(), track.t.end(), begin) - track.t.begin() - 1);
  const auto last =
      std::min<std::ptrdiff_t>(std::lower_bound(track.t.begin(), track.t.end(), end) - track.t.begin(),
                               static_cast<std::ptrdiff_t>(track.t.size()) - 1);
  CommandTrack out;
  for (auto i = first; i <= last; ++i) out.t.push_back(track.t[static_cast<std::size_t>(i)] - begin);
  out.value = track.value.middleCols(first, last - first + 1);
  return out;
}

/// Commands at the midpoints of steps from time zero on, linearly interpolated; rotors x steps.
Eigen::MatrixXd at_steps(const CommandTrack& track, double step, Eigen::Index steps) {
  Eigen::MatrixXd out(track.value.rows(), steps);
  std::size_t k = 0;
  for (Eigen::Index i = 0; i < steps; ++i) {
    const double t = (static_cast<double>(i) + 0.5) * step;
    while (k + 2 < track.t.size() && track.t[k + 1] <= t) ++k;
    const auto at = static_cast<Eigen::Index>(k);
    if (track.t.size() < 2) {
      out.col(i) = track.value.col(at);
      continue;
    }
    const double share = std::clamp((t - track.t[k]) / (track.t[k + 1] - track.t[k]), 0.0, 1.0);
    out.col(i) = (1 - share) * track.value.col(at) + share * track.value.col(at + 1);
  }
  return out;
}

/// Nominal rotor wrench [N, Nm], samples x 6, at signed squares of speed [rad^2/s^2], samples x rotors.
Eigen::MatrixXd wrench_of(const Eigen::MatrixXd& squares, std::span<const physics::Situation> situations) {
  Eigen::MatrixXd out(squares.rows(), 6);
  for (Eigen::Index i = 0; i < squares.rows(); ++i) {
    const physics::Situation& s = situations[static_cast<std::size_t>(i)];
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (int k = 0; k < s.rotor_count; ++k) {
      const physics::RotorSituation& r = s.rotors[static_cast<std::size_t>(k)];
      const Vec3 f = r.thrust_coefficient * squares(i, k) * r.n_B;
      force += f;
      torque += r.p_BR.cross(f) + r.spin * r.drag_ratio * f;
    }
    out.row(i) << force.transpose(), torque.transpose();
  }
  return out;
}

/// Least-squares combination of two predictions of `wrench`, per channel. Two coefficients over all samples
/// hardly fit noise, so that no cross-fitting is needed.
Eigen::MatrixXd expected(const Eigen::MatrixXd& wrench, const Eigen::MatrixXd& linear,
                         const Eigen::MatrixXd& simulated) {
  Eigen::MatrixXd out(wrench.rows(), wrench.cols());
  for (Eigen::Index c = 0; c < wrench.cols(); ++c) {
    Eigen::MatrixX2d X(wrench.rows(), 2);
    X << linear.col(c), simulated.col(c);
    Eigen::Matrix2d H = X.transpose() * X;
    H.diagonal().array() += 1e-9 * H.trace() + 1e-30;
    out.col(c) = X * H.llt().solve(Eigen::Vector2d(X.transpose() * wrench.col(c)));
  }
  return out;
}

/// Commands [rad/s] at the grid samples, samples x rotors, smoothed like the signals of the flight.
Eigen::MatrixXd commands_on_grid(const Flight& f) {
  const double width = kernel_width(f), begin = f.t.front() - width, step = width / 12;
  const double end = f.t.back() + width;
  const CommandTrack track = part_between(f.commands, begin, end);
  const auto steps = static_cast<Eigen::Index>(std::ceil((end - begin) / step));
  return box_means(at_steps(track, step, steps), step, width, 1 / f.rate_hz, width, f.size());
}

}  // namespace

struct CommandedWrench::Known {
  using Key = std::tuple<const physics::Effect*, std::vector<double>, bool>;
  static constexpr std::size_t kMost = 64;  // cached wrenches of 6 numbers per sample; bounds memory

  std::optional<Eigen::VectorXd> find(const Key& key) {
    const std::lock_guard lock(mutex);
    const auto at = wrench.find(key);
    return at == wrench.end() ? std::nullopt : std::optional(at->second);
  }
  void keep(const Key& key, const Eigen::VectorXd& value) {
    const std::lock_guard lock(mutex);
    if (!wrench.emplace(key, value).second) return;
    order.push_back(key);
    if (order.size() <= kMost) return;
    wrench.erase(order.front());
    order.pop_front();
  }

  std::mutex mutex;
  std::map<Key, Eigen::VectorXd> wrench;
  std::deque<Key> order;  ///< the oldest first
};

CommandedWrench::CommandedWrench(const vehicle::Vehicle& vehicle)
    : vehicle_(vehicle), step_(step_of(vehicle)), known_(std::make_shared<Known>()) {}

void CommandedWrench::add(const Flight& f, double period, int lag, bool reference_alone) {
  const physics::Actuation nominal = physics::nominal_actuation(vehicle_);
  period_ = period;
  OfFlight out;
  std::vector<int> rows;
  for (const Segment& segment : f.segments)
    for (int i = segment.begin; i < segment.end; ++i) rows.push_back(i);
  out.size = static_cast<int>(rows.size());
  if (!f.commands.empty() && out.size > 0) {
    const Eigen::MatrixXd commands = commands_on_grid(f)(rows, Eigen::all);
    std::vector<physics::Situation> situations;
    for (const int i : rows) situations.push_back(f.situation[static_cast<std::size_t>(i)]);
    out.ahead = predict_from_commands(f, wrench_of(commands.cwiseProduct(commands.cwiseAbs()), situations),
                                      period, lag, reference_alone);
    const Eigen::MatrixXd expected = out.ahead->of(commands).transpose();
    Eigen::Index row = 0;
    for (const Segment& segment : f.segments) {
      Part p;
      p.size = segment.end - segment.begin;
      Commanded& r = p.recorded;
      r.width = kernel_width(f);
      const double first = f.t[static_cast<std::size_t>(segment.begin)], last = first + (p.size - 1) * period;
      const double begin = std::max(f.commands.t.front(), first - kSettles - r.width);
      r.from = first - begin;
      r.track = part_between(f.commands, begin, last + r.width);
      r.squares = squares(r, p.size, nominal);
      p.expected.width = period;
      for (int i = 0; i < p.size; ++i) p.expected.track.t.push_back(i * period);
      p.expected.track.value = expected.middleCols(row, p.size);
      p.expected.squares = squares(p.expected, p.size, nominal);
      row += p.size;
      out.parts.push_back(std::move(p));
    }
  }
  flights_.push_back(std::move(out));
}

Eigen::MatrixXd CommandedWrench::squares(const Commanded& c, int size, const physics::Actuation& a) const {
  Eigen::MatrixXd ends;
  const auto steps = static_cast<Eigen::Index>(std::ceil((c.from + size * period_ + c.width) / step_));
  if (!simulate_drives(vehicle_, a, c.track, Between::straight, step_, steps, 0, c.track.value.col(0), ends))
    return {};
  ends = ends.cwiseProduct(ends.cwiseAbs()).eval();
  return box_means(ends, step_, c.from, period_, c.width, size);
}

Eigen::MatrixXd CommandedWrench::difference(const Commanded& c, const physics::Actuation& a,
                                            std::span<const physics::Situation> measured) const {
  const Eigen::MatrixXd altered = squares(c, static_cast<int>(measured.size()), a);
  if (altered.size() == 0) return Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(measured.size()), 6);
  return wrench_of(altered - c.squares, measured);
}

Eigen::VectorXd CommandedWrench::operator()(const physics::Effect& effect, const std::vector<double>& theta,
                                            bool predicted,
                                            const std::vector<physics::Situation>& measured) const {
  const Known::Key key{&effect, theta, predicted};
  if (const auto before = known_->find(key)) return *before;
  physics::Actuation altered = physics::nominal_actuation(vehicle_);
  effect.alter_actuation(vehicle_, theta.data(), altered);
  const Eigen::VectorXd out = compute(altered, predicted, measured);
  known_->keep(key, out);
  return out;
}

Eigen::VectorXd CommandedWrench::of_delay(double late_s, bool predicted,
                                          const std::vector<physics::Situation>& measured) const {
  physics::Actuation altered = physics::nominal_actuation(vehicle_);
  for (double& delay : altered.delay) delay += late_s;
  return compute(altered, predicted, measured);
}

Eigen::VectorXd CommandedWrench::compute(const physics::Actuation& altered, bool predicted,
                                         const std::vector<physics::Situation>& measured) const {
  const auto n = static_cast<Eigen::Index>(measured.size());
  Eigen::VectorXd out = Eigen::VectorXd::Zero(6 * n);
  Eigen::Index first = 0;
  for (const OfFlight& f : flights_) {
    if (f.ahead) {
      Eigen::MatrixXd wrench(f.size, 6), simulated(f.size, 6);
      Eigen::Index row = 0;
      for (const Part& p : f.parts) {
        const std::span<const physics::Situation> here{measured.data() + first + row,
                                                       static_cast<std::size_t>(p.size)};
        wrench.middleRows(row, p.size) = difference(p.recorded, altered, here);
        if (predicted) simulated.middleRows(row, p.size) = difference(p.expected, altered, here);
        row += p.size;
      }
      if (predicted) wrench = expected(wrench, f.ahead->of(wrench), simulated);
      for (int c = 0; c < 6; ++c) out.segment(c * n + first, f.size) = wrench.col(c);
    }
    first += f.size;
  }
  return out;
}

}  // namespace omniflight::diagnosis
