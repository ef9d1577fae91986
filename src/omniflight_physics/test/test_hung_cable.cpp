#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "hung_cable";
constexpr double kLambda = 0.25, kStart = 0.4, kLength = 1.1;  // kg/m, m, m
const std::vector<double> kTheta{kLambda, kStart, kLength};

double carried(double h) { return std::clamp(h - kStart, 0.0, kLength); }

/// The six states below the cable's start, along it and above its end, climbing and sinking.
std::vector<Situation> along_the_cable() {
  std::vector<Situation> out;
  for (const double height : {0.2, 0.9, 1.3, 2.5})
    for (const double climb : {-0.8, 0.0, 1.7})
      for (Situation s : six_states()) {
        s.body.p_WB.z() = height;
        s.body.v_WB_W.z() = climb;
        s.v_WB_B = s.R_WB.transpose() * s.body.v_WB_W;
        out.push_back(s);
      }
  return out;
}

TEST(HungCable, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : along_the_cable()) {
    const double h = s.body.p_WB.z(), v = s.body.v_WB_W.z(), a = (s.R_WB * s.a_WB_B).z();
    const bool lifting = h > kStart && h < kStart + kLength && v > 0;
    const double pull = kLambda * carried(h) * (kGravity + a) + (lifting ? kLambda * v * v : 0.0);
    Vec6 expected;
    expected << s.R_WB.transpose() * Vec3(0, 0, -pull), Vec3::Zero();
    EXPECT_LT((wrench_of(kId, s, kTheta) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

/// Links come off the floor, and come to rest on it, without a rebound: half lambda |v|^3 is lost either way.
TEST(HungCable, LosesWhatInelasticLiftingAndLayingDownLose) {
  int moved = 0;
  for (const Situation& s : along_the_cable()) {
    const double h = s.body.p_WB.z(), v = s.body.v_WB_W.z(), a = (s.R_WB * s.a_WB_B).z(), dt = 1e-5;
    const auto energy = [&](double t) {
      const double hanging = carried(h + v * t + a * t * t / 2), speed = v + a * t;
      return 0.5 * kLambda * hanging * speed * speed + 0.5 * kLambda * kGravity * hanging * hanging;
    };
    // of a cable wholly in the air the weight's arm grows no more, only its height
    const bool whole = h > kStart + kLength, on_floor = h < kStart;
    const double lifted_whole = whole ? kLambda * kGravity * kLength * v : 0.0;
    const double gained = (energy(dt) - energy(-dt)) / (2 * dt) + lifted_whole;
    const double given = -power(s, wrench_of(kId, s, kTheta));
    const double lost = whole || on_floor ? 0.0 : 0.5 * kLambda * std::abs(v * v * v);
    EXPECT_NEAR(given - gained, lost, 1e-7);
    moved += lost > 0;
  }
  EXPECT_GT(moved, 10);
}

TEST(HungCable, ShowsByKinksWithinTheHeightsFlown) {
  const Effect& cable = *find_effect(kId);
  EXPECT_TRUE(cable.telling_shapes({}).empty());
  std::vector<Situation> climb(11, six_states().front());
  for (std::size_t k = 0; k < climb.size(); ++k) climb[k].body.p_WB.z() = 1 + 0.1 * static_cast<double>(k);
  bool lifts_all = false, comes_off = false, hangs_free = false;
  for (const std::vector<double>& theta : cable.telling_shapes(climb)) {
    ASSERT_EQ(theta.size(), 3U);
    EXPECT_EQ(theta[0], 0);
    EXPECT_LT(theta[1], 2);
    const double end = theta[1] + theta[2];
    EXPECT_GT(end, 1);
    lifts_all = lifts_all || (theta[1] < 1 && end > 2);
    comes_off = comes_off || (theta[1] > 1 && end > 2);
    hangs_free = hangs_free || (theta[1] < 1 && end < 2);
  }
  EXPECT_TRUE(lifts_all && comes_off && hangs_free);
}

}  // namespace
}  // namespace omniflight::physics::testing
