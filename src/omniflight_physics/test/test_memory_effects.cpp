// Effects that remember: slung load, swinging cable, inflow, gust; and the two ropes of the start and the
// floor.
#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

const std::vector<double> kLoad{0.3, 0.8, 0.2, 0.05, -0.02, -0.1};

TEST(SlungLoad, PullsWithTheTensionThatItsOwnMotionNeeds) {
  for (const Situation& s : six_states()) {
    const Vec3 q = Vec3(0.3, -0.4, -1).normalized(), dq = q.cross(Vec3(0.5, 1.0, -0.7));
    std::vector<double> x{q.x(), q.y(), q.z(), dq.x(), dq.y(), dq.z(), 1}, rate(6);
    find_effect("slung_load")->state_rate(s, kLoad.data(), x.data(), rate.data());
    // the load: Newton with the tension, in the world
    const Vec3 r(0.05, -0.02, -0.1), &w = s.body.w_WB_B;
    const Vec3 a_A = s.R_WB * (s.a_WB_B + s.dw_WB_B.cross(r) + w.cross(w.cross(r)));
    const Vec3 ddq(rate[3], rate[4], rate[5]);
    const Vec3 a_load = a_A + 0.8 * ddq;
    const Vec3 g(0, 0, -kGravity);
    // friction in the joint: a couple against the turning of the cable in the vehicle
    const Vec3 rub = 0.3 * 0.2 * 0.8 * (dq - (s.R_WB * w).cross(q));
    const Vec3 force_on_load = 0.3 * (a_load - g) + rub;  // without it
    const double tension = -force_on_load.dot(q);
    EXPECT_LT((force_on_load + tension * q).norm(), 1e-12) << "a cable pulls along itself";
    EXPECT_LT((Vec3(rate[0], rate[1], rate[2]) - dq).norm(), 1e-12);
    EXPECT_NEAR(q.dot(ddq) + dq.squaredNorm(), 0.0, 1e-12) << "and keeps its length";
    const Vec3 f = s.R_WB.transpose() * (tension * q + rub);
    Vec6 expected;
    expected << f, r.cross(f) + s.R_WB.transpose() * (0.8 * q).cross(rub);
    EXPECT_LT((remembered("slung_load", s, kLoad, x) - expected).norm(), 1e-12);
  }
}

TEST(SlungLoad, AtRestIsItsWeight) {
  const Situation s = hover(2.0);
  const std::vector<double> hanging{0, 0, -1, 0, 0, 0, 1};
  std::vector<double> rate(6);
  find_effect("slung_load")->state_rate(s, kLoad.data(), hanging.data(), rate.data());
  EXPECT_LT(Eigen::Map<Vec6>(rate.data()).norm(), 1e-12);
  EXPECT_LT((remembered("slung_load", s, kLoad, hanging).head<3>() - Vec3(0, 0, -0.3 * kGravity)).norm(),
            1e-12);
}

TEST(SlungLoad, OnASlackCableFallsFreelyAndDoesNotPush) {
  const Effect* load = find_effect("slung_load");
  for (const Situation& s : six_states()) {
    const std::vector<double> x{0.3, -0.2, -0.5, 0.4, 0.1, 0.6, 0};
    EXPECT_EQ(remembered("slung_load", s, kLoad, x), Vec6(Vec6::Zero()));
    std::vector<double> rate(6);
    load->state_rate(s, kLoad.data(), x.data(), rate.data());
    const Vec3 r(0.05, -0.02, -0.1), &w = s.body.w_WB_B;
    const Vec3 a_A = s.R_WB * (s.a_WB_B + s.dw_WB_B.cross(r) + w.cross(w.cross(r)));
    const Vec3 a_load = a_A + 0.8 * Vec3(rate[3], rate[4], rate[5]);
    EXPECT_LT((a_load - Vec3(0, 0, -kGravity)).norm(), 1e-12);
  }
}

TEST(SlungLoad, SlacksWhereItWouldHaveToPushAndIsCaughtAtItsLength) {
  const Effect* load = find_effect("slung_load");
  Situation s = hover(2.0);
  Random random(1);
  const auto settled = [&](std::vector<double> x) {
    load->advance(s, kLoad.data(), 0.001, random, x.data());
    return x[6];
  };
  EXPECT_EQ(settled({0, 0, -1, 0, 0, 0, 1}), 1.0);
  s.a_WB_B = Vec3(0, 0, -1.01 * kGravity);  // the vehicle falls faster than the load
  EXPECT_EQ(settled({0, 0, -1, 0, 0, 0, 1}), 0.0);
  EXPECT_EQ(settled({0, 0, -1, 0.8, 0, 0, 1}), 1.0) << "swinging keeps it taut";
  EXPECT_EQ(settled({0, 0, -0.9, 0, 0, -1, 0}), 0.0) << "not there yet";
  EXPECT_EQ(settled({0, 0, -1.001, 0, 0, -1, 0}), 1.0);
  EXPECT_EQ(settled({0, 0, -1.001, 0, 0, 1, 0}), 0.0) << "on its way back";
}

