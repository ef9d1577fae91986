// Flights side by side are the flights alone, and a known load sags by what PD control lets it.
#include <gtest/gtest.h>

#include "hovering.hpp"
#include "omniflight_campaign/vary.hpp"

namespace omniflight::campaign {
namespace {

TEST(ManyFlights, ALoadSagsByItsWeightOverTheStiffness) {
  const Loop loop = hovering();
  OneFlight f = one(loop, {{"payload_mass", {0.1}}});
  f.law.gains.ki
      .setZero();  // PD: e = g (m_load / m) / kp, as the law asks for accelerations of the nominal mass
  const auto out = fly_many(loop, std::vector{f});
  ASSERT_TRUE(out) << out.error().text();
  const double sag = kGravity * 0.1 / loop.vehicle.mass / f.law.gains.kp.z();
  EXPECT_NEAR(out->front().worst_position, sag, 0.05 * sag);
  EXPECT_NEAR(out->front().end_error, sag, 0.01 * sag);
  const double share = 1 + 0.1 / loop.vehicle.mass;
  const auto nominal = fly_many(loop, std::vector{one(loop)});
  // power of hovering rises with the weight to 3/2
  EXPECT_NEAR(out->front().mean_power / nominal->front().mean_power, std::pow(share, 1.5), 0.01);
  EXPECT_LT(nominal->front().worst_position, 1e-6);
}

TEST(ManyFlights, AreTheFlightsAlone) {
  const Loop loop = hovering(2);
  std::vector<OneFlight> flights;
  for (int k = 0; k < 40; ++k)
    flights.push_back(one(loop, {{"payload_mass", {0.005 * k}}, {"wind", {0.1 * k, 0, 0.02}}}));
  flights.push_back(one(loop, {{"battery_sag", {}}}));  // flies as a plant beside the lanes
  for (const auto& p : flights.back().model.effects[0].effect->info().parameters)
    flights.back().model.effects[0].theta.push_back(p.typical);
  const auto together = fly_many(loop, flights);
  ASSERT_TRUE(together) << together.error().text();
  for (const std::size_t k : {0u, 7u, 33u, 40u}) {
    const auto alone = fly_many(loop, std::span(flights).subspan(k, 1));
    ASSERT_TRUE(alone);
    EXPECT_EQ(alone->front().position_rmse, (*together)[k].position_rmse) << k;
    EXPECT_EQ(alone->front().mean_power, (*together)[k].mean_power) << k;
    EXPECT_EQ(alone->front().worst_position_at, (*together)[k].worst_position_at) << k;
  }
  EXPECT_NE((*together)[0].mean_power, (*together)[7].mean_power);
}

TEST(ManyFlights, AreWatchedFromTheBeginOfThePlanOn) {
  Loop loop = hovering(2);
  std::vector<OneFlight> flights;
  for (int k = 0; k < 40; ++k) flights.push_back(one(loop, {{"payload_mass", {0.005 * k}}}));
  std::vector<double> lowest(flights.size(), 1e9);
  std::vector<int> looks(flights.size(), 0);
  double first = 1e9;
  loop.watch = [&](const FlightMoment& m) {
    first = std::min(first, m.along);
    ++looks[m.flight];
    lowest[m.flight] = std::min(lowest[m.flight], m.state.p_WB.z());
    EXPECT_EQ(m.u.size(), loop.vehicle.rotor_count());
  };
  const auto out = fly_many(loop, flights);
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_GE(first, 0.0);
  EXPECT_LT(first, kLookEvery * loop.control_period);
  for (std::size_t k = 0; k < flights.size(); ++k) {
    EXPECT_EQ(looks[k], looks[0]) << k;
    EXPECT_GT(looks[k], 50) << k;
    if (k > 0) {
      EXPECT_LT(lowest[k], lowest[k - 1]) << k;  // the heavier sags further
    }
  }
}

TEST(ManyFlights, ALostOneEndsAndTheOthersFlyOn) {
  const Loop loop = hovering(2);
  const auto out = fly_many(
      loop,
      std::vector{one(loop), one(loop, {{"thrust_scale", {-0.7}}, {"payload_mass", {0.5}}}), one(loop)});
  ASSERT_TRUE(out) << out.error().text();
  ASSERT_TRUE((*out)[1].ended_early);
  EXPECT_GT(*(*out)[1].ended_early, loop.hold);
  EXPECT_FALSE((*out)[0].ended_early || (*out)[2].ended_early);
  EXPECT_EQ((*out)[0].mean_power, (*out)[2].mean_power);
}

TEST(ManyFlights, StopWhenTheyAreAsked) {
  const Loop loop = hovering();
  const auto out = fly_many(loop, std::vector{one(loop)}, [] { return true; });
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().code, ErrorCode::incomplete);
}

TEST(Vary, DrawsTheSameWhateverElseIsDrawn) {
  Varied load{Varied::Of::effect, "load", "", "payload_mass", "mass", {Distribution::Kind::uniform, 0, 0.2}};
  Varied start{Varied::Of::start, "x", "", "", "x", {Distribution::Kind::normal, 0, 0.05, -0.1, 0.1}};
  ASSERT_TRUE(check(load, "vary[0]"));
  ASSERT_TRUE(check(start, "vary[1]"));
  EXPECT_EQ(load.unit, "kg");
  EXPECT_EQ(draw(std::vector{load}, 5)[0], draw(std::vector{start, load}, 5)[1]);
  double sum = 0, squares = 0;
  for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
    const auto v = draw(std::vector{load, start}, seed);
    EXPECT_LE(std::abs(v[1]), 0.1);
    sum += v[0] / 4000;
    squares += v[0] * v[0] / 4000;
  }
  EXPECT_NEAR(sum, 0.1, 0.003);  // three standard errors of the mean are 0.0027
  EXPECT_NEAR(squares - sum * sum, 0.04 / 12, 2e-4);
}

