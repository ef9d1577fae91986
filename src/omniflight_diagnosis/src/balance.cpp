#include "balance.hpp"

#include <algorithm>
#include <cmath>

#include "findings.hpp"
#include "text.hpp"
#include "thrust_source.hpp"
#include "together.hpp"

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

constexpr double kSameTilt = 0.05;  // rad: tilts at which the torques of one thrust hardly differ

/// Tilt of the rotors at these times [rad]: measured, else ordered, else as near to none as the vehicle can.
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
  std::vector<double> tilts(tilt.begin(), tilt.end());
  std::nth_element(tilts.begin(), tilts.begin() + n / 2, tilts.end());
  out.alpha = tilts[static_cast<std::size_t>(n / 2)];
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
    std::nth_element(c.begin(), c.begin() + static_cast<std::ptrdiff_t>(c.size() / 2), c.end());
    out.thrust[k] = c[c.size() / 2];
  }
  return out;
}

ParameterValue value_of(const physics::Effect* effect, std::size_t at, const char* name, const char* unit,
                        double value, double half) {
  ParameterValue p{name, name, unit, value, value - half, value + half};
  if (effect && at < effect->info().parameters.size()) {
    p.name = effect->info().parameters[at].name;
    p.symbol = effect->info().parameters[at].symbol;
    p.unit = effect->info().parameters[at].unit;
  }
  return p;
}

}  // namespace

