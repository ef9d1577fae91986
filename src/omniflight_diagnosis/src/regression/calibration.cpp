#include "calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include "omniflight_diagnosis/residual.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::RotorSituation;
using physics::Situation;

/// Delay [s] between rotor speeds and IMU, one standard deviation: low-pass filters of autopilots cut between
/// 30 Hz (accelerometer of a Crazyflie) and 200 Hz and delay by 1 to 10 ms; telemetry of rotor speeds is
/// averaged over some revolutions.
constexpr double kFilterDelay = 0.005;

/// Exponent of thrust over rotor speed, one standard deviation about 2: thrust stands find 1.9 to 2.1.
constexpr double kThrustExponent = 0.05;

/// Half the second derivative of ln thrust by ln speed where thrust is modelled from duty cycles, one
/// standard deviation: between a linear and a quadratic law of the duty cycle it is at most 1/8 /
/// kDutyToSpeed^2.
constexpr double kDutyCurvature = 0.1;

/// Calibration::settled of quantities that do not depend on how well the vehicle was measured (air density,
/// filters).
constexpr double kSettled = 1;

/// Cosine of the largest tilt of the body at which a sample counts as level (15 deg), and samples [s] of that
/// kind which a recording must have for a hover. Chosen.
constexpr double kLevel = 0.966, kLeastHover = 1;

/// Numbers of parts, whose errors add up to what is told of the whole vehicle.
constexpr std::array<std::string_view, 5> kOfParts{"rotor_scale", "rotor_axis", "rotor_place", "drag_torque",
                                                   "center_of_mass"};

constexpr const char* kAxis[] = {"x", "y", "z"};

Tolerance tolerance_of(const vehicle::Vehicle& vehicle, const Options& options) {
  Tolerance out = options.tolerance;
  for (const auto& [kind, value] : vehicle.tolerance)
    if (out.told.insert(kind).second) out.value(kind) = std::max(kLeastTolerance, value);
  return out;
}

/// Wrench of the rotor's thrust, and its drag torque, along axis_B instead of its own axis.
Vec6 at_rotor(const RotorSituation& r, const Vec3& axis_B) {
  Vec6 wrench;
  wrench << axis_B, r.p_BR.cross(axis_B) + r.spin * r.drag_ratio * axis_B;
  return r.thrust * wrench;
}

class Columns {
 public:
  Columns(const RegressionProblem& problem, const vehicle::Vehicle& vehicle, const Options& options)
      : problem_(problem),
        vehicle_(vehicle),
        tol_(tolerance_of(vehicle, options)),
        totals_bind_(options.assumes(Assumption::told_totals)) {}

  void of_constants();
  void of_body();
  void of_accelerometer();
  void of_rotors();
  void of_clocks(std::span<const Flight* const> flights);
  void of_thrust_law(const std::vector<double>& log_voltage);
  Calibration take();

 private:
  /// Adds the column kind_which: `deviation` (one standard deviation) times `wrench_at`, the wrench [N, Nm]
  /// per unit of the deviation at a situation and its sample index.
  template <class WrenchAt>
  void add(const char* kind, const std::string& which, double deviation, const WrenchAt& wrench_at,
           double settled = 0) {
    const int n = problem_.samples();
    const auto column_at = [&](States states) {
      Eigen::VectorXd x(problem_.rows());
      for (int i = 0; i < n; ++i) {
        const Vec6 w =
            deviation *
            wrench_at(states == States::predicted ? problem_.situation(i) : problem_.measured(i), i);
        for (int c = 0; c < 6; ++c) x[c * n + i] = modelled() && c >= 3 ? 0.0 : w[c];
      }
      return x;
    };
    keep(kind, which, column_at(States::predicted), column_at(States::measured), settled);
  }
  /// The same of a column that is there, at predicted and at measured states.
  void keep(const char* kind, const std::string& which, Eigen::VectorXd predicted, Eigen::VectorXd measured,
            double settled);
  Eigen::MatrixXd totals() const;
  bool modelled() const { return problem_.forces_only(); }
  double weight() const { return problem_.size().weight; }
  double arm() const { return problem_.size().arm; }
  int rotors() const { return problem_.samples() > 0 ? problem_.situation(0).rotor_count : 0; }