TEST(Vary, TellsWhatCannotBe) {
  const auto words = [](Varied v) { return check(v, "vary[2]").error().text(); };
  using K = Distribution::Kind;
  EXPECT_NE(
      words({Varied::Of::effect, "a", "", "payload", "mass", {K::uniform, 0, 1}}).find("vary[2].effect"),
      std::string::npos);
  EXPECT_NE(
      words({Varied::Of::effect, "a", "", "payload_mass", "mas", {K::uniform, 0, 1}}).find("It has mass"),
      std::string::npos);
  EXPECT_NE(words({Varied::Of::effect, "a", "", "payload_mass", "mass", {K::uniform, 0, 1e6}}).find("kg"),
            std::string::npos);
  EXPECT_NE(
      words({Varied::Of::effect, "a", "", "clock_offset", "offset", {K::uniform, 0, 1}}).find("sensors"),
      std::string::npos);
  EXPECT_NE(words({Varied::Of::start, "a", "", "", "w", {K::uniform, 0, 1}}).find("roll"), std::string::npos);
  EXPECT_NE(words({Varied::Of::gain, "a", "", "", "kq", {K::uniform, 0, 1}}).find("kp"), std::string::npos);
  EXPECT_NE(words({Varied::Of::gain, "a", "", "", "kp", {K::normal, -50, 0.1}}).find("outside"),
            std::string::npos);
}

TEST(Vary, ChangesModelStartAndGains) {
  std::vector<Varied> varied{{Varied::Of::effect,
                              "density",
                              "",
                              "hung_cable",
                              "linear_density",
                              {Distribution::Kind::uniform, 0, 1}},
                             {Varied::Of::start, "yaw", "", "", "yaw", {Distribution::Kind::uniform, 0, 1}},
                             {Varied::Of::gain, "kp", "", "", "kp", {Distribution::Kind::uniform, 0.5, 2}}};
  const std::vector<double> values{0.3, 0.2, 1.5};
  const auto model = with_values({}, varied, values);
  ASSERT_EQ(model.effects.size(), 1u);
  EXPECT_EQ(model.effects[0].theta[0], 0.3);
  EXPECT_NEAR(log_rotation(start_with({}, varied, values).q_WB).z(), 0.2, 1e-12);
  EXPECT_EQ(gains_with({}, varied, values).kp, 1.5 * control::ControllerConfig{}.kp);
  EXPECT_EQ(gains_with({}, varied, values).kv, control::ControllerConfig{}.kv);
}

}  // namespace
}  // namespace omniflight::campaign
