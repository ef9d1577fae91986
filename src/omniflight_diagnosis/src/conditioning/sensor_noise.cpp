#include "sensor_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>

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

/// RMS of the white noise of a component: third differences leave nothing of a smooth motion, and 20 times
/// the variance of the noise. By their median, which gaps do not move.
double white_noise(const recording::Signal& s) {
  if (s.size() < 8) return 0;
  const Eigen::Index n = s.size() - 3;
  const Eigen::MatrixXd x = s.values.bottomRows(n) - 3 * s.values.middleRows(2, n) +
                            3 * s.values.middleRows(1, n) - s.values.topRows(n);
  double square = 0;
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    std::vector<double> size(x.col(k).data(), x.col(k).data() + n);
    for (double& v : size) v = std::abs(v);
    std::nth_element(size.begin(), size.begin() + n / 2, size.end());
    square += std::pow(1.4826 * size[static_cast<std::size_t>(n / 2)], 2) / 20;
  }
  return std::sqrt(square / static_cast<double>(x.cols()));
}

Eigen::MatrixXd draw(const recording::Signal& s, double deviation) {
  Random random(kSeed, s.name);
  Eigen::MatrixXd out(s.size(), 3);
  for (Eigen::Index i = 0; i < out.rows(); ++i)
    for (Eigen::Index k = 0; k < 3; ++k) out(i, k) = deviation * random.normal();
  return out;
}

}  // namespace

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
    double density, per_component;  // of the noise, of that over white_noise()
    double ToldNoise::*deviation;
  };
  // half the angle about three axes is spread over four components of a quaternion
  static const std::array<Sensor, 4> sensors{
      {{"acc", 3, kAccelerometer, 1, &ToldNoise::accelerometer},
       {"gyro", 3, kGyro, 1, &ToldNoise::gyro},
       {"position", 3, kPosition, 1, &ToldNoise::position},
       {"attitude", 4, kAttitude, 2 * std::sqrt(4.0 / 3), &ToldNoise::attitude}}};
  ToldNoise usual;
  bool any = false;
  for (const Sensor& sensor : sensors) {
    const recording::Signal* s = recording.find(sensor.name);
    if (!s) continue;
    if (s->width() != sensor.width || !s->values.allFinite() || !(s->median_period_s() > 0)) return false;
    usual.*sensor.deviation = sensor.density / std::sqrt(s->median_period_s());
    if (sensor.per_component * white_noise(*s) > kMissing * usual.*sensor.deviation) return false;
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
