#include "motor_balance.hpp"

#include <algorithm>
#include <cmath>

#include "../conditioning/thrust_source.hpp"
#include "../numerics/statistics.hpp"
#include "../numerics/text.hpp"
#include "findings.hpp"
#include "merge_recordings.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

/// Mean thrust of every rotor in steady flight [N, common unknown scale], and how long that was [s].
struct Steady {
  Eigen::VectorXd thrust;
  double seconds = 0;
  double alpha = 0;  ///< rad, tilt of the rotors
  bool tilt_unknown = false;
  std::vector<Window> excluded;
};

constexpr double kSameTilt = 0.05;  // rad, deviation from the median tilt that is still used; chosen

/// Rotor tilt at t_s [rad]: measured, else commanded, else the admissible tilt nearest to zero (`unknown`).
Eigen::VectorXd tilt_of(const Recording& r, const vehicle::Vehicle& v, const std::vector<double>& t_s,
                        bool& unknown) {
  const Signal* alpha = r.find("alpha") ? r.find("alpha") : r.find("alpha_command");
  unknown = v.tilt.kind != vehicle::TiltKind::none && !(alpha && alpha->width() == 1);
  const double usual = std::clamp(0.0, v.tilt.min, std::max(v.tilt.min, v.tilt.max));
  Eigen::VectorXd out = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(t_s.size()), usual);
  if (!alpha || alpha->width() != 1) return out;
  const Eigen::MatrixXd x = recording::resample(*alpha, t_s);
  for (Eigen::Index i = 0; i < x.rows(); ++i)  // beyond its ends the nearest value holds
    out[i] =
        std::isfinite(x(i, 0))
            ? x(i, 0)
            : alpha->values(t_s[static_cast<std::size_t>(i)] < alpha->t_s.front() ? 0 : alpha->size() - 1, 0);
  return out;
}

/// Median thrusts over steady flight: total thrust within 40 % of its 75 % quantile, tilt near its median,
/// away from the ground and slow where position and velocity tell. Thresholds chosen.
Steady steady_thrust(const Recording& r, const Signal& speed, const vehicle::Vehicle& v) {
  Steady out;
  const Eigen::Index n = speed.size(), rotors = speed.width();
  Eigen::MatrixXd thrust(n, rotors);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = 0; k < rotors; ++k)
      thrust(i, k) = v.rotors[static_cast<std::size_t>(k)].thrust(speed.values(i, k));
  const Eigen::VectorXd total = thrust.rowwise().sum();
  std::vector<double> sorted(total.begin(), total.end());
  std::sort(sorted.begin(), sorted.end());
  const double usual = sorted[static_cast<std::size_t>(0.75 * static_cast<double>(n - 1))];
  const Signal *p = r.find("position"), *vel = r.find("velocity");
  if (!p) p = r.find("est_position");
  if (!vel) vel = r.find("est_velocity");
  const Eigen::MatrixXd x = p ? recording::resample(*p, speed.t_s) : Eigen::MatrixXd();
  const Eigen::MatrixXd w = vel ? recording::resample(*vel, speed.t_s) : Eigen::MatrixXd();
  double low = -1e18;
  if (p && p->values.col(2).maxCoeff() - p->values.col(2).minCoeff() > 0.2)
    low = p->values.col(2).minCoeff() +
          std::min(0.15, 0.4 * (p->values.col(2).maxCoeff() - p->values.col(2).minCoeff()));
  const Eigen::VectorXd tilt = tilt_of(r, v, speed.t_s, out.tilt_unknown);
  out.alpha = median({tilt.begin(), tilt.end()});
  std::vector<std::vector<double>> kept(static_cast<std::size_t>(rotors));
  const double period = speed.median_period_s();
  double open = -1;
  const auto close = [&](double t) {
    if (open >= 0 && t - open > 0.1) out.excluded.push_back({open, t, "not in steady flight"});
    open = -1;
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    bool good = total[i] > 0.6 * usual && total[i] < 1.4 * usual && std::abs(tilt[i] - out.alpha) < kSameTilt;
    if (x.size() > 0) good = good && x(i, 2) > low;
    if (w.size() > 0) good = good && std::hypot(w(i, 0), w(i, 1)) < 0.4 && std::abs(w(i, 2)) < 0.2;
    const double t = speed.t_s[static_cast<std::size_t>(i)];
    if (!good) {
      if (open < 0) open = t;
      continue;
    }
    close(t);
    out.seconds += period;
    for (Eigen::Index k = 0; k < rotors; ++k) kept[static_cast<std::size_t>(k)].push_back(thrust(i, k));
  }
  close(speed.t_s.back());
  out.thrust = Eigen::VectorXd::Zero(rotors);
  for (Eigen::Index k = 0; k < rotors; ++k) {
    auto& c = kept[static_cast<std::size_t>(k)];
    if (c.empty()) continue;
    out.thrust[k] = median(std::move(c));
  }
  return out;
}