  const RegressionProblem& problem_;
  const vehicle::Vehicle& vehicle_;
  Tolerance tol_;
  bool totals_bind_;
  Calibration out_;
  std::vector<Eigen::VectorXd> columns_, measured_;
  std::vector<double> settled_;
  std::map<std::string, double> told_;
};

void Columns::keep(const char* kind, const std::string& which, Eigen::VectorXd predicted,
                   Eigen::VectorXd measured, double settled) {
  if (predicted.norm() < 1e-12 || !predicted.allFinite() || !measured.allFinite()) return;
  out_.names.push_back(which.empty() ? kind : kind + ("_" + which));
  out_.kinds.emplace_back(kind);
  const bool told = tol_.told.contains(kind);
  settled_.push_back(told ? 1.0 : settled);
  // the accelerometer does not inform how carefully the vehicle was measured
  if (told && out_.kinds.back() != "acceleration_bias")
    told_[kind] = std::log(tol_.value(kind) / Tolerance{}.value(kind));
  columns_.push_back(std::move(predicted));
  measured_.push_back(std::move(measured));
}

/// Constant torque in the body and constant force in the world.
void Columns::of_constants() {
  for (int k = 0; k < 3; ++k) {
    add("torque_trim", kAxis[k], tol_.torque_trim * weight() * arm(), [&](const Situation&, int) {
      Vec6 w = Vec6::Zero();
      w[3 + k] = 1;
      return w;
    });
    add("world_force", kAxis[k], tol_.world_force * weight(), [&](const Situation& s, int) {
      Vec6 w = Vec6::Zero();
      w.head<3>() = s.R_WB.row(k).transpose();
      return w;
    });
  }
}

/// Inertia and centre of mass, with the equations of the effects inertia_error and com_offset.
void Columns::of_body() {
  for (int k = 0; k < 3; ++k) {
    add("inertia", kAxis[k], tol_.inertia * vehicle_.inertia(k, k), [&](const Situation& s, int) {
      Vec6 w = Vec6::Zero();
      w[3 + k] = s.dw_WB_B[k];
      return w;
    });
    add("center_of_mass", kAxis[k], tol_.center_of_mass * arm(), [&](const Situation& s, int) {
      const Vec3 c = Vec3::Unit(k), &w = s.body.w_WB_B;
      Vec6 wrench;
      wrench << -vehicle_.mass * (s.dw_WB_B.cross(c) + w.cross(w.cross(c))),
          -vehicle_.mass * c.cross(Vec3(s.a_WB_B - s.g_B));
      return wrench;
    });
  }
}

void Columns::of_accelerometer() {
  for (int k = 0; k < 3; ++k) {
    // accelerometer bias; without accelerometer the equivalent of an attitude trim, which rotates gravity
    const double bias = modelled() ? tol_.modelled_trim * kGravity * 0.1
                        : k < 2    ? tol_.accelerometer_lateral
                                   : tol_.accelerometer_vertical;
    add("acceleration_bias", kAxis[k], vehicle_.mass * bias, [&](const Situation&, int) {
      Vec6 w = Vec6::Zero();
      w[k] = 1;
      return w;
    });
    if (tol_.accelerometer_scale > 0)
      add("accelerometer_scale", kAxis[k], tol_.accelerometer_scale, [&](const Situation& s, int) {
        Vec6 w = Vec6::Zero();
        w[k] = physics::rotor_wrench(s)[k];
        return w;
      });
    if (tol_.accelerometer_misalignment > 0)
      add("accelerometer_turn", kAxis[k], tol_.accelerometer_misalignment, [&](const Situation& s, int) {
        Vec6 w = Vec6::Zero();
        w.head<3>() = Vec3::Unit(k).cross(physics::rotor_wrench(s).head<3>());
        return w;
      });
    if (!modelled())  // lever-arm acceleration
      add("imu_position", kAxis[k], tol_.imu_position * arm(), [&](const Situation& s, int) {
        Vec6 w = Vec6::Zero();
        w.head<3>() = vehicle_.mass * beside_origin(Vec3::Unit(k), s.body.w_WB_B, s.dw_WB_B);
        return w;
      });
  }
}

