#include "omniflight_simulation/thrust_map.hpp"

#include <array>

namespace omniflight::simulation {

ThrustMap::ThrustMap(const vehicle::Vehicle& vehicle, std::span<const physics::ActiveEffect> effects) {
  for (Columns* c : {part_, sloped_}) c[0] = c[1] = c[2] = Columns::Zero();
  constexpr double third = 2 * kPi / 3;
  physics::Situation s;
  for (Eigen::Index i = 0; i < vehicle.rotor_count(); ++i) {
    std::array<double, vehicle::kMaxRotors> speed{};
    const vehicle::Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
    speed[static_cast<std::size_t>(i)] = rotor.speed(1.0);
    Vec6 at[3], slope[3];
    for (int n = 0; n < 3; ++n) {  // from three tilts follows every other
      physics::prepare(vehicle, {}, n * third, {speed.data(), vehicle.rotors.size()}, {}, {}, s);
      physics::Wrench level, raised;
      for (const physics::ActiveEffect& e : effects) {
        if (!e.effect->linear_in_thrust()) continue;
        s.alpha = 0;
        e.effect->add_wrench(s, e.theta.data(), level);
        s.alpha = 1;
        e.effect->add_wrench(s, e.theta.data(), raised);
      }
      at[n] = physics::rotor_wrench(s) + level.at(s);
      slope[n] = raised.at(s) - level.at(s);
    }
    const auto put = [&](const Vec6* f, Columns* out) {
      const double c = rotor.thrust_coefficient;
      out[0].col(i) = c * (f[0] + f[1] + f[2]) / 3;
      out[1].col(i) = c * (2 * f[0] - f[1] - f[2]) / 3;
      out[2].col(i) = c * (f[1] - f[2]) / std::sqrt(3.0);
    };
    put(at, part_);
    put(slope, sloped_);
    slopes_ = slopes_ || !(slope[0].isZero(0.0) && slope[1].isZero(0.0) && slope[2].isZero(0.0));
  }
}

ThrustMap::Columns ThrustMap::at(double alpha) const {
  const double c = std::cos(alpha), s = std::sin(alpha);
  Columns out = part_[0] + c * part_[1] + s * part_[2];
  if (slopes_) out += alpha * (sloped_[0] + c * sloped_[1] + s * sloped_[2]);
  return out;
}

}  // namespace omniflight::simulation
