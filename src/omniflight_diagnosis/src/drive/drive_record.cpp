#include "drive_record.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "../numerics/statistics.hpp"

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured.
constexpr double kSlowest = 0.03;    ///< s, longest median sample period
constexpr double kLongestGap = 0.1;  ///< s, of speeds or commands
constexpr double kApart = 0.0035;    ///< s, least distance of speed samples used; closer ones are redundant
constexpr double kShortest = 3;      ///< s, of a record
constexpr double kTurns = 0.25;      ///< of the median speed of a rotor, below which telemetry is inaccurate

/// Indices of samples in [from, to] [s], at least `apart` [s] from each other; empty with a gap above
/// kLongestGap.
std::vector<std::size_t> samples_of(const recording::Signal& s, double from, double to, double apart) {
  std::vector<std::size_t> out;
  double before = from;
  for (std::size_t i = 0; i < s.t_s.size(); ++i) {
    const double t = s.t_s[i];
    if (t < from || t > to || (!out.empty() && t < s.t_s[out.back()] + apart)) continue;
    if (!s.values.row(static_cast<Eigen::Index>(i)).allFinite()) continue;
    if (t - before > kLongestGap) return {};
    before = t;
    out.push_back(i);
  }
  return out;
}

struct Commands {
  std::vector<double> t;  ///< s
  Eigen::MatrixXd value;  ///< rad/s, samples x rotors
};

/// Response of a first-order lag with time constant tau [s] to inputs held between samples.
Eigen::MatrixXd lagged(const std::vector<double>& t, Eigen::MatrixXd x, double tau) {
  Eigen::RowVectorXd state = x.row(0);
  for (Eigen::Index i = 1; i < x.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double keep = tau > 0 ? std::exp(-(t[k] - t[k - 1]) / tau) : 0.0;
    state += (1 - keep) * (x.row(i - 1) - state);
    x.row(i - 1) = state;
  }
  // row i holds the state at the time of row i + 1
  for (Eigen::Index i = x.rows() - 1; i > 0; --i) x.row(i) = x.row(i - 1);
  return x;
}

/// Replaces duty cycles in c by steady-state speeds [rad/s]: per rotor an affine map of duty, duty times
/// voltage and voltage, fitted to the speed through the nominal lag. False where voltage or fit is not
/// finite.
bool map_duty_cycles(const recording::Recording& r, const vehicle::Vehicle& vehicle, const DriveRecord& d,
                     double begin, Commands& c) {
  Eigen::MatrixXd volt;
  if (const recording::Signal* vbat = r.find("vbat")) volt = recording::resample(*vbat, c.t);
  if (volt.size() > 0 && !volt.allFinite()) return false;
  std::vector<double> at;
  for (const double t : d.t) at.push_back(begin + t);
  for (Eigen::Index k = 0; k < c.value.cols(); ++k) {
    Eigen::MatrixXd X(c.value.rows(), volt.size() > 0 ? 4 : 2);
    X.col(0).setOnes();
    X.col(1) = c.value.col(k);
    if (volt.size() > 0) {
      X.col(2) = c.value.col(k).cwiseProduct(volt.col(0));
      X.col(3) = volt.col(0);
    }
    recording::Signal answer;
    answer.t_s = c.t;
    answer.values = lagged(c.t, X, vehicle.rotors[static_cast<std::size_t>(k)].time_constant);
    const Eigen::MatrixXd A = recording::resample(answer, at);
    if (!A.allFinite()) return false;
    const Eigen::VectorXd map = A.colPivHouseholderQr().solve(d.speed.col(k));
    c.value.col(k) = X * map;
    if (!c.value.col(k).allFinite()) return false;
  }
  return true;
}

}  // namespace

std::optional<DriveRecord> drive_record(const recording::Recording& r, const vehicle::Vehicle& vehicle,
                                        const Flight& flight, double most_s) {
  const recording::Signal *speed = r.find("rotor_speed"), *command = r.find("rotor_command");
  DriveRecord out;
  out.from_duty_cycle = command == nullptr;
  if (!command) command = r.find("pwm");
  if (!speed || !command || speed->width() != command->width() || speed->width() != vehicle.rotor_count())
    return {};
  if (speed->median_period_s() > kSlowest || command->median_period_s() > kSlowest) return {};
  Segment longest;
  for (const Segment& s : flight.segments)
    if (s.end - s.begin > longest.end - longest.begin) longest = s;
  if (longest.end <= longest.begin) return {};
  const double begin = flight.t[static_cast<std::size_t>(longest.begin)];
  const double end = std::min(flight.t[static_cast<std::size_t>(longest.end - 1)], begin + most_s);
  if (end - begin < kShortest) return {};
  const auto spins = samples_of(*speed, begin, end, kApart), orders = samples_of(*command, begin, end, 0);
  if (spins.size() < 100 || orders.size() < 100) return {};
  Commands c;
  c.value.resize(static_cast<Eigen::Index>(orders.size()), command->values.cols());
  for (std::size_t i = 0; i < orders.size(); ++i) {
    c.t.push_back(command->t_s[orders[i]]);
    c.value.row(static_cast<Eigen::Index>(i)) = command->values.row(static_cast<Eigen::Index>(orders[i]));
  }
  out.speed.resize(static_cast<Eigen::Index>(spins.size()), speed->values.cols());
  for (std::size_t i = 0; i < spins.size(); ++i) {
    out.t.push_back(speed->t_s[spins[i]] - begin);
    out.speed.row(static_cast<Eigen::Index>(i)) = speed->values.row(static_cast<Eigen::Index>(spins[i]));
  }
  if (out.from_duty_cycle && !map_duty_cycles(r, vehicle, out, begin, c)) return {};
  out.step = drive_step(vehicle);
  out.steps = static_cast<Eigen::Index>((end - begin) / out.step);
  out.ordered.value = c.value.transpose();
  for (const double t : c.t) out.ordered.t.push_back(t - begin);
  out.command.resize(out.speed.rows(), out.speed.cols());
  for (std::size_t i = 0, k = 0; i < out.t.size(); ++i) {
    while (k + 1 < out.ordered.t.size() && out.ordered.t[k + 1] <= out.t[i]) ++k;
    out.command.row(static_cast<Eigen::Index>(i)) = c.value.row(static_cast<Eigen::Index>(k));
  }
  out.counts.resize(out.speed.rows(), out.speed.cols());
  for (Eigen::Index k = 0; k < out.speed.cols(); ++k) {
    std::vector<double> sizes;
    for (const double x : out.speed.col(k)) sizes.push_back(std::abs(x));
    out.counts.col(k) = out.speed.col(k).array().abs() > kTurns * median(std::move(sizes));
  }
  return out;
}

}  // namespace omniflight::diagnosis
