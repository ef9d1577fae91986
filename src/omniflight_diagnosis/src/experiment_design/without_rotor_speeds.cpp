#include "without_rotor_speeds.hpp"

#include <algorithm>
#include <optional>

#include "../conditioning/tilt_servo.hpp"
#include "../search/offered_effects.hpp"
#include "../sensor_checks/inverse_dynamics.hpp"
#include "detectability.hpp"
#include "least_thrusts.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kTelemetry = 0.002;  // relative noise of simulated rotor speed telemetry; chosen

/// Rotor speeds [rad/s] by inverse dynamics and minimum-norm allocation.
recording::Signal nominal_speeds(const MotionOnGrid& m, const Eigen::MatrixXd& tilt,
                                 const vehicle::Vehicle& v) {
  recording::Signal out;
  out.name = "rotor_speed";
  out.unit = "rad/s";
  out.t_s = m.t;
  out.values.resize(m.force.rows(), v.rotor_count());
  Random random(1, "rotors that nobody recorded");
  std::optional<LeastThrusts> thrusts;
  double at = std::nan("");
  for (Eigen::Index i = 0; i < m.force.rows(); ++i) {
    const double alpha = tilt.size() > 0 && std::isfinite(tilt(i, 0)) ? tilt(i, 0) : 0.0;
    if (!(alpha == at)) {
      at = alpha;
      thrusts.emplace(v, alpha);
    }
    const Vec3 w = m.w.row(i).transpose(), dw = m.dw.row(i).transpose();
    Vec6 wrench;
    wrench << v.mass * m.force.row(i).transpose(), v.inertia * dw + w.cross(v.inertia * w);
    const vehicle::RotorVector thrust = (*thrusts)(wrench);
    for (int k = 0; k < v.rotor_count(); ++k) {
      const vehicle::Rotor& rotor = v.rotors[static_cast<std::size_t>(k)];
      const double speed = rotor.speed(std::clamp(thrust[k], rotor.lower_thrust(), rotor.max_thrust));
      out.values(i, k) = speed * (1 + kTelemetry * random.normal());
    }
  }
  return out;
}

std::string list(const std::vector<std::string>& names, const char* between) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : between) + name;
  return out;
}

}  // namespace

void add_detectability_with_rotor_speeds(const recording::Recording& r, const vehicle::Vehicle& v,
                                         const Options& o, Intake& intake) {
  if (!r.find("attitude") && !r.find("est_attitude")) return;
  const auto motion = motion_on_grid(r, o);
  if (!motion || !motion->in_body || motion->w.size() == 0) return;
  recording::Recording whole = r;
  whole.signals["rotor_speed"] = nominal_speeds(*motion, tilt_at(r, v, motion->t), v);
  const auto flight = prepare_flight(whole, v, o);
  if (!flight) return;
  const std::vector<const Flight*> used{&*flight};
  describe_candidates(used, v, offered_effects(used, v, o), o, intake);
}

std::string detectability_in_words(const Intake& intake) {
  if (intake.detectability.empty()) return "";
  std::vector<std::string> seen, groups;
  for (const Detectability& x : intake.detectability)
    if (x.sigma >= 3) seen.push_back(x.effect);
  for (const auto& group : intake.alias_groups) groups.push_back(list(group, " = "));
  std::string out =
      seen.empty()
          ? " Even with rotor speeds this motion would show no effect of ordinary size."
          : " With rotor speeds this motion could show at best, at ordinary sizes: " + list(seen, ", ") + ".";
  if (!groups.empty()) out += " Of these it could not tell apart: " + list(groups, "; ") + ".";
  return out;
}

}  // namespace omniflight::diagnosis