void Columns::of_rotors() {
  const double thrust = std::hypot(tol_.thrust_scale, tol_.air_density);
  add(
      "thrust_scale", "", modelled() ? 0.1 * tol_.modelled_scale : thrust,
      [](const Situation& s, int) { return physics::rotor_wrench(s); },
      modelled() ? kSettled : std::pow(tol_.air_density / std::max(1e-12, thrust), 2));
  if (modelled()) return;
  add("drag_torque", "", tol_.drag_torque, [](const Situation& s, int) {
    Vec6 w = Vec6::Zero();
    for (const RotorSituation& r : s.all_rotors()) w.tail<3>() += r.thrust * r.spin * r.drag_ratio * r.n_B;
    return w;
  });
  for (int r = 0; r < rotors(); ++r) {
    const auto at = static_cast<std::size_t>(r);
    const std::string number = std::to_string(r + 1);
    add("rotor_scale", number, tol_.rotor_scale,
        [at](const Situation& s, int) { return at_rotor(s.rotors[at], s.rotors[at].n_B); });
    for (int k = 0; k < 2; ++k) {
      const auto across = [k](const Vec3& n) {
        const Vec3 first = n.unitOrthogonal();
        return k == 0 ? first : Vec3(n.cross(first));
      };
      add("rotor_place", number + kAxis[k], tol_.rotor_place * arm(), [&](const Situation& s, int) {
        const RotorSituation& rotor = s.rotors[at];
        Vec6 w = Vec6::Zero();
        w.tail<3>() = rotor.thrust * across(rotor.n_B).cross(rotor.n_B);
        return w;
      });
      add("rotor_axis", number + kAxis[k], tol_.rotor_axis,
          [&](const Situation& s, int) { return at_rotor(s.rotors[at], across(s.rotors[at].n_B)); });
    }
  }
}

/// Delay between rotor speeds and IMU (time stamps, filters; motor time constants where speeds come from
/// commands), separately for forces (accelerometer) and torques (gyro). To first order the time derivative of
/// the rotor wrench; where speeds come from commands the drives are simulated, since commands predict their
/// own delay far better than the motion before predicts an acceleration of the rotors.
void Columns::of_clocks(std::span<const Flight* const> flights) {
  const bool commands = !flights.empty() && flights.front()->speed_from_command;
  double late = std::max(tol_.rotor_clock, kFilterDelay);
  if (commands)
    for (const vehicle::Rotor& r : vehicle_.rotors) late = std::max(late, tol_.motor_lag * r.time_constant);
  const Eigen::Index n = problem_.samples();
  Eigen::VectorXd predicted, measured;
  if (commands) {
    predicted = problem_.of_command_delay(late, States::predicted);
    measured = problem_.of_command_delay(late, States::measured);
  }
  for (int half = 0; half < 2; ++half) {
    const char* which = half == 0 ? "force" : "torque";
    if (commands) {
      const auto part = [&](Eigen::VectorXd x) {
        x.segment(3 * (1 - half) * n, 3 * n).setZero();
        return x;
      };
      keep("rotor_clock", which, part(predicted), part(measured), kSettled);
      continue;
    }
    add(
        "rotor_clock", which, -late,
        [half](const Situation& s, int) {
          Situation rate = s;
          for (int k = 0; k < s.rotor_count; ++k) {
            const RotorSituation& r = s.rotors[static_cast<std::size_t>(k)];
            rate.rotors[static_cast<std::size_t>(k)].thrust =
                2 * r.thrust_coefficient * std::abs(r.speed) * r.acceleration;
          }
          Vec6 wrench = physics::rotor_wrench(rate);
          wrench.segment<3>(3 - 3 * half).setZero();
          return wrench;
        },
        kSettled);
  }
}

