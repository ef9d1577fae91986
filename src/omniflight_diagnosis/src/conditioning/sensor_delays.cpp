#include "sensor_delays.hpp"

#include <array>
#include <cmath>
#include <initializer_list>

#include "../numerics/log_factor.hpp"
#include "../numerics/text.hpp"
#include "omniflight_physics/effect_ids.hpp"
#include "omniflight_physics/prior.hpp"

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured.
constexpr double kDelay = 0.03;          // s, prior deviation of what comes late
constexpr double kFilterOfGyro = 0.003;  // s, delay of the filters that flight controllers usually have
constexpr double kRival = 3;             // nat

struct Cause {
  const char* effect;
  bool behind_pose, behind_rotors;  ///< which delays it makes
  bool responds;                    ///< it smooths, and does not only shift
};
constexpr std::array kCauses{Cause{physics::effect_id::clock_offset, true, false, false},
                             Cause{physics::effect_id::sensor_filter, true, true, true},
                             Cause{physics::effect_id::dynamic_inflow, false, true, true}};

/// A measured delay and its variance where nothing is late.
struct Measured {
  double delay = 0, variance = 0;  ///< s, s^2
};

/// ln Bayes factor of one normal delay that makes those of `late` against none.
double log_factor_of_delay(std::initializer_list<const Measured*> late) {
  double weight = 0, pull = 0;
  for (const Measured* m : late)
    if (m) {
      weight += 1 / m->variance;
      pull += m->delay / m->variance;
    }
  return weight > 0 ? log_factor_of_size(pull / weight, 1 / std::sqrt(weight), kDelay) : 0;
}

/// Parameters of dynamic_inflow that respond like that to small changes about hover, where the settled inflow
/// w changes by w / (2 T) per thrust.
std::vector<ParameterValue> inflow_of(const ThrustResponse& r, const vehicle::Vehicle& vehicle,
                                      const Options& o) {
  const physics::VehicleSize size = physics::size_of(vehicle, o.environment.gravity);
  const double radius = vehicle.rotors.front().radius, wide = 1.96 * r.time_se;
  std::vector<ParameterValue> out;
  if (radius > 0) {
    const double settled =
        std::sqrt(size.rotor_thrust / (2 * o.environment.air_density * kPi * radius * radius));
    const double k = 2 * r.lead * size.rotor_thrust / (size.rotor_speed * settled);
    out.push_back({"coefficient", "k_v", "kg/rad", k, k, k});
  }
  out.push_back({"time_constant", "tau", "s", r.time, r.time - wide, r.time + wide});
  return out;
}

}  // namespace

std::optional<SensorFault> what_is_late(const GyroDelays& delays, const vehicle::Vehicle& vehicle,
                                        const Options& o) {
  SensorFault out;
  out.share = 1;
  if (delays.as_response && delays.as_response->lead > 0) {  // nothing else leads
    const ThrustResponse& r = *delays.as_response;
    out.effect = physics::effect_id::dynamic_inflow;
    out.channel = "rotor_speed";
    out.log_factor = r.log_factor;
    out.sentence = format("thrust overshoots for %.1f +- %.1f ms after a change of speed.", 1e3 * r.time,
                          1e3 * r.time_se);
    out.parameters = inflow_of(r, vehicle, o);
    return out;
  }
  std::optional<Measured> pose, rotors;
  if (delays.behind_pose)
    pose = Measured{delays.behind_pose->lag_s, std::pow(delays.behind_pose->lag_se, 2) +
                                                   o.tolerance.pose_clock * o.tolerance.pose_clock};
  const double tolerated = o.tolerance.rotor_clock * o.tolerance.rotor_clock + kFilterOfGyro * kFilterOfGyro;
  double shape = 0;
  if (delays.as_response) {
    rotors = Measured{delays.as_response->time, std::pow(delays.as_response->time_se, 2) + tolerated};
    shape = delays.as_response->log_factor;
  } else if (delays.behind_rotors) {
    rotors = Measured{delays.behind_rotors->lag_s, std::pow(delays.behind_rotors->se_s, 2) + tolerated};
  }
  if (rotors && rotors->delay < 0) rotors.reset();  // rotors that answer to the motion come after it
  if (!pose && !rotors) return std::nullopt;
  std::array<double, kCauses.size()> likely;
  std::size_t best = 0;
  for (std::size_t k = 0; k < kCauses.size(); ++k) {
    const Cause& c = kCauses[k];
    likely[k] = -1e300;
    if (c.responds && pose && c.behind_pose && pose->delay < 0) continue;  // filters only delay
    likely[k] = log_factor_of_delay(
        {c.behind_pose && pose ? &*pose : nullptr, c.behind_rotors && rotors ? &*rotors : nullptr});
    if (c.responds) likely[k] += shape;
    if (likely[k] > likely[best]) best = k;
  }
  if (!(likely[best] > 0)) return std::nullopt;
  const Cause& cause = kCauses[best];
  out.effect = cause.effect;
  out.log_factor = likely[best];
  for (std::size_t k = 0; k < kCauses.size(); ++k)
    if (k != best && likely[k] > likely[best] - kRival) out.rivals.push_back(kCauses[k].effect);
  const Measured& from = cause.behind_pose && pose ? *pose : *rotors;
  const double error = std::sqrt(from.variance), low = from.delay - 1.96 * error,
               high = from.delay + 1.96 * error;
  if (out.effect == physics::effect_id::dynamic_inflow) {
    out.channel = "rotor_speed";
    out.sentence =
        format("thrust follows the speed of its rotor %.1f +- %.1f ms late.", 1e3 * from.delay, 1e3 * error);
    if (delays.as_response) out.parameters = inflow_of(*delays.as_response, vehicle, o);
  } else if (out.effect == physics::effect_id::sensor_filter) {
    out.channel = "gyro";
    out.sentence = format("the inertial sensor follows the motion %.1f +- %.1f ms late, behind %s.",
                          1e3 * from.delay, 1e3 * error, pose ? "the pose and the rotors" : "the rotors");
    out.parameters = {{"gyro_time", "T_g", "s", from.delay / 2, low / 2, high / 2}};
  } else {
    out.channel = "gyro";
    out.sentence = format("the clock of the board is %.1f +- %.1f ms %s on that of the pose.",
                          1e3 * std::abs(from.delay), 1e3 * error, from.delay > 0 ? "late" : "early");
    out.parameters = {{"offset", "t_d", "s", from.delay, low, high}};
  }
  return out;
}

}  // namespace omniflight::diagnosis
