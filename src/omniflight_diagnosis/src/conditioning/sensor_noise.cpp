#include "sensor_noise.hpp"

#include <array>

#include "attitude_rows.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_diagnosis/residual.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr std::uint64_t kSeed = 1;  ///< which draw does not matter: spectra are taken of it

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
