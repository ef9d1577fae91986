#include "sensor_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "../numerics/statistics.hpp"
#include "attitude_rows.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_diagnosis/residual.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr std::uint64_t kSeed = 1;  ///< which draw does not matter: spectra are taken of it

/// Densities of the noise of good sensors: MEMS accelerometer and gyroscope on a vehicle whose rotors turn
/// [m/s^2/rtHz, rad/s/rtHz], motion capture [m/rtHz, rad/rtHz].
constexpr double kAccelerometer = 2.5e-3, kGyro = 1.3e-4, kPosition = 1.3e-5, kAttitude = 5e-5;
constexpr double kMissing = 0.1;  ///< of these: what has less has none

Eigen::MatrixXd draw(const recording::Signal& s, double deviation) {
  Random random(kSeed, s.name);
  Eigen::MatrixXd out(s.size(), 3);
  for (Eigen::Index i = 0; i < out.rows(); ++i)
    for (Eigen::Index k = 0; k < 3; ++k) out(i, k) = deviation * random.normal();
  return out;
}

}  // namespace

double white_noise(const recording::Signal& s, Eigen::Index from, Eigen::Index to) {
  constexpr double kGaussian = 0.6745;  // median of |x| of a standard normal
  const double period = s.median_period_s();
  double most = 0;
  for (Eigen::Index c = 0; c < s.width(); ++c) {
    std::vector<double> third;
    for (Eigen::Index i = from + 3; i < to; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (s.t_s[k] - s.t_s[k - 3] > 4 * period) continue;
      third.push_back(
          std::abs(s.values(i, c) - 3 * s.values(i - 1, c) + 3 * s.values(i - 2, c) - s.values(i - 3, c)));
    }
    most = std::max(most, median(third) / kGaussian / std::sqrt(20.0));
  }
  return most;
}

bool noise_is_told(const Flight& f, const ToldNoise& noise) {
  const bool estimated = f.has("velocity") || f.has("est_velocity") || !f.has("position");
  const bool force = f.has_accelerometer ? noise.accelerometer > 0 : !estimated && noise.position > 0;
  const bool torque = f.has_gyro ? noise.gyro > 0 : f.has("attitude") && noise.attitude > 0;
  return noise.of_turbulence() && force && torque;
}

void add_noise(const ToldNoise& noise, recording::Recording& recording) {
  const std::array<std::pair<const char*, double>, 3> straight{
      std::pair{"acc", noise.accelerometer}, {"gyro", noise.gyro}, {"position", noise.position}};
  for (const auto& [name, deviation] : straight)
    if (const auto at = recording.signals.find(name); at != recording.signals.end())
      at->second.values += draw(at->second, deviation);
  const auto at = recording.signals.find("attitude");
  if (at == recording.signals.end()) return;
  const Eigen::MatrixXd turned = draw(at->second, noise.attitude);
  for (Eigen::Index i = 0; i < turned.rows(); ++i) {
    const Quat q = quaternion(at->second.values, i) * exp_rotation(Vec3(turned.row(i)));
    at->second.values.row(i) << q.w(), q.x(), q.y(), q.z();
  }
}

bool add_missing_noise(recording::Recording& recording) {
  struct Sensor {
    const char* name;
    Eigen::Index width;
    double density, over_component;  // of the noise, of that over a component's
    double ToldNoise::*deviation;
  };
  // a component of a quaternion has half of the angle
  static const std::array<Sensor, 4> sensors{{{"acc", 3, kAccelerometer, 1, &ToldNoise::accelerometer},
                                              {"gyro", 3, kGyro, 1, &ToldNoise::gyro},
                                              {"position", 3, kPosition, 1, &ToldNoise::position},
                                              {"attitude", 4, kAttitude, 2, &ToldNoise::attitude}}};
  ToldNoise usual;
  bool any = false;
  for (const Sensor& sensor : sensors) {
    const recording::Signal* s = recording.find(sensor.name);
    if (!s) continue;
    if (s->width() != sensor.width || !s->values.allFinite() || !(s->median_period_s() > 0)) return false;
    usual.*sensor.deviation = sensor.density / std::sqrt(s->median_period_s());
    if (sensor.over_component * white_noise(*s, 0, s->size()) > kMissing * usual.*sensor.deviation)
      return false;
    any = true;
  }
  if (any) add_noise(usual, recording);
  return any;
}

Eigen::MatrixXd residual_between(const Flight& flight, const Flight& noisier, const Vec3& center_of_mass) {
  const auto residual = [&](const physics::Situation& x) {
    return wrench_residual(x, x.a_WB_B - x.g_B, center_of_mass);
  };
  Eigen::MatrixXd out(flight.size(), 6);
  for (std::size_t i = 0; i < flight.situation.size(); ++i)
    out.row(static_cast<Eigen::Index>(i)) =
        (residual(noisier.situation[i]) - residual(flight.situation[i])).transpose();
  return out;
}

}  // namespace omniflight::diagnosis