TEST(CableChainEffect, PullsAtItsAttachmentAsTheChainAnswers) {
  const std::vector<double> theta{0.2, 2.0, -0.12, 0.5, 0.2};
  const Effect* e = find_effect("cable_chain");
  for (const Situation& s : six_states()) {
    std::vector<double> memory(static_cast<std::size_t>(e->memory_size().total()));
    e->start_memory(s, theta.data(), memory.data());
    Random random(1);
    for (int k = 0; k < 50; ++k) e->advance(later(s, 0.001 * k), theta.data(), 0.001, random, memory.data());
    // the last six numbers: direction in the world, pull, mass, mass at the end, of a cable of 1 kg/m
    const double* answer = memory.data() + memory.size() - 6;
    const Vec3 n(answer[0], answer[1], answer[2]), r(0, 0, -0.12), &w = s.body.w_WB_B;
    const Vec3 a_A = s.R_WB * (s.a_WB_B + s.dw_WB_B.cross(r) + w.cross(w.cross(r)));
    const Vec3 f_W =
        0.2 * ((answer[3] - answer[4] * n.dot(a_A)) * n - answer[5] * (a_A + Vec3(0, 0, kGravity)));
    const Vec3 f = s.R_WB.transpose() * f_W;
    Vec6 expected;
    expected << f, r.cross(f);
    EXPECT_GT(f.norm(), 0.05);
    EXPECT_LT((remembered("cable_chain", s, theta, memory) - expected).norm(), 1e-12 * (1 + f.norm()));
  }
}

TEST(CablePendulum, AtRestAndInSlowMotionIsTheHungCable) {
  Situation s = hover(1.5);
  const std::vector<double> theta{0.2, 0.1, 5, 0.05};
  EXPECT_LT((remembered("cable_pendulum", s, theta, {0, 0, 0, 0}) - wrench_of("hung_cable", s, {0.2, 0.1, 5}))
                .norm(),
            1e-12);
  // in a steady lateral acceleration the mode settles, and all the hanging mass is carried along
  s.a_WB_B = Vec3(0.3, 0, 0);
  const double square = std::pow(2.404825557695773 / 2, 2) * kGravity / 1.4;
  const Vec6 settled = remembered("cable_pendulum", s, theta, {-0.3 / square, 0, 0, 0});
  EXPECT_NEAR(settled[0], -0.2 * 1.4 * 0.3, 1e-12);
}

TEST(DynamicInflow, SettlesToNothingAndLeadsASpeedUp) {
  const std::vector<double> theta{2e-4, 0.02};
  const Effect* e = find_effect("dynamic_inflow");
  std::vector<double> w(16);
  const Situation slow = hover(1, 0, 600), fast = hover(1, 0, 800);
  e->start_memory(slow, theta.data(), w.data());
  EXPECT_EQ(remembered("dynamic_inflow", slow, theta, w).norm(), 0.0);
  const double area = kPi * 0.1016 * 0.1016;
  const auto induced = [&](const Situation& s) { return std::sqrt(s.rotors[0].thrust / (2 * 1.2 * area)); };
  EXPECT_NEAR(w[0], induced(slow), 1e-12);
  const Vec6 step = remembered("dynamic_inflow", fast, theta, w);
  EXPECT_NEAR(step[2], 8 * 2e-4 * 800 * (induced(fast) - induced(slow)), 1e-12);
  std::vector<double> rate(16);
  e->state_rate(fast, theta.data(), w.data(), rate.data());
  EXPECT_NEAR(rate[0], (induced(fast) - induced(slow)) / 0.02, 1e-9);
}

TEST(Gust, HasItsIntensityAndCorrelationTime) {
  const std::vector<double> theta{0.4, 0.5, 0.02};
  const Effect* e = find_effect("gust");
  Random random(3);
  std::vector<double> w(3, 0.0);
  const Situation s = hover(1);
  const double step = 0.02;
  const int lag = 25, n = 200000;  // 0.5 s
  double square = 0, product = 0;
  std::vector<double> past(lag, 0.0);
  for (int k = 0; k < n; ++k) {
    e->advance(s, theta.data(), step, random, w.data());
    square += w[0] * w[0];
    product += w[0] * past[static_cast<std::size_t>(k % lag)];
    past[static_cast<std::size_t>(k % lag)] = w[0];
  }
  EXPECT_NEAR(std::sqrt(square / n), 0.4, 0.02);
  EXPECT_NEAR(product / square, std::exp(-1.0), 0.04);
  const Vec3 gust(w[0], w[1], w[2]);
  const Vec6 f = remembered("gust", s, theta, w);
  EXPECT_LT((f.head<3>() - 0.5 * 1.2 * 0.02 * gust.norm() * gust).norm(), 1e-12);
}

TEST(Gust, OfASteadySpeedIsTheWind) {
  for (const Situation& s : six_states()) {
    const Vec6 wind = wrench_of("wind", s, {0.7, -0.3, 0.02});
    EXPECT_LT((remembered("gust", s, {0.1, 1, 0.02}, {0.7, -0.3, 0}) - wind).norm(), 1e-9);
  }
}

