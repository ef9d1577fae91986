#include "regression_problem.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "omniflight_diagnosis/residual.hpp"
#include "predetermined.hpp"

namespace omniflight::diagnosis {
namespace {

/// Longest stretch [s] over which the memory of a swinging load is predicted from one initial state: some
/// periods of a pendulum; beyond, small errors of its frequency add up.
constexpr double kMemoryWindow = 10;

/// Delay [s] between rotor speeds and IMU, one standard deviation: low-pass filters of autopilots cut between
/// 30 Hz (accelerometer of a Crazyflie) and 200 Hz and delay by 1 to 10 ms; telemetry of rotor speeds is
/// averaged over some revolutions.
constexpr double kFilterDelay = 0.005;

/// Exponent of thrust over rotor speed, one standard deviation about 2: thrust stands find 1.9 to 2.1.
constexpr double kThrustExponent = 0.05;

/// Share of the variance of what is physics or telemetry, and no matter of how well a vehicle was measured.
constexpr double kSettled = 1;

/// Fixed point of accelerations with loads: a load of half the vehicle converges by three a turn.
constexpr int kExpectations = 12;
constexpr double kExpected = 1e-3;  ///< RMS force over the weight

/// Relative step of the numerical derivative by an initial state.
constexpr double kStartStep = 1e-4;

}  // namespace

RegressionProblem::RegressionProblem(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                                     const Options& options, double horizon_s)
    : flight_count_(static_cast<int>(flights.size())),
      period_(1.0 / options.grid_hz),
      size_(physics::size_of(vehicle, options.environment.gravity)) {
  const Mat3 c = skew(vehicle.center_of_mass);
  inertia_ << vehicle.mass * Mat3::Identity(), -vehicle.mass * c, vehicle.mass * c,
      vehicle.inertia - vehicle.mass * c * c;
  const int lag = std::max(1, static_cast<int>(std::ceil(horizon_s / period_ - 1e-9)));
  std::vector<Vec6> rest;
  lowest_.setConstant(1e18);
  highest_.setConstant(-1e18);
  for (int k = 0; k < flight_count_; ++k) {
    const Flight& f = *flights[static_cast<std::size_t>(k)];
    forces_only_ = forces_only_ || f.thrust_modelled;
    for (const Segment& segment : f.segments) {
      std::vector<physics::Situation> ahead =
          predetermined(f, segment, inertia_, vehicle.center_of_mass, period_, lag);
      stretches_.push_back({n_, n_ + segment.end - segment.begin, k});
      for (int i = segment.begin; i < segment.end; ++i, ++n_) {
        const physics::Situation& now = f.situation[static_cast<std::size_t>(i)];
        rest.push_back(wrench_residual(now, now.a_WB_B - now.g_B, vehicle.center_of_mass));
        situation_.push_back(ahead[static_cast<std::size_t>(i - segment.begin)]);
        measured_.push_back(now);
        const bool modelled = f.log_drive.size() > 0;
        drive_.push_back({modelled ? f.log_drive[i] : 0.0, modelled ? f.log_voltage[i] : 0.0});
        const Vec3& p = now.body.p_WB;
        lowest_ = lowest_.cwiseMin(p);
        highest_ = highest_.cwiseMax(p);
        mean_ += p;
      }
    }
  }
  if (n_ > 0) mean_ /= n_;
  for (const Stretch& s : stretches_) {
    const int parts = std::max(1, static_cast<int>(std::lround(s.size() * period_ / kMemoryWindow)));
    for (int k = 0; k < parts; ++k)
      windows_.push_back({s.begin + k * s.size() / parts, s.begin + (k + 1) * s.size() / parts, s.flight});
  }
  lever_.setConstant(1e-4 * size_.arm);
  for (const physics::Situation& now : situation_)
    for (const physics::RotorSituation& r : now.all_rotors())
      lever_ = lever_.cwiseMax((r.p_BR.cross(r.n_B) + r.spin * r.drag_ratio * r.n_B).cwiseAbs());
  y_.resize(rows());
  for (int i = 0; i < n_; ++i)
    for (int ch = 0; ch < 6; ++ch)
      y_[ch * n_ + i] = forces_only_ && ch >= 3 ? 0.0 : rest[static_cast<std::size_t>(i)][ch];
  expected_.setZero(rows());
  calibrate(flights, vehicle, options);
}

void RegressionProblem::expect(const Eigen::VectorXd& wrench) {
  const Eigen::PartialPivLU<Mat6> mass(inertia_);
  for (int i = 0; i < n_; ++i) {
    Vec6 more;
    for (int c = 0; c < 6; ++c) more[c] = wrench[c * n_ + i] - expected_[c * n_ + i];
    situation_[static_cast<std::size_t>(i)].a_WB_B += mass.solve(more).head<3>();
  }
  expected_ = wrench;
}

void RegressionProblem::expect(std::span<const EffectTerm> terms) {
  for (int k = 0; k < kExpectations; ++k) {
    const Eigen::VectorXd sum = wrench_of(terms);
    if (expects(sum)) return;
    expect(sum);
  }
}

bool RegressionProblem::expects(const Eigen::VectorXd& wrench) const {
  return (wrench - expected_).head(3 * n_).norm() <= kExpected * size_.weight * std::sqrt(n_);
}

void RegressionProblem::calibrate(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                                  const Options& options) {
  Tolerance tol = options.tolerance;
  for (const auto& [kind, value] : vehicle.tolerance)
    if (tol.told.insert(kind).second) tol.value(kind) = std::max(kLeastTolerance, value);
  std::vector<Eigen::VectorXd> columns, measured;
  std::vector<double> settled;
  std::map<std::string, double> told;
  const auto add = [&](const std::string& kind, const std::string& which, double deviation,
                       const auto& wrench_at, double settled_share = 0) {
    const auto column_at = [&](States states) {
      Eigen::VectorXd x(rows());
      for (int i = 0; i < n_; ++i) {
        const Vec6 w = deviation * wrench_at(at(states)[static_cast<std::size_t>(i)], i);
        for (int c = 0; c < 6; ++c) x[c * n_ + i] = forces_only_ && c >= 3 ? 0.0 : w[c];
      }
      return x;
    };
    Eigen::VectorXd x = column_at(States::predicted), m = column_at(States::measured);
    if (x.norm() < 1e-12 || !x.allFinite() || !m.allFinite()) return;
    calibration_.names.push_back(which.empty() ? kind : kind + "_" + which);
    calibration_.kinds.push_back(kind);
    settled.push_back(tol.told.contains(kind) ? 1.0 : settled_share);
    // how well an accelerometer is known says nothing of the vehicle
    if (tol.told.contains(kind) && kind != "acceleration_bias")
      told[kind] = std::log(tol.value(kind) / Tolerance{}.value(kind));
    columns.push_back(std::move(x));
    measured.push_back(std::move(m));
  };
  using physics::Situation;
  const char* const axis[] = {"x", "y", "z"};
  const bool modelled = forces_only_;
  const double thrust = std::hypot(tol.thrust_scale, tol.air_density);
  add(
      "thrust_scale", "", modelled ? 0.1 * tol.modelled_scale : thrust,
      [](const Situation& s, int) { return physics::rotor_wrench(s); },
      modelled ? kSettled : std::pow(tol.air_density / std::max(1e-12, thrust), 2));
  for (int k = 0; k < 3; ++k) {
    const double torque = tol.torque_trim * size_.weight * size_.arm;
    add("torque_trim", axis[k], torque, [&](const Situation&, int) {
      Vec6 w = Vec6::Zero();
      w[3 + k] = 1;
      return w;
    });
    add("world_force", axis[k], tol.world_force * size_.weight, [&](const Situation& s, int) {
      Vec6 w = Vec6::Zero();
      w.head<3>() = s.R_WB.row(k).transpose();
      return w;
    });
    // bias of the accelerometer, or, without one, trim of the attitude that turns gravity
    const double bias = modelled ? tol.modelled_trim * kGravity * 0.1
                        : k < 2  ? tol.accelerometer_lateral
                                 : tol.accelerometer_vertical;
    add("acceleration_bias", axis[k], vehicle.mass * bias, [&](const Situation&, int) {
      Vec6 w = Vec6::Zero();
      w[k] = 1;
      return w;
    });
    add("inertia", axis[k], tol.inertia * vehicle.inertia(k, k), [&](const Situation& s, int) {
      Vec6 w = Vec6::Zero();
      w[3 + k] = s.dw_WB_B[k];
      return w;
    });
    if (tol.accelerometer_scale > 0)
      add("accelerometer_scale", axis[k], tol.accelerometer_scale, [&](const Situation& s, int) {
        Vec6 w = Vec6::Zero();
        w[k] = physics::rotor_wrench(s)[k];
        return w;
      });
    if (tol.accelerometer_misalignment > 0)
      add("accelerometer_turn", axis[k], tol.accelerometer_misalignment, [&](const Situation& s, int) {
        Vec6 w = Vec6::Zero();
        w.head<3>() = Vec3::Unit(k).cross(physics::rotor_wrench(s).head<3>());
        return w;
      });
  }
  // the vehicle file, by the laws of the effects that say the same beyond tolerance
  for (int k = 0; k < 3; ++k) {
    add("center_of_mass", axis[k], tol.center_of_mass * size_.arm, [&](const Situation& s, int) {
      const Vec3 c = Vec3::Unit(k), &w = s.body.w_WB_B;
      Vec6 wrench;
      wrench << -vehicle.mass * (s.dw_WB_B.cross(c) + w.cross(w.cross(c))),
          -vehicle.mass * c.cross(Vec3(s.a_WB_B - s.g_B));
      return wrench;
    });
    if (!modelled)  // an accelerometer beside the origin reads what the motion adds there
      add("imu_position", axis[k], tol.imu_position * size_.arm, [&](const Situation& s, int) {
        Vec6 wrench = Vec6::Zero();
        wrench.head<3>() = vehicle.mass * beside_origin(Vec3::Unit(k), s.body.w_WB_B, s.dw_WB_B);
        return wrench;
      });
  }
  add("drag_torque", "", modelled ? 0.0 : tol.drag_torque, [](const Situation& s, int) {
    Vec6 wrench = Vec6::Zero();
    for (const physics::RotorSituation& r : s.all_rotors())
      wrench.tail<3>() += r.thrust * r.spin * r.drag_ratio * r.n_B;
    return wrench;
  });
  const int rotors = n_ > 0 ? situation(0).rotor_count : 0;
  for (int r = 0; r < rotors; ++r) {
    const auto at = static_cast<std::size_t>(r);
    const auto along = [](const physics::RotorSituation& x, const Vec3& axis_B) {
      Vec6 wrench;
      wrench << axis_B, x.p_BR.cross(axis_B) + x.spin * x.drag_ratio * axis_B;
      return Vec6(x.thrust * wrench);
    };
    add("rotor_scale", std::to_string(r + 1), modelled ? 0.0 : tol.rotor_scale,
        [&](const Situation& s, int) { return along(s.rotors[at], s.rotors[at].n_B); });
    for (int k = 0; k < 2; ++k)
      add("rotor_place", std::to_string(r + 1) + axis[k], modelled ? 0.0 : tol.rotor_place * size_.arm,
          [&](const Situation& s, int) {
            const physics::RotorSituation& rotor = s.rotors[at];
            const Vec3 first = rotor.n_B.unitOrthogonal();
            Vec6 wrench = Vec6::Zero();
            wrench.tail<3>() =
                rotor.thrust * (k == 0 ? first : Vec3(rotor.n_B.cross(first))).cross(rotor.n_B);
            return wrench;
          });
    for (int k = 0; k < 2; ++k)
      add("rotor_axis", std::to_string(r + 1) + axis[k], modelled ? 0.0 : tol.rotor_axis,
          [&](const Situation& s, int) {
            const Vec3& n = s.rotors[at].n_B;
            const Vec3 first = n.unitOrthogonal();
            return along(s.rotors[at], k == 0 ? first : Vec3(n.cross(first)));
          });
  }
  // Stamps and filters of the accelerometer, of the gyroscope, and, where speeds are modelled from commands,
  // the motors' time constants shift the rotors' wrench in time, forces and torques apart.
  double late = std::max(tol.rotor_clock, kFilterDelay);
  if (!flights.empty() && flights.front()->speed_from_command)
    for (const vehicle::Rotor& r : vehicle.rotors) late = std::max(late, tol.motor_lag * r.time_constant);
  for (int half = 0; half < 2; ++half)
    add(
        "rotor_clock", half == 0 ? "force" : "torque", late,
        [half](const Situation& s, int) {
          Situation rate = s;
          for (int k = 0; k < s.rotor_count; ++k) {
            const physics::RotorSituation& r = s.rotors[static_cast<std::size_t>(k)];
            rate.rotors[static_cast<std::size_t>(k)].thrust =
                2 * r.thrust_coefficient * std::abs(r.speed) * r.acceleration;
          }
          Vec6 wrench = physics::rotor_wrench(rate);
          wrench.segment<3>(3 - 3 * half).setZero();
          return wrench;
        },
        kSettled);
  if (!modelled) {
    double mean = 0;
    for (const Situation& s : situation_)
      for (const physics::RotorSituation& r : s.all_rotors()) mean += std::abs(r.speed);
    mean = std::max(1.0, mean / std::max(1, n_ * rotors));
    add(
        "thrust_exponent", "", kThrustExponent,
        [mean](Situation s, int) {
          for (int k = 0; k < s.rotor_count; ++k) {
            physics::RotorSituation& r = s.rotors[static_cast<std::size_t>(k)];
            r.thrust *= std::log(std::max(0.1, std::abs(r.speed) / mean));
          }
          return physics::rotor_wrench(s);
        },
        kSettled);
  } else {
    add(
        "thrust_exponent", "", tol.modelled_exponent,
        [&](const Situation& s, int i) {
          return Vec6(physics::rotor_wrench(s) * drive_[static_cast<std::size_t>(i)][0]);
        },
        kSettled);
    add(
        "thrust_voltage", "", tol.modelled_voltage,
        [&](const Situation& s, int i) {
          return Vec6(physics::rotor_wrench(s) * drive_[static_cast<std::size_t>(i)][1]);
        },
        kSettled);
  }
  calibration_.columns.resize(rows(), static_cast<Eigen::Index>(columns.size()));
  calibration_.measured.resize(rows(), static_cast<Eigen::Index>(columns.size()));
  calibration_.settled =
      Eigen::Map<const Eigen::VectorXd>(settled.data(), static_cast<Eigen::Index>(settled.size()));
  for (const auto& [kind, log_ratio] : told) calibration_.told.push_back(log_ratio);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    calibration_.columns.col(static_cast<Eigen::Index>(k)) = columns[k];
    calibration_.measured.col(static_cast<Eigen::Index>(k)) = measured[k];
  }
}

