// The chain of point masses against textbook cables: weight, catenary, frequencies, and a chain ten times
// finer.
#include "../src/catenary.hpp"
#include "effect_testing.hpp"
#include "omniflight_physics/cable_chain.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr double kStep = 0.001;

CableChain make(const CableConfig& c) {
  auto chain = CableChain::create(c);
  EXPECT_TRUE(chain) << chain.error().text();
  return *chain;
}

void settle(CableChain& chain, const Vec3& upper_end, double duration) {
  for (double t = 0; t < duration; t += kStep) chain.step(upper_end, kStep);
}

TEST(CableChain, HangsWithItsWeight) {
  CableChain chain = make({.nodes = 20, .length = 2, .linear_density = 0.25, .damping = 2, .floor_z = -5});
  chain.hang(Vec3(0.1, 0.2, 1));
  settle(chain, Vec3(0.1, 0.2, 1), 1.0);
  EXPECT_LT((chain.end_force() - Vec3(0, 0, -0.5 * kGravity)).norm(), 1e-3 * 0.5 * kGravity);
  for (int link = 1; link <= 20; ++link)  // tension in the middle of a link: the weight below
    EXPECT_NEAR(chain.tension(link), 0.25 * kGravity * (2 - 0.1 * link + 0.05), 0.01 * 0.5 * kGravity)
        << link;
  EXPECT_NEAR(chain.position(20).z(), -1, 1e-6);
}

TEST(CableChain, CarriesWhatIsAboveTheFloorAtEveryHeight) {
  // lifted slowly from a heap: lambda g h, without the steps of whole nodes
  CableChain chain = make({.nodes = 20, .length = 2, .linear_density = 0.25, .damping = 0.3});
  chain.hang(Vec3(0, 0, 0.5));
  settle(chain, Vec3(0, 0, 0.5), 1.0);
  double worst = 0, z = 0.5, mean = 0;
  int n = 0;
  for (; z < 1.6; z += 0.1 * kStep, ++n) {
    chain.step(Vec3(0, 0, z), kStep);
    mean += -chain.end_force().z() - 0.25 * kGravity * z;
    if (n > 1000) worst = std::max(worst, std::abs(-chain.end_force().z() - 0.25 * kGravity * z));
  }
  EXPECT_LT(std::abs(mean / n), 0.005 * 0.25 * kGravity * 2);
  EXPECT_LT(worst, 0.02 * 0.25 * kGravity * 2);
}

TEST(CableChain, BetweenTwoEndsIsTheCatenary) {
  for (const auto& [x, z] : {std::pair{1.0, 0.6}, {1.5, 0.2}, {1.8, 0.5}, {1.97, 0.2}, {0.6, 0.4}}) {
    CableChain chain = make(
        {.nodes = 20, .length = 2, .linear_density = 0.1, .damping = 5, .floor_z = -10, .fixed_end = true});
    const Vec3 top(0, 0, z), far(x, 0, 0);
    chain.stretch(top, far);
    settle(chain, top, 5.0);
    const CatenaryEnds e = [&] {
      // anchor not on a floor: b may be below the length; solve L^2 - z^2 = (2 a sinh(x/2a))^2 for a
      double low = 1e-3, high = 1e3;
      for (int k = 0; k < 200; ++k) {
        const double a = std::sqrt(low * high);
        (std::pow(2 * a * std::sinh(x / (2 * a)), 2) > 4 - z * z ? low : high) = a;
      }
      const double a = low, u = std::asinh(z / (2 * a * std::sinh(x / (2 * a))));
      return CatenaryEnds{a, a * std::sinh(x / (2 * a) + u)};
    }();
    const double weight = 0.1 * kGravity, tension = weight * std::hypot(e.a, e.b);
    const Vec3 expected(weight * e.a, 0, -weight * e.b);
    EXPECT_LT((chain.end_force() - expected).norm(), 0.01 * tension) << x << " " << z;
    // shape: height along the catenary, from the upper end down
    const double start = -std::asinh(e.b / e.a);
    for (int i = 0; i <= 20; ++i) {
      const double s = 0.1 * i, arc = std::asinh((s - e.b) / e.a);
      const Vec3 p(e.a * (arc - start), 0, z + e.a * (std::cosh(arc) - std::cosh(start)));
      EXPECT_LT((chain.position(i) - p).norm(), 0.01 * 2) << x << " " << i;
    }
  }
}

