#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "lateral_stiffness";
const std::vector<double> kTheta{3.0, 0.4, -0.7};

TEST(LateralStiffness, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    const Vec3 f(-3.0 * (s.body.p_WB.x() - 0.4), -3.0 * (s.body.p_WB.y() + 0.7), 0);
    Vec6 expected;
    expected << s.R_WB.transpose() * f, Vec3::Zero();
    EXPECT_LT((wrench_of(kId, s, kTheta) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(LateralStiffness, PullsBackToTheAnchorAndNeverUp) {
  Situation s = hover(1.0);
  s.body.p_WB = Vec3(0.4, -0.7, 2.5);
  EXPECT_EQ(wrench_of(kId, s, kTheta).norm(), 0.0) << "straight above its anchor";
  s.body.p_WB.x() += 0.2;
  EXPECT_NEAR(wrench_of(kId, s, kTheta)[0], -0.6, 1e-12);
}

TEST(LateralStiffness, WorksNothingAroundAClosedPath) {
  // Along a straight way a linear force works its mean times the way, whatever the attitude does.
  const std::vector<Situation> corners = six_states();
  double around = 0, largest = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Situation &from = corners[i], &to = corners[(i + 1) % corners.size()];
    const auto force_W = [&](const Situation& s) -> Vec3 {
      return s.R_WB * wrench_of(kId, s, kTheta).head<3>();
    };
    const auto stored = [](const Situation& s) {
      return 1.5 * (std::pow(s.body.p_WB.x() - 0.4, 2) + std::pow(s.body.p_WB.y() + 0.7, 2));
    };
    const double work = 0.5 * (force_W(from) + force_W(to)).dot(to.body.p_WB - from.body.p_WB);
    EXPECT_NEAR(work, stored(from) - stored(to), 1e-12);
    around += work;
    largest = std::max(largest, std::abs(work));
  }
  EXPECT_GT(largest, 0.1);
  EXPECT_NEAR(around, 0.0, 1e-12);
}

}  // namespace
}  // namespace omniflight::physics::testing