physics::ParameterPrior RegressionProblem::prior(const physics::Effect& effect, std::size_t k) const {
  physics::ParameterPrior prior = physics::prior_of(effect, k, size_);
  const physics::Parameter& p = effect.info().parameters[k];
  if (p.unit != "m" || prior.law == physics::ParameterPrior::Law::half_normal) return prior;
  const double range = std::max(0.3, highest_.z() - lowest_.z());
  const auto place = [&](double center, double scale) {
    prior.law = physics::ParameterPrior::Law::normal;
    prior.center = std::clamp(center, p.lower, p.upper);
    prior.scale = scale;
  };
  if (p.name == "anchor_x" || p.name == "anchor_y")
    place(mean_[p.name == "anchor_x" ? 0 : 1], 1.0);
  else if (p.name == "start_height")
    place(lowest_.z(), range);
  else if (p.name == "anchor_height" || p.name == "anchor_z")
    place(highest_.z() + 1.0, 1.0);
  else if (p.name == "height")
    place(highest_.z() + 0.3, 0.5);
  return prior;
}

void RegressionProblem::replay(const EffectTerm& term, Eigen::VectorXd& value, Eigen::MatrixXd* by_theta,
                               Eigen::MatrixXd* by_start, States states_at) const {
  const physics::Effect& effect = *term.effect;
  const int parameters = by_theta ? effect.parameter_count() : 0;
  const std::vector<double> spread = effect.start_spread(term.theta.data());
  const auto states = static_cast<Eigen::Index>(spread.size());
  const auto count = static_cast<Eigen::Index>(windows_.size()) * states;
  if (by_start) by_start->setZero(rows(), count);
  std::vector<double> w, j, moved, offset(spread.size());
  const std::vector<Stretch>& parts = spread.empty() ? stretches_ : windows_;
  for (std::size_t part = 0; part < parts.size(); ++part) {
    const Stretch& s = parts[part];
    const auto length = static_cast<std::size_t>(s.size());
    const std::span<const physics::Situation> motion{at(states_at).data() + s.begin, length};
    w.resize(6 * length);
    const auto scatter = [&](const std::vector<double>& from, std::size_t offset_at, auto&& column) {
      for (std::size_t i = 0; i < length; ++i)
        for (std::size_t c = 0; c < 6; ++c)
          column[static_cast<Eigen::Index>(c) * n_ + s.begin + static_cast<Eigen::Index>(i)] =
              from[offset_at + 6 * i + c];
    };
    const auto first = static_cast<Eigen::Index>(part) * states;
    for (Eigen::Index k = 0; k < states; ++k)
      offset[static_cast<std::size_t>(k)] = term.start.size() == count ? term.start[first + k] : 0.0;
    if (parameters > 0 && spread.empty()) {
      j.resize(6 * length * static_cast<std::size_t>(parameters));
      effect.replay(motion, period_, term.theta.data(), w.data(), j.data());
      for (int k = 0; k < parameters; ++k)
        scatter(j, 6 * length * static_cast<std::size_t>(k), by_theta->col(k));
    }
    if (spread.empty()) {
      if (parameters == 0) effect.replay(motion, period_, term.theta.data(), w.data(), nullptr);
      scatter(w, 0, value);
      continue;
    }
    effect.replay_from(motion, period_, term.theta.data(), offset.data(), w.data());
    scatter(w, 0, value);
    moved.resize(w.size());
    if (parameters > 0) {  // the exact derivative starts at rest: replaced by differences from this start
      std::vector<double> theta = term.theta;
      for (int k = 0; k < parameters; ++k) {
        const physics::ParameterPrior p = prior(effect, static_cast<std::size_t>(k));
        const double step = 1e-4 * std::abs(p.slope(0));
        theta[static_cast<std::size_t>(k)] += step;
        effect.replay_from(motion, period_, theta.data(), offset.data(), moved.data());
        theta[static_cast<std::size_t>(k)] = term.theta[static_cast<std::size_t>(k)];
        for (std::size_t i = 0; i < w.size(); ++i) moved[i] = (moved[i] - w[i]) / step;
        scatter(moved, 0, by_theta->col(k));
      }
    }
    if (!by_start) continue;
    for (Eigen::Index k = 0; k < states; ++k) {
      const double deviation = spread[static_cast<std::size_t>(k)], step = kStartStep * deviation;
      if (deviation <= 0) continue;
      offset[static_cast<std::size_t>(k)] += step;
      effect.replay_from(motion, period_, term.theta.data(), offset.data(), moved.data());
      offset[static_cast<std::size_t>(k)] -= step;
      for (std::size_t i = 0; i < w.size(); ++i) moved[i] = (moved[i] - w[i]) / step;
      scatter(moved, 0, by_start->col(first + k));
    }
  }
}