TEST(CableChain, LiesOnTheFloorWithTheTensionOfTheCatenaryEffect) {
  // from one that pulls less along the floor than a link weighs to one that is lifted nearly whole
  for (const auto& [x, z] : {std::pair{1.4, 0.65}, {1.4, 0.8}, {1.7, 0.4}, {1.7, 0.5}, {1.7, 0.7}}) {
    CableChain chain = make(
        {.nodes = 20, .length = 2, .linear_density = 0.1, .damping = 5, .friction = 0.0, .fixed_end = true});
    const Vec3 top(0, 0, z);
    chain.stretch(top, Vec3(x, 0, 0));
    settle(chain, top, 6.0);
    const CatenaryEnds e = solve_catenary_ends(x, z, 2.0, 1e-9);
    const double weight = 0.1 * kGravity;
    EXPECT_LT((chain.end_force() - Vec3(weight * e.a, 0, -weight * e.b)).norm(),
              0.01 * weight * (e.a > 0.1 ? std::hypot(e.a, e.b) : 2.0))  // along the floor, a link
        << x << " " << z;
    const double above = e.a > 1e-6 ? e.a * std::asinh(std::min(e.b, 2.0) / e.a) : 0.0;  // to where it lands
    for (int i = 0; i <= 20; ++i) {
      const double left = std::max(e.b - 0.1 * i, 0.0);  // still hanging
      const double height = std::sqrt(e.a * e.a + left * left) - e.a;
      EXPECT_NEAR(chain.position(i).z(), height, 0.01 * 2) << x << " " << z << " " << i;
      if (left > 0) {
        EXPECT_NEAR(chain.position(i).x(), above - e.a * std::asinh(left / e.a), 0.01 * 2);
      }
    }
  }
}

TEST(CableChain, IsLiftedAndLaidDownAsAChainTenTimesFiner) {
  // 1 m in 2.5 s, up from a heap and down on one: no link is snatched, and none falls. Against the fine chain
  // and the law: weight and inertia of what hangs, momentum of what is gathered, damping
  const double density = 0.2, damping = 0.5, weight = density * kGravity * 2;
  for (const bool up : {true, false}) {
    const auto f = [](double t) { return std::clamp(t / 2.5, 0.0, 1.0); };
    const auto way = [&](double t) {
      const double moved = f(t) * f(t) * (3 - 2 * f(t));
      return Vec3(0, 0, up ? 0.3 + moved : 1.5 - moved);
    };
    CableConfig c{.nodes = 20, .length = 2, .linear_density = density, .damping = damping};
    CableChain coarse = make(c);
    c.nodes = 200;
    CableChain fine = make(c);
    coarse.hang(way(0));
    fine.hang(way(0));
    double error = 0, beside = 0, shape = 0;
    const int n = 2800;
    for (int k = 1; k <= n; ++k) {
      const double t = k * kStep, sign = up ? 1 : -1, v = sign * 6 * f(t) * (1 - f(t)) / 2.5,
                   a = t < 2.5 ? sign * 6 * (1 - 2 * f(t)) / 6.25 : 0, z = way(t).z();
      coarse.step(way(t), kStep);
      Vec3 mean = Vec3::Zero();  // of the fine chain, whose links leave the floor one by one
      for (int j = 4; j >= 0; --j) {
        fine.step(way(t - 0.2 * j * kStep), 0.2 * kStep);
        mean += 0.2 * fine.end_force();
      }
      error += (coarse.end_force() - mean).squaredNorm();
      const double gathered = up ? v * v : 0;
      const double law = density * ((z - 0.05) * a + z * kGravity + gathered + damping * z * v);
      beside += std::pow(-coarse.end_force().z() - law, 2);
      for (int i = 1; i <= 20; ++i)
        shape = std::max(shape, (coarse.position(i) - fine.position(10 * i)).norm());
    }
    EXPECT_LT(std::sqrt(error / n), 0.01 * weight) << up;
    EXPECT_LT(std::sqrt(beside / n), 0.01 * weight) << up;
    EXPECT_LT(shape, 0.01 * 2) << up;
  }
}