/// Thrust over speed: its exponent, T ln(Omega / mean) along each rotor. That of a thrust from duty cycles is
/// no power of any: there is also T ln(Omega / mean)^2, and the wrench times ln(voltage / mean).
void Columns::of_thrust_law(const std::vector<double>& log_voltage) {
  double mean = 0;
  for (int i = 0; i < problem_.samples(); ++i)
    for (const RotorSituation& r : problem_.situation(i).all_rotors()) mean += std::abs(r.speed);
  mean = std::max(1.0, mean / std::max(1, problem_.samples() * rotors()));
  const auto by_speed = [&](const char* kind, double deviation, int power) {
    add(
        kind, "", deviation,
        [mean, power](Situation s, int) {
          for (int k = 0; k < s.rotor_count; ++k) {
            RotorSituation& r = s.rotors[static_cast<std::size_t>(k)];
            const double ratio = std::log(std::max(0.1, std::abs(r.speed) / mean));
            r.thrust *= power == 1 ? ratio : ratio * ratio;
          }
          return physics::rotor_wrench(s);
        },
        kSettled);
  };
  by_speed("thrust_exponent", modelled() ? tol_.modelled_exponent : kThrustExponent, 1);
  if (!modelled()) return;
  by_speed("thrust_curvature", kDutyCurvature, 2);
  add(
      "thrust_voltage", "", tol_.modelled_voltage,
      [&log_voltage](const Situation& s, int i) {
        return Vec6(physics::rotor_wrench(s) * log_voltage[static_cast<std::size_t>(i)]);
      },
      kSettled);
}

/// Calibration::totals. A laboratory that tells how well thrust carries the weight, or how small the torque
/// of hover is, tells it of all parts together, however they were put right; their numbers one by one may
/// still be as wrong as is assumed.
Eigen::MatrixXd Columns::totals() const {
  const auto count = static_cast<Eigen::Index>(columns_.size());
  const int n = problem_.samples();
  Vec6 inverse = Vec6::Zero();
  if (tol_.told.contains("world_force")) inverse.head<2>().setConstant(1 / (tol_.world_force * weight()));
  if (tol_.told.contains("thrust_scale"))
    inverse[2] = 1 / (std::hypot(tol_.thrust_scale, tol_.world_force) * weight());
  if (tol_.told.contains("torque_trim"))
    inverse.tail<3>().setConstant(1 / (tol_.torque_trim * weight() * arm()));
  std::vector<int> level;
  for (int i = 0; i < n; ++i)
    if (problem_.measured(i).R_WB(2, 2) > kLevel) level.push_back(i);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(6, count);
  if (static_cast<double>(level.size()) * problem_.period() < kLeastHover || !totals_bind_) return out;
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto at = static_cast<std::size_t>(k);
    if (std::find(kOfParts.begin(), kOfParts.end(), out_.kinds[at]) == kOfParts.end()) continue;
    Vec6 sum = Vec6::Zero();
    for (const int i : level) {
      Vec6 w;
      for (int c = 0; c < 6; ++c) w[c] = measured_[at][c * n + i];
      sum.head<3>() += problem_.measured(i).R_WB * w.head<3>();
      sum.tail<3>() += w.tail<3>();
    }
    out.col(k) = inverse.cwiseProduct(sum) / static_cast<double>(level.size());
  }
  return out;
}

Calibration Columns::take() {
  out_.totals = totals();
  const auto count = static_cast<Eigen::Index>(columns_.size());
  out_.columns.resize(problem_.rows(), count);
  out_.measured.resize(problem_.rows(), count);
  for (Eigen::Index k = 0; k < count; ++k) {
    out_.columns.col(k) = columns_[static_cast<std::size_t>(k)];
    out_.measured.col(k) = measured_[static_cast<std::size_t>(k)];
  }
  out_.settled = Eigen::Map<const Eigen::VectorXd>(settled_.data(), count);
  for (const auto& [kind, log_ratio] : told_) out_.told.push_back(log_ratio);
  return std::move(out_);
}

}  // namespace

Calibration calibrate(const RegressionProblem& problem, std::span<const Flight* const> flights,
                      const vehicle::Vehicle& vehicle, const Options& options,
                      const std::vector<double>& log_voltage) {
  Columns columns(problem, vehicle, options);
  columns.of_constants();
  columns.of_body();
  columns.of_accelerometer();
  columns.of_rotors();
  columns.of_clocks(flights);
  columns.of_thrust_law(log_voltage);
  return columns.take();
}

}  // namespace omniflight::diagnosis