ParameterValue value_of(const physics::Effect* effect, std::size_t at, const char* name, const char* unit,
                        double value, double low, double high) {
  ParameterValue p{name, name, unit, value, low, high};
  if (effect && at < effect->info().parameters.size()) {
    p.name = effect->info().parameters[at].name;
    p.symbol = effect->info().parameters[at].symbol;
    p.unit = effect->info().parameters[at].unit;
  }
  return p;
}

/// Mean over the steady flight of several recordings, weighted by duration.
struct Balance {
  vehicle::AllocationMatrix allocation;  ///< mean over their tilts
  Vec6 wrench = Vec6::Zero();            ///< mean, at thrusts normalised to sum one
  double seconds = 0;
  std::string notes;

  double lift() const { return std::max(1e-9, wrench.head<3>().norm()); }
  /// Mean lever [m] of a rotor about each body axis.
  Vec3 arm() const {
    Vec3 out = Vec3::Zero();
    for (Eigen::Index k = 0; k < allocation.cols(); ++k)
      out += allocation.block<3, 1>(3, k).cwiseAbs() / static_cast<double>(allocation.cols());
    return out.cwiseMax(1e-9);
  }
  /// Torque about roll, pitch and yaw, each over weight times arm().
  Vec3 imbalance() const { return wrench.tail<3>().cwiseQuotient(lift() * arm()); }
  /// Change of imbalance() when rotor k commands twice its share.
  Vec3 of_rotor(int k) const {
    return allocation.block<3, 1>(3, k).cwiseQuotient(lift() * arm()) /
           static_cast<double>(allocation.cols());
  }
};

/// Adds one recording; windows that are not steady go to `excluded`. The value is the reason why it was left
/// out, if it was. Error: no motor signal.
Result<std::optional<Error>> add_flight(const Recording& r, const vehicle::Vehicle& v, Balance& sum,
                                        std::vector<Window>& excluded) {
  Recording chosen = r;  // commanded power, where logged, is closer to thrust than the duty cycle
  if (r.find("motor_power") && !r.find("rotor_speed") && !r.find("rotor_command"))
    chosen.signals.erase("pwm");
  const auto source = thrust_source(chosen, v);
  if (!source)
    return bad_input("no motor signal ('rotor_speed', 'rotor_command', 'pwm' or 'motor_power')", r.file,
                     "Record one of them, or name the columns with --map");
  const Steady steady = steady_thrust(r, source->speed, v);
  excluded = steady.excluded;
  if (steady.seconds < 2 || !(steady.thrust.minCoeff() > 0))
    return Error{ErrorCode::bad_input,
                 format("only %.1f s of steady flight, at least 2 s are needed", steady.seconds), r.file,
                 "Give a recording with some hover"};
  const vehicle::AllocationMatrix own = v.allocation_matrix(steady.alpha);
  if (sum.seconds == 0) sum.allocation = vehicle::AllocationMatrix::Zero(6, own.cols());
  sum.seconds += steady.seconds;
  const double weight = steady.seconds / sum.seconds;
  sum.wrench += weight * (own * (steady.thrust / steady.thrust.sum()) - sum.wrench);
  sum.allocation += weight * (own - sum.allocation);
  if (steady.tilt_unknown && sum.notes.find("tilt angle") == std::string::npos)
    sum.notes += format(" No tilt angle: it is taken as %.2f rad.", steady.alpha);
  if (sum.notes.find(source->note) == std::string::npos) sum.notes += " " + source->note;
  return std::optional<Error>();
}

constexpr int kFewestBaselines = 3;  ///< least number for a standard deviation; chosen

/// The rotor that explains the imbalance best, its relative excess of command over its share, the 95 %
/// likelihood interval of that excess, and Yardstick::chi at the best fit.
struct WeakRotor {
  int rotor = -1;
  double extra = 0, low = 0, high = 0, chi = 0;
};