/// Frequency [Hz] of a small free swing that starts in a mode of the hanging chain (zero of J0), from the
/// time between crossings of the lower end.
double frequency(int nodes, double zero, double step) {
  CableChain chain =
      make({.nodes = nodes, .length = 1.2, .linear_density = 0.1, .damping = 0, .floor_z = -9});
  // drive the upper end at the textbook frequency first would favour the answer; displace by a short push
  const Vec3 top(0, 0, 0);
  chain.hang(top);
  const double w = zero / 2 * std::sqrt(kGravity / 1.2);
  // excite by moving the upper end for two periods, then let it swing
  double t = 0;
  for (; t < 4 * kPi / w; t += step) chain.step(Vec3(0.002 * std::sin(w * t), 0, 0), step);
  std::vector<double> crossings;
  // the mode shape tells modes apart: project the swing on J0(zero sqrt(s/L))
  double last = 0;
  for (int k = 0; k < static_cast<int>(8 * 2 * kPi / w / step); ++k, t += step) {
    chain.step(top, step);
    double amplitude = 0;
    for (int i = 1; i <= nodes; ++i) {
      const double below = 1.0 - static_cast<double>(i) / nodes;
      amplitude +=
          chain.position(i).x() * std::cyl_bessel_j(0, zero * std::sqrt(below)) * (i == nodes ? 0.5 : 1);
    }
    if (k > 0 && last < 0 && amplitude >= 0) crossings.push_back(t - step * amplitude / (amplitude - last));
    last = amplitude;
  }
  EXPECT_GE(crossings.size(), 5u);
  return static_cast<double>(crossings.size() - 1) / (crossings.back() - crossings.front());
}

TEST(CableChain, SwingsAtTheFrequenciesOfTheHangingChain) {
  // omega_k = j_0k / 2 sqrt(g / L)
  const double root = std::sqrt(kGravity / 1.2) / (4 * kPi);
  EXPECT_NEAR(frequency(20, 2.404825557695773, kStep), 2.404825557695773 * root, 0.005 * 2.405 * root);
  EXPECT_NEAR(frequency(20, 5.520078110286311, kStep), 5.520078110286311 * root, 0.01 * 5.52 * root);
}

TEST(CableChain, AgreesWithAChainTenTimesFiner) {
  // upper end moves up, sideways and stops; force and shape within 1 % of a fine chain at a fine step
  const auto way = [](double t) {
    const double s = std::min(t, 1.5) / 1.5, f = s * s * (3 - 2 * s);
    return Vec3(0.4 * f, 0.1 * f, 2.3 + 0.3 * f);
  };
  CableConfig c{.nodes = 20, .length = 2, .linear_density = 0.2, .damping = 0.5};
  CableChain coarse = make(c);
  c.nodes = 200;
  CableChain fine = make(c);
  coarse.hang(way(0));
  fine.hang(way(0));
  double error = 0, size = 0, shape = 0;
  for (int k = 1; k <= 3000; ++k) {
    coarse.step(way(k * kStep), kStep);
    for (int j = 4; j >= 0; --j) fine.step(way((k - 0.2 * j) * kStep), 0.2 * kStep);
    const double weight = 0.2 * kGravity * 2;
    error += (coarse.end_force() - fine.end_force()).squaredNorm();
    size += weight * weight;
    for (int i = 1; i <= 20; ++i)
      shape = std::max(shape, (coarse.position(i) - fine.position(10 * i)).norm());
  }
  EXPECT_LT(std::sqrt(error / size), 0.01);
  EXPECT_LT(shape, 0.01 * 2);
}

