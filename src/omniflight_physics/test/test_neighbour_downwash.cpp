#include "effect_testing.hpp"
#include "omniflight_physics/neighbour_track.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "neighbour_downwash";

TEST(NeighbourDownwash, IsTheHandFormulaInEveryFrame) {
  for (Situation s : six_states()) {
    s.neighbour_count = 2;
    s.neighbours[0].p_WN = s.body.p_WB + Vec3(0.1, -0.2, 0.8);
    s.neighbours[1].p_WN = s.body.p_WB + Vec3(-0.3, 0.1, -0.4);  // below: only its intake
    Vec6 expected = Vec6::Zero();
    for (int k = 0; k < 2; ++k)
      for (const RotorSituation& r : s.all_rotors()) {
        const Vec3 hub = s.body.p_WB + s.R_WB * r.p_BR, from = s.neighbours[static_cast<std::size_t>(k)].p_WN;
        const double z = from.z() - hub.z(), q = std::hypot(hub.x() - from.x(), hub.y() - from.y());
        const double b = 0.15 + 0.12 * std::max(z, 0.0), grown = (1 + z / std::hypot(z, 0.15)) / 2;
        const double f = 0.4 / (8 * kPi * b * b) * std::exp(-2 * q * q / (b * b)) * grown * grown;
        expected += at_hub(r, s.R_WB.transpose() * Vec3(0, 0, -f));
      }
    EXPECT_LT((wrench_of(kId, s, {0.4, 0.12, 0.15}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(NeighbourDownwash, IsNothingWithoutANeighbourAndFadesAboveAndAside) {
  Situation s = hover(1.0);
  EXPECT_EQ(wrench_of(kId, s, {0.4, 0.114, 0.2}).norm(), 0.0);
  s.neighbour_count = 1;
  const auto force = [&](const Vec3& offset) {
    s.neighbours[0].p_WN = s.body.p_WB + offset;
    return wrench_of(kId, s, {0.4, 0.114, 0.2})[2];
  };
  EXPECT_LT(force({0, 0, 1}), 0.0);
  EXPECT_GT(std::abs(force({0, 0, 1})), 20 * std::abs(force({0, 0, -1})));
  EXPECT_GT(std::abs(force({0, 0, 1})), 20 * std::abs(force({1, 0, 1})));
  // half in the wash, the vehicle is pressed down on the neighbour's side
  force({0.2, 0, 0.6});
  EXPECT_GT(wrench_of(kId, s, {0.4, 0.114, 0.2})[4], 0.0);
}

TEST(NeighbourDownwash, TheJetDecaysAsRoundJetsDo) {
  // Momentum rho pi b^2 U^2/2 of a Gaussian jet kept equal to that of a nozzle of diameter d: U/U_j =
  // d/(sqrt2 b). Measured (Pope 2000): U/U_j = B d/x with B from 5.8 to 6.3.
  const double spread = find_effect(kId)->info().parameters[1].typical;
  const double B = 1 / (std::sqrt(2.0) * spread);
  EXPECT_GT(B, 5.8);
  EXPECT_LT(B, 6.3);
  // so the force falls with the square of the distance far below
  Situation s = hover(0.0);
  s.neighbour_count = 1;
  s.neighbours[0].p_WN.z() = 40;
  const double far = wrench_of(kId, s, {0.4, spread, 0.02})[2];
  s.neighbours[0].p_WN.z() = 80;
  EXPECT_NEAR(far / wrench_of(kId, s, {0.4, spread, 0.02})[2], 4.0, 0.05);
}

TEST(NeighbourTrack, IsInterpolatedAndAbsentOutside) {
  const std::vector<NeighbourTrack> tracks{{{1.0, 2.0, 4.0}, {Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(1, 2, 1)}},
                                           {{0.0}, {Vec3(5, 5, 5)}}};
  Situation s;
  set_neighbours(tracks, 3.0, s);
  ASSERT_EQ(s.neighbour_count, 2);
  EXPECT_LT((s.neighbours[0].p_WN - Vec3(1, 1, 1)).norm(), 1e-15);
  set_neighbours(tracks, 4.0, s);
  EXPECT_LT((s.neighbours[0].p_WN - Vec3(1, 2, 1)).norm(), 1e-15);
  set_neighbours(tracks, 0.5, s);
  ASSERT_EQ(s.neighbour_count, 1);
  EXPECT_EQ(s.neighbours[0].p_WN.x(), 5.0);
}

TEST(NeighbourTrack, RefusesWhatIsNoTrack) {
  EXPECT_FALSE(validate(NeighbourTrack{}));
  EXPECT_FALSE(validate(NeighbourTrack{{0.0, 1.0}, {Vec3::Zero()}}));
  EXPECT_FALSE(validate(NeighbourTrack{{0.0, 0.0}, {Vec3::Zero(), Vec3::Zero()}}));
  EXPECT_FALSE(validate(NeighbourTrack{{0.0}, {Vec3(0, 0, std::nan(""))}}));
  EXPECT_TRUE(validate(NeighbourTrack{{0.0, 1.0}, {Vec3::Zero(), Vec3::Zero()}}));
}

}  // namespace
}  // namespace omniflight::physics::testing