Result<Diagnosis> diagnose_balance(std::span<const Recording> flown, const vehicle::Vehicle& v,
                                   const Options& o) {
  Diagnosis d;
  const int n = v.rotor_count();
  // every flight's own shares count as long as it was steady
  vehicle::AllocationMatrix A = vehicle::AllocationMatrix::Zero(6, n);
  Eigen::VectorXd share = Eigen::VectorXd::Zero(n);
  Vec6 wrench = Vec6::Zero();  // at thrusts that add up to one
  double seconds = 0;
  std::string notes;
  std::optional<Error> refused;
  for (const Recording& r : flown) {
    Recording chosen = r;  // commanded power, where logged, is closer to thrust than the duty cycle
    if (r.find("motor_power") && !r.find("rotor_speed") && !r.find("rotor_command"))
      chosen.signals.erase("pwm");
    const auto source = thrust_source(chosen, v);
    if (!source)
      return bad_input("no motor signal ('rotor_speed', 'rotor_command', 'pwm' or 'motor_power')", r.file,
                       "Record one of them, or name the columns with --map");
    const Steady steady = steady_thrust(r, source->speed, v);
    d.inputs.push_back(input_of(r));
    d.inputs.back().excluded = steady.excluded;
    if (steady.seconds < 2 || !(steady.thrust.minCoeff() > 0)) {
      refused = Error{ErrorCode::bad_input,
                      format("only %.1f s of steady flight, at least 2 s are needed", steady.seconds), r.file,
                      "Give a recording with some hover"};
      d.left_out.push_back("the motors of " + r.file + " (" + refused->message + ")");
      continue;
    }
    const Eigen::VectorXd part = steady.thrust / steady.thrust.sum();
    const vehicle::AllocationMatrix own = v.allocation_matrix(steady.alpha);
    share += steady.seconds * part;
    wrench += steady.seconds * (own * part);
    A += steady.seconds * own;
    seconds += steady.seconds;
    if (steady.tilt_unknown && notes.find("tilt angle") == std::string::npos)
      notes += format(" No tilt angle: it is taken as %.2f rad.", steady.alpha);
    if (notes.find(source->note) == std::string::npos) notes += " " + source->note;
  }
  if (!(seconds > 0)) return Failure(*refused);
  share /= seconds, wrench /= seconds, A /= seconds;

  // imbalance over roll, pitch and yaw, each over weight times its mean arm
  const double lift = std::max(1e-9, wrench.head<3>().norm());  // of the thrusts' sum
  Vec3 arm = Vec3::Zero();
  for (int k = 0; k < n; ++k)
    for (int c = 0; c < 3; ++c) arm[c] += std::abs(A(3 + c, k)) / n;
  Vec3 imbalance, sigma(o.tolerance.motor_lateral, o.tolerance.motor_lateral, o.tolerance.motor_yaw);
  for (int c = 0; c < 3; ++c) imbalance[c] = wrench[3 + c] / (lift * std::max(1e-9, arm[c]));
  const auto chi = [&](const Vec3& x) { return x.cwiseQuotient(sigma).squaredNorm(); };
  const double none = chi(imbalance), centre = std::pow(imbalance.z() / sigma.z(), 2);
  int rotor = -1;
  double best = none, extra = 0, extra_se = 0;
  for (int k = 0; k < n; ++k) {
    Vec3 u;
    for (int c = 0; c < 3; ++c) u[c] = A(3 + c, k) / (lift * std::max(1e-9, arm[c]) * n);
    const double H = u.cwiseQuotient(sigma).squaredNorm();
    const double e = u.cwiseQuotient(sigma).dot(imbalance.cwiseQuotient(sigma)) / H;
    if (e > 0 && chi(imbalance - e * u) < best) {
      best = chi(imbalance - e * u);
      rotor = k;
      extra = e;
      extra_se = 1 / std::sqrt(H);
    }
  }
  const bool broken = rotor >= 0 && none - best > 5.3 && best < centre - 1.0;
  const bool off_centre = !broken && none - centre > 6.8;
  Mismatch m;
  m.stage = broken ? physics::Stage::actuation : physics::Stage::wrench;
  m.frame = "body";
  m.unit = "1";
  m.channel = broken ? "rotor" + std::to_string(rotor + 1) : "Mx, My";
  m.rms = imbalance.norm();
  m.noise_rms = sigma.norm();
  m.where = format("share of the torque over weight times arm: roll %+.3f, pitch %+.3f, yaw %+.3f",
                   imbalance.x(), imbalance.y(), imbalance.z());
  Finding f;
  if (broken) {
    const double scale = 1 / (1 + extra) - 1, half = 1.96 * extra_se / std::pow(1 + extra, 2);
    m.p_value = std::erfc(std::sqrt(0.5 * (none - best)));
    const physics::Effect* effect = physics::find_effect("rotor_thrust_scale");
    f.effect = "rotor_thrust_scale";
    f.stage = physics::Stage::actuation;
    f.channels = {"rotor" + std::to_string(rotor + 1), "Mx", "My", "Mz"};
    f.probability = 1 / (1 + std::exp(-0.5 * (centre - best)));
    f.parameters.push_back(value_of(effect, static_cast<std::size_t>(rotor), "scale", "1", scale, half));
    f.sentence = format(
        "Rotor %d gives %.0f %% less thrust than its command should (95 %%: %.0f to %.0f %%): it needs "
        "%.0f %% more than its share in steady flight. A damaged propeller or a weak motor does this.",
        rotor + 1, -100 * scale, -100 * (scale + half), -100 * (scale - half), 100 * extra);
    if (effect) {
      f.equation = effect->info().equation;
      f.latex = effect->info().latex;
      physics::ActiveEffect active{effect, {}};
      for (const auto& p : effect->info().parameters) active.theta.push_back(p.neutral);
      if (static_cast<std::size_t>(rotor) < active.theta.size()) {
        const auto& p = effect->info().parameters[static_cast<std::size_t>(rotor)];
        active.theta[static_cast<std::size_t>(rotor)] = std::clamp(scale, p.lower, p.upper);
        d.model.push_back(active);
      }
    }
  } else if (off_centre) {
    m.p_value = std::exp(-0.5 * (none - centre));
    const physics::Effect* effect = physics::find_effect("com_offset");
    f.effect = "com_offset";
    f.stage = physics::Stage::wrench;
    f.channels = {"Mx", "My"};
    f.probability = 1 / (1 + std::exp(-0.5 * (best - centre)));
    f.cannot_be_told_apart_from = {"payload_mass", "attachment_torque"};
    // the thrusts lean towards the centre of mass: roll torque tilts about x for an offset along y
    const double y = imbalance.x() * arm.x(), x = -imbalance.y() * arm.y();
    const double half_y = 1.96 * sigma.x() * arm.x(), half_x = 1.96 * sigma.y() * arm.y();
    f.parameters.push_back(value_of(effect, 0, "x", "m", x, half_x));
    f.parameters.push_back(value_of(effect, 1, "y", "m", y, half_y));
    f.sentence = format(
        "The centre of mass lies beside the middle: x = %+.1f mm, y = %+.1f mm (95 %%: +-%.1f mm). An "
        "added weight does this; no single rotor is to blame.",
        1e3 * x, 1e3 * y, 1e3 * half_y);
    if (effect) {
      f.equation = effect->info().equation;
      f.latex = effect->info().latex;
      d.model.push_back({effect, {x, y, 0.0}});
    }
  }
  if (broken || off_centre) {
    d.mismatch.push_back(m);
    d.findings.push_back(f);
    d.verdict = Verdict::explained;
    d.summary = f.sentence;
  } else {
    d.summary =
        "Nothing is missing: the motors share the load as evenly as motors of one kind do (" + m.where + ").";
  }
  d.summary +=
      " There is no attitude or no force: only the balance of the motors in steady flight "
      "was "
      "judged; forces, drag, load and wind cannot be told." +
      notes;
  for (const std::string& what : d.left_out) d.summary += " Left out: " + what + ".";
  return d;
}

}  // namespace omniflight::diagnosis
