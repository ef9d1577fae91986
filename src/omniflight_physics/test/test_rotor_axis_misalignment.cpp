#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

std::vector<double> angles() {
  std::vector<double> theta;
  for (int k = 0; k < 16; ++k) theta.push_back(0.02 * std::sin(1.0 + 2.3 * k));
  theta.resize(find_effect("rotor_axis_misalignment")->info().parameters.size());
  return theta;
}

TEST(RotorAxisMisalignment, IsTheHandFormulaInEveryFrame) {
  const auto theta = angles();
  for (const Situation& s : six_states()) {
    Vec6 expected = Vec6::Zero();
    for (std::size_t i = 0; i < 8; ++i) {
      const RotorSituation& r = s.rotors[i];
      const Vec3 delta = theta[2 * i] * r.tilt_axis_B + theta[2 * i + 1] * r.n_B.cross(r.tilt_axis_B);
      const Vec3 f = r.thrust * delta.cross(r.n_B);
      expected += at_hub(r, f, r.spin * r.drag_ratio * f);
    }
    EXPECT_LT((wrench_of("rotor_axis_misalignment", s, theta) - expected).norm(), 1e-12);
  }
}

TEST(RotorAxisMisalignment, IsTheExactRotationToFirstOrder) {
  // what an exact rotation does beyond it falls with the square of the angle
  const Situation s = six_states()[1];
  const auto beyond = [&](double scale) {
    auto theta = angles();
    for (double& t : theta) t *= scale;
    Vec6 exact = Vec6::Zero();
    for (std::size_t i = 0; i < 8; ++i) {
      const RotorSituation& r = s.rotors[i];
      const Vec3 delta = theta[2 * i] * r.tilt_axis_B + theta[2 * i + 1] * r.n_B.cross(r.tilt_axis_B);
      const Vec3 f = r.thrust * (exp_rotation(delta) * r.n_B - r.n_B);
      exact += at_hub(r, f, r.spin * r.drag_ratio * f);
    }
    return (exact - wrench_of("rotor_axis_misalignment", s, theta)).norm();
  };
  EXPECT_GT(beyond(1.0), 1e-6);
  EXPECT_NEAR(beyond(1.0) / beyond(0.5), 4.0, 0.05);
}

TEST(RotorAxisMisalignment, FixedRotorsLeanAboutBodyX) {
  vehicle::Vehicle v = cube();
  for (auto& r : v.rotors) r.tilts = false;
  const Situation s = situation(v, {}, 0.0, std::vector<double>(8, 700.0));
  std::vector<double> theta = neutral_of("rotor_axis_misalignment");
  theta[0] = 0.01;  // rotor 1 about +x: the thrust leans to -y
  const Vec6 w = wrench_of("rotor_axis_misalignment", s, theta);
  EXPECT_NEAR(w[1], -0.01 * s.rotors[0].thrust, 1e-12);
  EXPECT_EQ(wrench_of("rotor_axis_misalignment", s, neutral_of("rotor_axis_misalignment")).norm(), 0.0);
}

}  // namespace
}  // namespace omniflight::physics::testing
