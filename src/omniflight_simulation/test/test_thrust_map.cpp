// The wrench of the rotors by the map is that of the effects' own laws, at any tilt.
#include "omniflight_simulation/thrust_map.hpp"

#include <gtest/gtest.h>

#include "flying.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::simulation {
namespace {

/// The same by the laws themselves, for rotor speeds [rad/s] at a tilt.
Vec6 by_law(const vehicle::Vehicle& v, const physics::Model& m, std::span<const double> speed, double alpha) {
  physics::Situation s;
  physics::prepare(v, {}, alpha, speed, {}, {}, s);
  physics::Wrench sum;
  for (const auto& e : m.effects) e.effect->add_wrench(s, e.theta.data(), sum);
  return physics::rotor_wrench(s) + sum.at(s);
}

TEST(ThrustMap, IsTheLawOfEveryEffectThatIsLinearInTheThrusts) {
  const auto v = omnimorph();
  Random random(4);
  std::vector<physics::Model> models(1);
  physics::Model all;
  for (const physics::Effect* e : physics::builtin_effects()) {
    if (!e->linear_in_thrust()) continue;
    physics::ActiveEffect active{e, {}};
    for (const auto& p : e->info().parameters)
      active.theta.push_back(std::clamp(p.typical * random.uniform(0.5, 1.5), p.lower, p.upper));
    models.push_back({{active}, ""});
    all.effects.push_back(active);
  }
  ASSERT_GE(models.size(), 8u);
  models.push_back(all);
  for (const auto& m : models) {
    const ThrustMap map(v, m.effects);
    for (const double alpha : {-0.4, 0.0, 0.3, 1.1}) {
      Eigen::Matrix<double, vehicle::kMaxRotors, 1> square = decltype(square)::Zero();
      std::vector<double> speed;
      for (int i = 0; i < v.rotor_count(); ++i) {
        speed.push_back(random.uniform(-900, 900));
        square[i] = speed.back() * std::abs(speed.back());
      }
      const Vec6 law = by_law(v, m, speed, alpha);
      EXPECT_LT((map.at(alpha) * square - law).norm(), 1e-12 * std::max(1.0, law.norm()))
          << m.effects.size() << " effects at " << alpha;
    }
  }
}

}  // namespace
}  // namespace omniflight::simulation