WeakRotor weakest_rotor(const Balance& b, const Yardstick& y) {
  constexpr double kMost = 3;  // largest excess tried: a rotor with a quarter of its thrust
  const Vec3 x = b.imbalance();
  WeakRotor best;
  best.chi = y.chi(x);
  for (int k = 0; k < b.allocation.cols(); ++k) {
    const Vec3 u = b.of_rotor(k);
    const auto chi = [&](double e) { return y.chi(x - e * u); };
    for (int i = 1; i <= 3000; ++i) {
      const double extra = kMost * i / 3000;
      if (const double here = chi(extra); here < best.chi) best = {k, extra, 0, 0, here};
    }
  }
  if (best.rotor < 0) return best;
  const Vec3 u = b.of_rotor(best.rotor);
  const auto edge = [&](double far) {  // 3.84: 95 % quantile of chi-square with one degree of freedom
    double in = best.extra, out = far;
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (in + out);
      (y.chi(x - middle * u) < best.chi + 3.84 ? in : out) = middle;
    }
    return in;
  };
  best.low = edge(best.extra - kMost), best.high = edge(best.extra + kMost);
  return best;
}

/// Posterior probability, at equal prior odds, of the explanation whose chi is lower by this much.
double likelier_than(double chi_lower_by) { return 1 / (1 + std::exp(-0.5 * chi_lower_by)); }

/// The finding "Rotor 3 gives 17 % less thrust ...".
Finding weak_rotor(const WeakRotor& weak, double without, const Yardstick& y, Diagnosis& d) {
  const auto thrust = [](double extra) { return 1 / (1 + std::max(-0.9, extra)) - 1; };
  const double scale = thrust(weak.extra), low = thrust(weak.high), high = thrust(weak.low);
  const physics::Effect* effect = physics::find_effect(physics::effect_id::rotor_thrust_scale);
  const auto at = static_cast<std::size_t>(weak.rotor);
  Finding f;
  f.effect = physics::effect_id::rotor_thrust_scale;
  f.stage = physics::Stage::actuation;
  f.channels = {"rotor" + std::to_string(weak.rotor + 1), "Mx", "My", "Mz"};
  f.probability = likelier_than(without - weak.chi);
  f.parameters.push_back(value_of(effect, at, "scale", "1", scale, low, high));
  f.sentence = format(
      "Rotor %d gives %.0f %% less thrust than %s (95 %%: %.0f to %.0f %%): it needs %.0f %% more than "
      "its share in steady flight. A damaged propeller or a weak motor does this.",
      weak.rotor + 1, -100 * scale,
      y.flights > 0 ? format("in the %d baseline flights", y.flights).c_str() : "its command should",
      -100 * high, -100 * low, 100 * weak.extra);
  if (!effect) return f;
  f.equation = effect->info().equation;
  f.latex = effect->info().latex;
  physics::ActiveEffect active{effect, {}};
  for (const auto& p : effect->info().parameters) active.theta.push_back(p.neutral);
  if (at < active.theta.size()) {
    const auto& p = effect->info().parameters[at];
    active.theta[at] = std::clamp(scale, p.lower, p.upper);
    d.model.push_back(active);
  }
  return f;
}

/// The finding "The centre of mass lies beside the middle ...".
Finding shifted_mass(const Balance& b, const Yardstick& y, double against, Diagnosis& d) {
  const Vec3 imbalance = b.imbalance() - y.expected, arm = b.arm();
  const physics::Effect* effect = physics::find_effect(physics::effect_id::com_offset);
  Finding f;
  f.effect = physics::effect_id::com_offset;
  f.stage = physics::Stage::wrench;
  f.channels = {"Mx", "My"};
  f.probability = likelier_than(against);
  f.cannot_be_told_apart_from = {physics::effect_id::payload_mass, physics::effect_id::attachment_torque};
  // the centre of thrust lies above the centre of mass: roll torque for an offset along y, pitch for x
  const double at_y = imbalance.x() * arm.x(), at_x = -imbalance.y() * arm.y();
  const double half_y = 1.96 * y.sigma.x() * arm.x(), half_x = 1.96 * y.sigma.y() * arm.y();
  f.parameters.push_back(value_of(effect, 0, "x", "m", at_x, at_x - half_x, at_x + half_x));
  f.parameters.push_back(value_of(effect, 1, "y", "m", at_y, at_y - half_y, at_y + half_y));
  f.sentence = format(
      "The centre of mass lies beside %s: x = %+.1f mm, y = %+.1f mm (95 %%: +-%.1f mm). An "
      "added weight does this; no single rotor is to blame.",
      y.flights > 0 ? "that of the baseline flights" : "the middle", 1e3 * at_x, 1e3 * at_y,
      1e3 * std::max(half_x, half_y));
  if (!effect) return f;
  f.equation = effect->info().equation;
  f.latex = effect->info().latex;
  d.model.push_back({effect, {at_x, at_y, 0.0}});
  return f;
}

}  // namespace