TEST(CableFidelities, SwingAlikeAfterALateralMove) {
  // 0.3 m sideways within 2.5 s, slow for the second mode; then wait: one mode against twenty links of 1.5 m
  std::vector<Situation> motion;
  const int n = 5000;
  for (int k = 0; k < n; ++k) {
    const double t = k * kStep, s = std::min(t / 2.5, 1.0);
    RigidState body;
    body.p_WB = Vec3(0.3 * s * s * s * (10 - 15 * s + 6 * s * s), 0, 3);
    body.v_WB_W.x() = 0.3 * 30 * s * s * (1 - s) * (1 - s) / 2.5;
    motion.push_back(situation(cube(), body, 0, std::vector<double>(8, 0.0)));
    motion.back().a_WB_B.x() = 0.3 * 60 * s * (1 - s) * (1 - 2 * s) / (2.5 * 2.5);
  }
  const std::vector<double> pendulum{0.1, 1.5, 1.5, 0.02}, chain{0.1, 1.5, 0, 0.5, 0.123};  // c = 2 zeta w_1
  std::vector<double> a(6 * motion.size());
  find_effect("cable_pendulum")->replay(motion, kStep, pendulum.data(), a.data(), nullptr);
  const Effect* e = find_effect("cable_chain");
  std::vector<double> memory(static_cast<std::size_t>(e->memory_size().total()));
  e->start_memory(motion[0], chain.data(), memory.data());
  Random random(1);
  double difference = 0, size = 0;
  for (std::size_t k = 1; k < motion.size(); ++k) {
    e->advance(motion[k], chain.data(), kStep, random, memory.data());
    Wrench w;
    e->add_memory_wrench(motion[k], chain.data(), memory.data(), w);
    const Vec6 b = w.at(motion[k]);
    difference += std::pow(a[6 * k] - b[0], 2);
    size += a[6 * k] * a[6 * k];
    // the chain also feels what is of second order in its angle (0.15 rad here), which a linear mode has not
    ASSERT_NEAR(b[2], a[6 * k + 2], 0.15 * 0.15 * 1.5 * 0.1 * 1.5 * kGravity);
  }
  EXPECT_LT(std::sqrt(difference / size), 0.1);
}

TEST(CableChain, GoesSlackAndTautWithoutGainingEnergy) {
  CableChain chain = make({.nodes = 20, .length = 1, .linear_density = 0.1, .damping = 0, .floor_z = -9});
  chain.stretch(Vec3(0, 0, 0), Vec3(0.6, 0.1, 0.4));  // thrown up in a heap, falls, snaps taut
  for (int k = 0; k < 20; ++k) chain.step(Vec3::Zero(), kStep);
  const double start = chain.energy();
  double most = start, longest = 0;
  for (int k = 0; k < 4000; ++k) {
    chain.step(Vec3::Zero(), kStep);
    most = std::max(most, chain.energy());
    for (int i = 1; i <= 20; ++i) {
      ASSERT_GE(chain.tension(i), 0.0) << "a cable never pushes";
      longest = std::max(longest, (chain.position(i) - chain.position(i - 1)).norm());
    }
  }
  EXPECT_LT(most, start + 0.01 * 0.1 * kGravity);
  EXPECT_LT(longest, 0.05 * 1.01);
}

TEST(CableChain, SinksIntoTheFloorByLessThanThreeMillimetres) {
  CableChain chain = make({.nodes = 20, .length = 2, .linear_density = 0.1, .damping = 0.5});
  chain.hang(Vec3(0, 0, 2.5));
  double lowest = 1;
  for (int k = 0; k < 4000; ++k) {
    const double z = std::max(0.3, 2.5 - 0.001 * k);
    chain.step(Vec3(0, 0, z), kStep);
    for (int i = 1; i <= 20; ++i) lowest = std::min(lowest, chain.position(i).z());
  }
  EXPECT_GT(lowest, -3e-3);
  EXPECT_NEAR(-chain.end_force().z(), 0.1 * kGravity * 0.3, 0.03 * 0.1 * kGravity * 2);
}

TEST(CableChain, RepeatsToTheBitAndRefusesWhatIsNoCable) {
  const auto run = [] {
    CableChain chain = make({.nodes = 12, .length = 1.5});
    chain.hang(Vec3(0, 0, 1));
    for (int k = 0; k < 500; ++k) chain.step(Vec3(0.1 * std::sin(0.01 * k), 0, 1 + 0.0005 * k), kStep);
    return chain.position(12);
  };
  EXPECT_EQ(run(), run());
  EXPECT_NE(CableChain::create({.nodes = 1}).error().text().find("nodes"), std::string::npos);
  EXPECT_NE(CableChain::create({.length = -1}).error().text().find("length"), std::string::npos);
  EXPECT_NE(CableChain::create({.linear_density = std::nan("")}).error().text().find("kg/m"),
            std::string::npos);
}

}  // namespace
}  // namespace omniflight::physics::testing
