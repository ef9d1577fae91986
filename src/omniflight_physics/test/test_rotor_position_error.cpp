#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

TEST(RotorPositionError, IsWhatTheVehicleDoesWithItsRotorsMoved) {
  std::vector<double> theta;
  for (int k = 0; k < 24; ++k) theta.push_back(0.004 * std::cos(0.7 + 1.9 * k));
  vehicle::Vehicle moved = cube();
  for (std::size_t i = 0; i < 8; ++i)
    moved.rotors[i].p_BR += Vec3(theta[3 * i], theta[3 * i + 1], theta[3 * i + 2]);
  for (const Situation& s : six_states()) {
    std::vector<double> speed;
    for (const RotorSituation& r : s.all_rotors()) speed.push_back(r.speed);
    const Vec6 expected = rotor_wrench(situation(moved, s.body, s.alpha, speed)) - rotor_wrench(s);
    EXPECT_GT(expected.norm(), 1e-3);
    EXPECT_LT((wrench_of("rotor_position_error", s, theta) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of("rotor_position_error", s, neutral_of("rotor_position_error")).norm(), 0.0);
  }
}

TEST(RotorPositionError, TheSameShiftOfAllRotorsIsALeverOfTheWholeThrust) {
  const Situation s = six_states()[2];
  std::vector<double> theta(24, 0.0);
  for (std::size_t i = 0; i < 8; ++i) theta[3 * i] = 0.01;
  const Vec3 thrust = rotor_wrench(s).head<3>();
  const Vec6 w = wrench_of("rotor_position_error", s, theta);
  EXPECT_LT((w.tail<3>() - Vec3(0.01, 0, 0).cross(thrust)).norm(), 1e-12);
  EXPECT_EQ(w.head<3>().norm(), 0.0);
}

}  // namespace
}  // namespace omniflight::physics::testing