double Yardstick::chi(const Vec3& imbalance) const {
  const Vec3 z = (imbalance - expected).cwiseQuotient(sigma);
  if (flights == 0) return z.squaredNorm();
  double sum = 0;
  for (const double x : z) sum += flights * std::log1p(x * x / (flights - 1));
  return sum;
}

Result<Yardstick> balance_yardstick(const vehicle::Vehicle& v, const Options& o) {
  Yardstick out;
  out.sigma << o.tolerance.motor_lateral, o.tolerance.motor_lateral, o.tolerance.motor_yaw;
  if (o.baseline.empty()) return out;
  std::vector<Vec3> all;
  for (const Recording& r : o.baseline) {
    Balance one;
    std::vector<Window> excluded;
    if (auto ok = add_flight(r, v, one, excluded); !ok) return Failure(ok.error());
    if (one.seconds > 0) all.push_back(one.imbalance());
  }
  out.flights = static_cast<int>(all.size());
  if (out.flights < kFewestBaselines)
    return bad_input(
        format("%d baseline flights with steady parts; the scatter of at least %d is the measure "
               "of a change",
               out.flights, kFewestBaselines),
        o.baseline.front().file, "Name more flights with --baseline");
  for (const Vec3& x : all) out.expected += x / out.flights;
  Vec3 variance = Vec3::Zero();
  for (const Vec3& x : all) variance += (x - out.expected).cwiseAbs2() / (out.flights - 1);
  out.sigma = (variance * (1 + 1.0 / out.flights)).cwiseSqrt().cwiseMax(1e-4);
  return out;
}

Result<Diagnosis> diagnose_balance(std::span<const Recording> flown, const vehicle::Vehicle& v,
                                   const Yardstick& y) {
  Diagnosis d;
  Balance b;
  std::optional<Error> refused;
  for (const Recording& r : flown) {
    d.inputs.push_back(input_of(r));
    auto left_out = add_flight(r, v, b, d.inputs.back().excluded);
    if (!left_out) return Failure(left_out.error());
    if (!*left_out) continue;
    refused = std::move(*left_out);
    d.left_out.push_back("the motors of " + r.file + " (" + refused->message + ")");
  }
  if (!(b.seconds > 0)) return Failure(*refused);
  const Vec3 imbalance = b.imbalance() - y.expected;
  const double none = y.chi(b.imbalance());
  // an offset of the centre of mass explains roll and pitch, not yaw
  Vec3 yaw_only = y.expected;
  yaw_only.z() = b.imbalance().z();
  const double centre = y.chi(yaw_only);
  const WeakRotor weak = weakest_rotor(b, y);
  const bool broken = weak.rotor >= 0 && none - weak.chi > 5.3 && weak.chi < centre - 1.0;
  const bool off_centre = !broken && none - centre > 6.8;
  Mismatch m;
  m.stage = broken ? physics::Stage::actuation : physics::Stage::wrench;
  m.frame = "body";
  m.unit = "1";
  m.channel = broken ? "rotor" + std::to_string(weak.rotor + 1) : "Mx, My";
  m.rms = imbalance.norm();
  m.noise_rms = y.sigma.norm();
  m.where = format("share of the torque over weight times arm: roll %+.3f, pitch %+.3f, yaw %+.3f",
                   imbalance.x(), imbalance.y(), imbalance.z());
  if (y.flights > 0)
    m.where += format(" beside %d baseline flights, which scatter by %.3f, %.3f, %.3f", y.flights,
                      y.sigma.x(), y.sigma.y(), y.sigma.z());
  if (broken || off_centre) {
    m.p_value = broken ? std::erfc(std::sqrt(0.5 * (none - weak.chi))) : std::exp(-0.5 * (none - centre));
    d.findings.push_back(broken ? weak_rotor(weak, centre, y, d) : shifted_mass(b, y, weak.chi - centre, d));
    d.mismatch.push_back(m);
    d.verdict = Verdict::explained;
    d.summary = d.findings.back().sentence;
  } else {
    d.summary = y.flights > 0 ? "Nothing changed: the motors share the load as in the baseline flights (" +
                                    m.where + ")."
                              : "Nothing is missing: the motors share the load as evenly as motors of one "
                                "kind do (" +
                                    m.where + ").";
  }
  d.summary +=
      " There is no attitude or no force: only the balance of the motors in steady flight "
      "was "
      "judged; forces, drag, load and wind cannot be told." +
      b.notes;
  for (const std::string& what : d.left_out) d.summary += " Left out: " + what + ".";
  return d;
}

}  // namespace omniflight::diagnosis
