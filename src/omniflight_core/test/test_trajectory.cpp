#include <gtest/gtest.h>

#include "omniflight_core/random.hpp"
#include "omniflight_core/trajectory.hpp"

namespace omniflight {
namespace {

std::vector<TrajectoryKnot> wild_knots() {
  Random rng(7);
  const auto v = [&](double s) { return Vec3(s * rng.normal(), s * rng.normal(), s * rng.normal()); };
  std::vector<TrajectoryKnot> knots;
  Quat q = Quat::Identity();
  for (int k = 0; k < 6; ++k) {
    TrajectoryKnot knot;
    knot.t = 0.5 * k;
    q = q * exp_rotation(v(0.4));
    knot.reference = {v(1), q, v(1), v(1), v(2), v(2), 0.5};
    knots.push_back(knot);
  }
  return knots;
}

TEST(Trajectory, PassesThroughItsKnotsWithTwoDerivatives) {
  const auto knots = wild_knots();
  const auto trajectory = Trajectory::create(knots);
  ASSERT_TRUE(trajectory);
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    for (const double side : {-1e-9, 1e-9}) {
      if (k == 0 && side < 0) continue;
      const Reference r = trajectory->sample(knots[k].t + side);
      const Reference& want = knots[k].reference;
      EXPECT_LT((r.p_WB - want.p_WB).norm(), 1e-7);
      EXPECT_LT((r.v_WB_W - want.v_WB_W).norm(), 1e-6);
      EXPECT_LT((r.a_WB_W - want.a_WB_W).norm(), 1e-5);
      EXPECT_LT(r.q_WB.angularDistance(want.q_WB), 1e-7);
      EXPECT_LT((r.w_WB_B - want.w_WB_B).norm(), 1e-6);
      EXPECT_LT((r.dw_WB_B - want.dw_WB_B).norm(), 1e-5);
    }
  }
}

TEST(Trajectory, DerivativesAreThoseOfTheCurve) {
  const auto trajectory = Trajectory::create(wild_knots());
  ASSERT_TRUE(trajectory);
  const double e = 1e-5;
  for (double t = 0.05; t < 2.4; t += 0.11) {
    const Reference a = trajectory->sample(t - e), b = trajectory->sample(t + e), r = trajectory->sample(t);
    EXPECT_LT(((b.p_WB - a.p_WB) / (2 * e) - r.v_WB_W).norm(), 1e-6);
    EXPECT_LT(((b.v_WB_W - a.v_WB_W) / (2 * e) - r.a_WB_W).norm(), 1e-5);
    EXPECT_LT((log_rotation(a.q_WB.conjugate() * b.q_WB) / (2 * e) - r.w_WB_B).norm(), 1e-5);
    EXPECT_LT(((b.w_WB_B - a.w_WB_B) / (2 * e) - r.dw_WB_B).norm(), 1e-4);
  }
}

TEST(Trajectory, RefusesWhatCannotBeFlown) {
  auto knots = wild_knots();
  knots[2].reference.p_WB.x() = std::nan("");
  EXPECT_FALSE(Trajectory::create(knots));
  knots = wild_knots();
  knots[3].t = knots[2].t;
  const auto repeated = Trajectory::create(knots);
  ASSERT_FALSE(repeated);
  EXPECT_NE(repeated.error().text().find("time does not increase"), std::string::npos);
  EXPECT_FALSE(Trajectory::create({}));
}

}  // namespace
}  // namespace omniflight