/// Wrenches of an effect over two seconds of hover that climbs from 0.8 m and sways.
std::vector<Vec6> over_a_climb(const char* id, const std::vector<double>& theta, std::uint64_t seed) {
  const Effect* e = find_effect(id);
  std::vector<double> memory(static_cast<std::size_t>(e->memory_size().total()));
  Random random(seed);
  std::vector<Vec6> out;
  for (int k = 0; k <= 2000; ++k) {
    const double t = 0.001 * k;
    Situation s = hover(0.8 + 0.3 * t);
    s.body.p_WB.x() = 0.01 * std::sin(3 * t);
    s.body.v_WB_W = Vec3(0.03 * std::cos(3 * t), 0, 0.3);
    s.v_WB_B = s.body.v_WB_W;
    if (k == 0)
      e->start_memory(s, theta.data(), memory.data());
    else
      e->advance(s, theta.data(), 0.001, random, memory.data());
    out.push_back(remembered(id, s, theta, memory));
  }
  return out;
}

TEST(GustAndChain, RepeatAMotionToTheBit) {
  const std::vector<double> gust{0.4, 0.5, 0.02}, chain{0.2, 2.0, -0.12, 0.5, 0.2};
  EXPECT_EQ(over_a_climb("gust", gust, 5), over_a_climb("gust", gust, 5));
  EXPECT_NE(over_a_climb("gust", gust, 5), over_a_climb("gust", gust, 6)) << "by its seed";
  EXPECT_EQ(over_a_climb("cable_chain", chain, 5), over_a_climb("cable_chain", chain, 6)) << "no seed";
  // what a recording cannot tell, noise and the contact of links, is not offered to those who replay it
  EXPECT_FALSE(find_effect("gust")->can_replay() || find_effect("cable_chain")->can_replay());
}

TEST(GustAndChain, AreLinearWhereTheySaySo) {
  // derivative by area, by density: the wrench over the parameter
  const auto a = over_a_climb("gust", {0.4, 0.5, 0.02}, 5), b = over_a_climb("gust", {0.4, 0.5, 0.03}, 5);
  const auto c = over_a_climb("cable_chain", {0.2, 2.0, -0.12, 0.5, 0.2}, 1),
             d = over_a_climb("cable_chain", {0.3, 2.0, -0.12, 0.5, 0.2}, 1);
  double size = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    ASSERT_LT((b[k] - 1.5 * a[k]).norm(), 1e-12);
    ASSERT_LT((d[k] - 1.5 * c[k]).norm(), 1e-12 * (1 + c[k].norm()));
    size += a[k].norm() + c[k].norm();
  }
  EXPECT_GT(size, 1.0);
  EXPECT_TRUE(find_effect("cable_chain")->info().parameters[0].linear);
}

TEST(Gust, TwiceAsStrongIsTwiceTheWind) {
  const Effect* e = find_effect("gust");
  const Situation s = hover(1);
  Random first(3), second(3);
  std::vector<double> w(3), w2(3);
  for (int k = 0; k < 500; ++k) {
    const double theta[] = {0.3, 0.5, 0.02}, stronger[] = {0.6, 0.5, 0.02};
    e->advance(s, theta, 0.01, first, w.data());
    e->advance(s, stronger, 0.01, second, w2.data());
    for (std::size_t i = 0; i < 3; ++i) ASSERT_NEAR(w2[i], 2 * w[i], 1e-12);
  }
}

TEST(CableChainEffect, CarriesWhatIsAboveTheFloorAsItIsLifted) {
  // weight, what is gathered, damping: lambda (g h + v^2 + c h v), h from the attachment; means of 20 ms
  const auto wrench = over_a_climb("cable_chain", {0.2, 2.0, -0.12, 0.5, 0.2}, 1);
  EXPECT_NEAR(-wrench[0][2], 0.2 * kGravity * 0.68, 1e-9) << "hanging";
  for (std::size_t k = 100; k < 2000; k += 20) {
    double error = 0;
    for (std::size_t j = k; j < k + 20; ++j) {
      const double h = 0.68 + 0.3e-3 * static_cast<double>(j);
      error += (-wrench[j][2] - 0.2 * (kGravity * h + 0.09 + 0.2 * h * 0.3)) / 20;
    }
    EXPECT_LT(std::abs(error), 0.01 * 0.2 * kGravity * 2) << k;
  }
}

TEST(HangingStart, CarriesBelowItsHeightAndNeverPushes) {
  const std::vector<double> theta{100, 1.4, 0.05};
  for (const Situation& s : six_states()) {
    const double z = s.body.p_WB.z(), pull = 100 * std::max(0.0, 1.4 - z - 0.05 * s.body.v_WB_W.z());
    const Vec3 expected = s.R_WB.transpose() * Vec3(0, 0, z < 1.4 ? pull : 0.0);
    EXPECT_LT((wrench_of("hanging_start", s, theta).head<3>() - expected).norm(), 1e-12);
  }
  EXPECT_EQ(wrench_of("hanging_start", hover(1.41), theta).norm(), 0.0);
  EXPECT_NEAR(wrench_of("hanging_start", hover(1.3), theta)[2], 10.0, 1e-12);
}

}  // namespace
}  // namespace omniflight::physics::testing