void RegressionProblem::wrench_of(const EffectTerm& term, Eigen::VectorXd& value, Eigen::MatrixXd* by_theta,
                                  Eigen::MatrixXd* by_start, States states) const {
  const physics::Effect& effect = *term.effect;
  const int parameters = by_theta ? effect.parameter_count() : 0;
  const std::vector<physics::Situation>& situations = at(states);
  value.resize(rows());
  if (by_theta) by_theta->resize(rows(), parameters);
  if (effect.memory_size().total() > 0) {
    replay(term, value, by_theta, by_start, states);
  } else {
    if (by_start) by_start->resize(rows(), 0);
    std::array<double, 6> w{};
    std::array<double, 6 * physics::kMaxParameters> j{};
    for (int i = 0; i < n_; ++i) {
      const physics::Situation& now = situations[static_cast<std::size_t>(i)];
      if (by_theta) {
        effect.wrench_with_jacobian(now, term.theta.data(), w.data(), j.data());
      } else {
        physics::Wrench added;
        effect.add_wrench(now, term.theta.data(), added);
        Eigen::Map<Vec6>(w.data()) = added.at(now);
      }
      for (int c = 0; c < 6; ++c) {
        value[c * n_ + i] = w[static_cast<std::size_t>(c)];
        for (int k = 0; k < parameters; ++k)
          (*by_theta)(c * n_ + i, k) = j[static_cast<std::size_t>(6 * k + c)];
      }
    }
  }
  if (!forces_only_) return;
  value.tail(3 * n_).setZero();
  if (by_theta) by_theta->bottomRows(3 * n_).setZero();
  if (by_start && by_start->cols() > 0) by_start->bottomRows(3 * n_).setZero();
}

Eigen::VectorXd RegressionProblem::wrench_of(std::span<const EffectTerm> terms, States states) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(rows()), value;
  for (const EffectTerm& term : terms) {
    wrench_of(term, value, nullptr, nullptr, states);
    sum += value;
  }
  return sum;
}

}  // namespace omniflight::diagnosis
