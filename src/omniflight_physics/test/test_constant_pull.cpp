#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "constant_pull";

TEST(ConstantPull, IsTheSameInTheWorldInEveryFrame) {
  for (const Situation& s : six_states()) {
    const Vec6 w = wrench_of(kId, s, {0.3, -0.5, -1.7});
    EXPECT_LT((s.R_WB * w.head<3>() - Vec3(0.3, -0.5, -1.7)).norm(), 1e-12);
    EXPECT_EQ(w.tail<3>().norm(), 0.0);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
  // rolled to the left, what pulls down pulls along -y of the body
  RigidState rolled;
  rolled.q_WB = exp_rotation(Vec3(kPi / 2, 0, 0));
  const Situation s = situation(cube(), rolled, 0, std::vector<double>(8, 700.0));
  EXPECT_NEAR(wrench_of(kId, s, {0, 0, -2})[1], -2.0, 1e-12);
}

TEST(ConstantPull, HasNoInertia) {
  for (Situation s : six_states()) {
    const Vec6 moving = wrench_of(kId, s, {0.3, -0.5, -1.7});
    s.a_WB_B.setZero();
    s.dw_WB_B.setZero();
    EXPECT_EQ(wrench_of(kId, s, {0.3, -0.5, -1.7}), moving);
    Wrench w;
    const double theta[] = {0.3, -0.5, -1.7};
    find_effect(kId)->add_wrench(s, theta, w);
    EXPECT_FALSE(w.moves_mass());
  }
}

}  // namespace
}  // namespace omniflight::physics::testing
