#include "case_make.hpp"

#include <fmt/format.h>

#include <cmath>

#include "omniflight_recording/formats.hpp"
#include "seal.hpp"

namespace omniflight::proof {
namespace {

SensorConfig laboratory() {
  SensorConfig c;
  c.imu_rate = 250;
  c.accelerometer_noise = 0.08;
  c.gyro_noise = 0.004;
  c.mocap_rate = 125;
  c.mocap_position_noise = 0.0002;
  c.mocap_attitude_noise = 0.0008;
  c.mocap_latency = 0.008;
  c.mocap_dropout = 0.002;
  c.rotor_rate = 125;
  c.half_period_quantisation = true;
  c.battery_rate = 10;
  return c;
}

/// How well the operator has weighed, balanced and levelled the vehicle: one standard deviation each, of the
/// weight, and of the weight times the longest arm. The worlds differ from the vehicle file by as much.
constexpr double kScaleKnown = 0.0005, kLevelKnown = 0.0002, kTrimKnown = 0.0003;
constexpr double kBiasKnown = 0.005;  ///< m/s^2, after a calibration at rest
constexpr double kGyroBiasKnown =
    0.0003;  ///< rad/s, zeroed at rest before the flight; it warms up on the way

/// What no calibration gets rid of, in every world, also in those where nothing was left out.
void calibrate(FlightSetup& s, const vehicle::Vehicle& vehicle, Random random) {
  double arm = 0;
  for (const vehicle::Rotor& r : vehicle.rotors) arm = std::max(arm, r.p_BR.norm());
  s.world.body.payload = vehicle.mass * kScaleKnown * std::abs(random.normal());
  for (int k = 0; k < 3; ++k) {
    s.world.body.com_shift_B[k] = arm * kTrimKnown * random.normal();
    s.sensors.accelerometer_bias[k] = kBiasKnown * random.normal();
    s.sensors.gyro_bias[k] = kGyroBiasKnown * random.normal();
  }
}

/// What an operator may know before a flight: gains, and what this laboratory usually has of noise and
/// turbulence. A decoy's are others, which nobody wrote down: the file must not tell what kind of case it is.
/// Every number has the same width.
std::string told_yaml(const control::ControllerConfig& gains) {
  const auto number = [](double x) { return fmt::format("{:<12.6f}", x); };
  const auto gain = [&](const Vec3& v) {
    return "[" + number(v.x()) + ", " + number(v.y()) + ", " + number(v.z()) + "]";
  };
  const SensorConfig c = laboratory();
  return "rates_hz: {imu: 250, mocap: 125, rotor_speed: 125}\nsensors:\n  accelerometer: {noise_rms_mps2: " +
         number(c.accelerometer_noise) + ", bias_mps2: " + number(kBiasKnown) +
         "}\n  gyro: {noise_rms_radps: " + number(c.gyro_noise) + ", bias_radps: " + number(kGyroBiasKnown) +
         "}\n  mocap: {position_noise_m: " + number(c.mocap_position_noise) +
         ", attitude_noise_rad: " + number(c.mocap_attitude_noise) +
         "}\n  rotor_speed: {method: half_period, tick_us: 1}\nambient: {turbulence_force_rms_N: " +
         number(kForceNoise) + ", turbulence_torque_rms_Nm: " + number(kTorqueNoise) +
         ", correlation_time_s: " + number(kNoiseTime) + "}\ncontroller:\n  kp: " + gain(gains.kp) +
         "\n  kv: " + gain(gains.kv) + "\n  ki: " + gain(gains.ki) + "\n  kR: " + gain(gains.kR) +
         "\n  kw: " + gain(gains.kw) + "\n  kI: " + gain(gains.kI) +
         "\ntolerance: {thrust_scale: " + number(kScaleKnown) + ", world_force: " + number(kLevelKnown) +
         ", torque_trim: " + number(kTrimKnown) + "}\nenvironment: {floor_z_m: 0, air_density_kgpm3: 1.2}\n";
}

/// Gains differ from case to case, so that a retuned controller is nothing special.
void vary_gains(FlightSetup& s, Random& random) {
  s.flown = usual_gains();
  const double position = random.uniform(0.85, 1.2), attitude = random.uniform(0.85, 1.2);
  s.flown.kp *= position;
  s.flown.kv *= std::sqrt(position);
  s.flown.ki *= random.uniform(0.7, 1.3);
  s.flown.kR *= attitude;
  s.flown.kw *= std::sqrt(attitude);
  s.told = s.flown;
}

std::vector<std::string> add_nuisances(FlightSetup& s, Random& random) {
  auto& c = s.world.sensors;
  c.noise_correlation_time = random.uniform(0.004, 0.03);
  c.mocap_extra_latency = 0.002 * std::round(random.uniform(1, 6));
  c.board_clock_skew = random.uniform(-60e-6, 60e-6);
  c.board_clock_offset = random.uniform(0, 0.006);
  c.rotor_dropout = random.uniform(0, 0.01);
  c.imu_dropout = random.uniform(0, 0.01);
  const double at = random.uniform(15, 45);
  c.faults.push_back({.sensor = SensorFault::Sensor::mocap,
                      .from = at,
                      .until = at + random.uniform(0.15, 0.4),
                      .silent = true});
  s.world.turbulence->correlation_time = random.uniform(0.2, 0.8);
  return {"clock_offset", "stale_samples", "sensor_filter", "gust"};
}

void add_decoy(FlightSetup& s, const std::string& decoy) {
  if (decoy == kRetuned) {
    s.flown.kp *= 0.6;
    s.flown.kv *= 0.8;
    s.flown.ki *= 0.5;
    s.flown.kR *= 0.6;
    s.told = s.flown;
  } else if (decoy == "noisy sensors") {
    s.sensors.accelerometer_noise *= 3;
    s.sensors.gyro_noise *= 3;
    s.sensors.mocap_position_noise *= 3;
    s.sensors.mocap_attitude_noise *= 2;
  } else if (decoy == "slow turbulence") {
    s.world.turbulence->correlation_time = 2;
  } else if (decoy == "strong turbulence") {
    s.world.turbulence->force_rms *= 2;
    s.world.turbulence->torque_rms *= 2;
  }
}

double measured(const Mechanism& m, const Flown& f) {
  switch (m.measure) {
    case Mechanism::Measure::wrench:
      return in_sigma(f.wrench);
    case Mechanism::Measure::command:
      return in_sigma(f.command);
    case Mechanism::Measure::control:
      return in_sigma(f.control);
    case Mechanism::Measure::formula:
      break;
  }
  return 0;
}

struct Tuned {
  double amplitude = 0, sigma = 0;
};

/// Turns the amplitude until the effect alone, without turbulence, has the wanted size.
Result<Tuned> tune(const vehicle::Vehicle& vehicle, const Mechanism& m, const Shape& shape,
                   const FlightSetup& plain, double target) {
  FlightSetup quiet = plain;
  quiet.record = false;
  quiet.world.turbulence.reset();
  if (m.articulated) quiet.path.duration = 21;
  double a = m.typical;
  if (m.measure == Mechanism::Measure::formula) {
    auto nominal = fly(vehicle, quiet);
    if (!nominal) return Failure(nominal.error());
    for (int k = 0; k < 20; ++k)
      a = std::clamp(a * target / std::max(1e-12, m.size(a, shape, *nominal)), m.smallest, m.largest);
    return Tuned{a, m.size(a, shape, *nominal)};
  }
  Tuned best;
  std::string why;
  double miss = 1e300;
  for (int round = 0; round < 5; ++round) {
    FlightSetup trial = quiet;
    m.apply(trial, a, shape);
    auto flown = fly(vehicle, trial);
    if (!flown) {
      why = flown.error().text();
      a *= 0.4;
      continue;
    }
    const double sigma = measured(m, *flown), off = std::abs(std::log(std::max(1e-9, sigma / target)));
    if (off < miss) {
      miss = off;
      best = {a, sigma};
    }
    if (off < 0.07) break;
    const double next =
        std::clamp(a * std::clamp(target / std::max(1e-9, sigma), 0.02, 30.0), m.smallest, m.largest);
    if (next == a) break;
    a = next;
  }
  if (best.amplitude == 0)
    return fail(ErrorCode::incomplete, "no size of it can be flown: " + why, m.realisation);
  return best;
}

std::string rms_text(double x) { return fmt::format("{:.2g}", x); }

/// next: fly this path in the world of the case instead of its own, and nothing else. vigour: of a designed
/// flight; a vehicle that is lost flies more calmly.
Result<MadeCase> make(const vehicle::Vehicle& vehicle, const std::vector<Mechanism>& mechanisms,
                      const CasePlan& plan, const std::string& salt, bool sealed, const Path* next,
                      double vigour = 1) {
  Random random = draw(salt, plan.id);
  FlightSetup s;
  s.sensors = laboratory();
  s.world.turbulence =
      Turbulence{.force_rms = kForceNoise, .torque_rms = kTorqueNoise, .correlation_time = kNoiseTime};
  s.seed = random.next() >> 12;
  Random phases = draw(salt, plan.id + " path");
  s.path = plan.flight == "T1"   ? path_t1()
           : plan.flight == "T2" ? path_t2()
                                 : path_designed(phases, vigour * (plan.decoy == "quick flight" ? 1.4 : 1.0));
  vary_gains(s, random);
  MadeCase out;
  Truth& t = out.truth;
  t.id = plan.id;
  t.level = plan.level;
  t.kind = plan.kind;
  t.flight = plan.flight;
  t.decoy = plan.decoy;
  t.seed = s.seed;
  t.magnitude = plan.magnitude;
  if (plan.nuisances) t.present = add_nuisances(s, random);
  add_decoy(s, plan.decoy);
  const FlightSetup plain = s;
  calibrate(s, vehicle, draw(salt, plan.id + " calibration"));
  double smallest = 1e300;
  for (const std::size_t k : plan.parts) {
    const Mechanism& m = mechanisms[k];
    Random own = draw(salt, plan.id + " shape " + std::to_string(k));
    const Shape shape = draw_shape(own, sealed);
    FlightSetup nominal = plain;
    nominal.world.sensors = {};
    auto tuned = tune(vehicle, m, shape, nominal, plan.magnitude);
    if (!tuned) return Failure(tuned.error());
    m.apply(s, tuned->amplitude, shape);
    for (const std::string& id : m.along) t.present.push_back(id);
    smallest = std::min(smallest, tuned->sigma);
    t.effects.push_back({m.id, m.stage, m.realisation + ", amplitude " + rms_text(tuned->amplitude),
                         tuned->sigma, m.parameters(tuned->amplitude, shape), m.variables});
  }
  if (next) {
    s.path = *next;
    s.seed = draw(salt, plan.id + " next").next() >> 12;
  }
  // an effect that cannot be made so large counts as what it is
  if (!plan.parts.empty() && smallest < 0.8 * plan.magnitude) t.magnitude = smallest;
  auto flown = fly(vehicle, s);
  if (!flown && !next && plan.flight == "designed" && vigour > 0.3)
    return make(vehicle, mechanisms, plan, salt, sealed, nullptr, 0.7 * vigour);
  if (!flown) return Failure(flown.error());
  const Turbulence& noise = *s.world.turbulence;
  for (std::size_t c = 0; c < 6; ++c) t.noise[c] = c < 3 ? noise.force_rms : noise.torque_rms;
  if (!plan.parts.empty() && !next) {
    FlightSetup quiet = s;
    quiet.record = false;
    quiet.world.turbulence.reset();
    if (quiet.world.articulated()) {  // slow to fly: take the noise off by its energy instead
      const auto without = [&](double rms, std::size_t c) {
        return std::sqrt(std::max(0.0, rms * rms - t.noise[c] * t.noise[c]));
      };
      for (std::size_t c = 0; c < 6; ++c) {
        t.wrench[c] = without(flown->wrench[c], c);
        t.wrench_variance[c] = std::max(0.0, flown->variance[c] - t.noise[c] * t.noise[c]);
      }
    } else {
      auto alone = fly(vehicle, quiet);
      if (!alone) return Failure(alone.error());
      t.wrench = alone->wrench;
      t.wrench_variance = alone->variance;
    }
  }
  Random padding = draw(salt, plan.id + (next ? " next padding" : " padding"));
  auto gz = gzip_of_size(recording::to_csv(flown->recording), (next ? 2 : 1) * kRecordingBytes, padding);
  if (!gz) return Failure(gz.error());
  out.recording = std::move(*gz);
  out.told = told_yaml(s.told);
  if (next) out.truth = {};
  return out;
}

}  // namespace

Result<MadeCase> make_case(const vehicle::Vehicle& vehicle, const std::vector<Mechanism>& mechanisms,
                           const CasePlan& plan, const std::string& salt, bool sealed) {
  return make(vehicle, mechanisms, plan, salt, sealed, nullptr);
}

Result<MadeCase> fly_again(const vehicle::Vehicle& vehicle, const std::vector<Mechanism>& mechanisms,
                           const CasePlan& plan, const std::string& salt, bool sealed, const Path& path) {
  return make(vehicle, mechanisms, plan, salt, sealed, &path);
}

}  // namespace omniflight::proof
