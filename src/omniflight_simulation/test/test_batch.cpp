// Vehicles in lanes fly as Plants do: every effect, every combination, to 1e-12; and allocate nothing.
#include <gtest/gtest.h>

// the lanes are not compiled for it (lane_kernel-inl.hpp)
#define HWY_DISABLED_TARGETS HWY_SSSE3

#include <chrono>
#include <cstdlib>

#include "counted_malloc.hpp"
#include "instruction_sets.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_simulation/batch.hpp"

namespace omniflight::simulation {
namespace {

using Effects = std::vector<std::pair<std::string, std::vector<double>>>;

vehicle::Vehicle omnimorph() {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  return vehicle::load_vehicle("omnimorph").value();
}

physics::Model with(const Effects& effects) {
  physics::Model m;
  for (const auto& [id, theta] : effects) m.effects.push_back({physics::find_effect(id), theta});
  return m;
}

/// Values within reach of a real vehicle, the sign and size drawn.
std::vector<double> draw(const physics::Effect& effect, Random& random) {
  std::vector<double> theta;
  for (const auto& p : effect.info().parameters)
    theta.push_back(std::clamp(random.uniform(0.3, 1.0) * p.typical, p.lower, p.upper));
  return theta;
}

PlantConfig tumbling() {
  PlantConfig c;
  c.initial.p_WB = Vec3(0.2, -0.1, 0.8);
  c.initial.v_WB_W = Vec3(1.0, -0.5, 2.0);
  c.initial.w_WB_B = Vec3(5, 7, -6);
  c.initial.q_WB = exp_rotation(Vec3(0.3, -0.2, 0.5));
  c.initial_alpha = 0.4;
  return c;
}

double relative(const Vec3& a, const Vec3& b) { return (a - b).norm() / std::max(1.0, a.norm()); }

/// Flies vehicle i of the batch and a Plant for a second, with commands [rad/s] that change and a tilt that
/// moves.
double difference(const vehicle::Vehicle& v, const std::vector<physics::Model>& models,
                  const BatchConfig& config, double mean = 600, double spread = 250) {
  Batch batch = Batch::create(v, models, config).value();
  std::vector<Plant> plants;
  for (const auto& m : models) plants.push_back(Plant::create(v, m, config.plant).value());
  Random random(3);
  std::vector<double> speed(v.rotors.size());
  double worst = 0;
  for (int k = 0; k < 1000; ++k) {
    for (std::size_t i = 0; k % 20 == 0 && i < models.size(); ++i) {
      for (double& s : speed) s = mean + spread * random.uniform(-1, 1);
      const double alpha = 0.4 + 0.2 * random.uniform();
      EXPECT_TRUE(batch.set_command(i, speed, alpha));
      EXPECT_TRUE(plants[i].set_command(speed, alpha));
    }
    EXPECT_EQ(batch.step(), models.size());
    for (auto& p : plants) EXPECT_TRUE(p.step());
    if (k % 100 != 99) continue;
    for (std::size_t i = 0; i < models.size(); ++i) {
      const RigidState a = plants[i].body(), b = batch.body(i);
      worst = std::max({worst, relative(a.p_WB, b.p_WB), relative(a.v_WB_W, b.v_WB_W),
                        relative(a.w_WB_B, b.w_WB_B), (a.q_WB.coeffs() - b.q_WB.coeffs()).norm(),
                        relative(plants[i].specific_force(), batch.specific_force(i)),
                        relative(plants[i].angular_acceleration(), batch.angular_acceleration(i)),
                        std::abs(plants[i].alpha() - batch.alpha(i))});
      for (std::size_t r = 0; r < v.rotors.size(); ++r)
        worst = std::max(worst, std::abs(plants[i].rotor_speed()[r] - batch.rotor_speed(i, r)) / mean);
    }
  }
  return worst;
}

TEST(Batch, EveryEffectInLanesIsThatOfThePlant) {
  const auto v = omnimorph();
  Random random(1);
  std::vector<physics::Model> models;
  for (const physics::Effect* e : physics::builtin_effects())
    if (flies_in_lanes(*e)) models.push_back(with({{e->info().id, draw(*e, random)}}));
  ASSERT_GE(models.size(), 18u);
  // each alone: an error must not hide behind the tumbling of another
  for (const auto& m : models)
    EXPECT_LT(difference(v, {m}, {.plant = tumbling()}), 1e-12) << m.effects[0].effect->info().id;
  EXPECT_LT(difference(v, models, {.plant = tumbling()}), 1e-12);
}

TEST(Batch, CombinationsOfEffectsAreThoseOfThePlant) {
  Random random(2);
  std::vector<physics::Model> models;
  for (int n = 0; n < 20; ++n) {
    physics::Model m;
    for (const physics::Effect* e : physics::builtin_effects())
      if (flies_in_lanes(*e) && random.uniform() < 0.5) m.effects.push_back({e, draw(*e, random)});
    models.push_back(std::move(m));
  }
  EXPECT_LT(difference(omnimorph(), models, {.plant = tumbling()}), 1e-12);
}

TEST(Batch, EveryInstructionSetFliesAsThePlantAndToTheSameBits) {
  const auto v = omnimorph();
  Random random(4);
  std::vector<physics::Model> models{{}};
  for (const physics::Effect* e : physics::builtin_effects())
    if (flies_in_lanes(*e)) models.push_back(with({{e->info().id, draw(*e, random)}}));
  const auto flown = [&] {
    Batch batch = Batch::create(v, models, {.plant = tumbling()}).value();
    batch.step(300);
    std::vector<double> out;
    for (std::size_t i = 0; i < models.size(); ++i) {
      const RigidState b = batch.body(i);
      for (const auto* number : {&b.p_WB, &b.v_WB_W, &b.w_WB_B})
        out.insert(out.end(), number->data(), number->data() + 3);
      out.insert(out.end(), b.q_WB.coeffs().data(), b.q_WB.coeffs().data() + 4);
    }
    return out;
  };
  const std::vector<double> best = flown();
  const int sets = test::for_each_instruction_set([&](const char* name) {
    EXPECT_EQ(lane_instruction_set(), name);
    EXPECT_LT(difference(v, models, {.plant = tumbling()}), 1e-12) << name;
    EXPECT_EQ(flown(), best) << name;
  });
  EXPECT_GE(sets, 1);
}

TEST(Batch, OtherVehiclesFlyToo) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  auto offset = omnimorph();
  offset.center_of_mass = Vec3(0.01, -0.02, 0.015);
  offset.inertia(0, 1) = offset.inertia(1, 0) = 1e-3;
  for (auto& r : offset.rotors) r.time_constant = 0;
  const auto cable = with({{"hung_cable", {0.3, 0.2, 5}}, {"constant_pull", {0.1, 0.2, 0.3}}});
  EXPECT_LT(difference(offset, {{}, cable}, {.plant = tumbling()}), 1e-12);
  auto small = vehicle::load_vehicle("crazyflie_brushless").value();
  PlantConfig config = tumbling();
  config.initial_alpha = 0;
  EXPECT_LT(difference(small, {{}, with({{"rotor_drag", {1e-7}}})}, {.plant = config}), 1e-12);
}

TEST(Batch, ATiltServoWithLagAndPlayIsThatOfThePlant) {
  auto v = omnimorph();
  v.tilt.time_constant = 0.08;
  v.tilt.backlash = to_radians(0.5);
  const std::vector<physics::Model> models{
      {}, with({{"tilt_servo_lag", {0.05, 0.01}}}), with({{"payload_mass", {0.1}}})};
  EXPECT_LT(difference(v, models, {.plant = tumbling()}), 1e-12);
  const auto alpha_after = [](const vehicle::Vehicle& vehicle) {
    Batch batch = Batch::create(vehicle, std::vector<physics::Model>(1), {}).value();
    constexpr double kWithinRate = 0.02;  // rad: nearer than the servo's rate limits
    EXPECT_TRUE(batch.set_command(0, std::vector<double>(8, 0.0), kWithinRate));
    for (int k = 0; k < 50; ++k) EXPECT_EQ(batch.step(), 1u);
    return batch.alpha(0);
  };
  EXPECT_LT(alpha_after(v), 0.6 * alpha_after(omnimorph())) << "the lanes fly what the file tells";
}

TEST(Batch, RotorsThatReverseAndLagDifferentlyDragAsInThePlant) {
  auto v = omnimorph();
  const std::vector<physics::Model> models{
      {}, with({{"rotor_drag", {1e-4}}}), with({{"axial_inflow", {2e-4}}, {"blade_flapping", {1e-5}}})};
  EXPECT_LT(difference(v, models, {.plant = tumbling()}, 100, 600), 1e-12);  // through zero, again and again
  for (std::size_t i = 0; i < v.rotors.size(); ++i)
    v.rotors[i].time_constant = 0.01 + 0.002 * static_cast<double>(i);
  EXPECT_LT(difference(v, models, {.plant = tumbling()}), 1e-12);
  EXPECT_LT(difference(v, models, {.plant = tumbling()}, 100, 600), 1e-12);
  v.rotors[3].bidirectional = false;
  EXPECT_LT(difference(v, models, {.plant = tumbling()}, 300, 600), 1e-12);
}

TEST(Batch, SpinsAsFastAsThePlant) {
  // so fast that the quaternion of RK4 is far from unit length
  PlantConfig config = tumbling();
  config.initial.w_WB_B = Vec3(20, -30, 400);
  EXPECT_LT(difference(omnimorph(), {{}, with({{"rotor_drag", {1e-5}}})}, {.plant = config}), 1e-12);
}

TEST(Batch, AReversingNeighbourChangesNoBits) {
  const auto v = omnimorph();
  const auto model = with({{"rotor_drag", {1e-4}}});
  const auto fly = [&](std::size_t count) {
    Batch b = Batch::create(v, std::vector<physics::Model>(count, model), {.plant = tumbling()}).value();
    for (int k = 0; k < 200; ++k) {
      EXPECT_TRUE(b.set_command(0, std::vector<double>(8, 600.0), 0.5));
      const double other = k % 50 < 25 ? 500 : -500;
      for (std::size_t i = 1; i < count; ++i)
        EXPECT_TRUE(b.set_command(i, std::vector<double>(8, other), 0.5 - 0.001 * k));
      b.step();
    }
    return b.body(0);
  };
  const RigidState alone = fly(1), together = fly(5);
  EXPECT_EQ(alone.p_WB, together.p_WB);
  EXPECT_EQ(alone.q_WB.coeffs(), together.q_WB.coeffs());
  EXPECT_EQ(alone.w_WB_B, together.w_WB_B);
}

TEST(Batch, AVehiclesBitsDependOnNoOther) {
  const auto v = omnimorph();
  Random random(5);
  std::vector<physics::Model> models;
  for (const physics::Effect* e : physics::builtin_effects())
    if (flies_in_lanes(*e)) models.push_back(with({{e->info().id, draw(*e, random)}}));
  const auto fly = [&](const std::vector<physics::Model>& which, std::size_t i, bool at_once) {
    Batch b = Batch::create(v, which, {.plant = tumbling()}).value();
    EXPECT_TRUE(b.set_command(i, std::vector<double>{600, 700, 500, 650, 620, 710, 480, 590}, 0.5));
    if (at_once)
      b.step(300);
    else
      for (int k = 0; k < 300; ++k) b.step();
    return b.body(i);
  };
  for (std::size_t i = 0; i < models.size(); ++i) {
    const RigidState alone = fly({models[i]}, 0, false), together = fly(models, i, true);
    EXPECT_EQ(alone.p_WB, together.p_WB) << models[i].effects[0].effect->info().id;
    EXPECT_EQ(alone.q_WB.coeffs(), together.q_WB.coeffs());
    EXPECT_EQ(alone.w_WB_B, together.w_WB_B);
  }
}

TEST(Batch, WhatLanesDoNotKnowFliesAsAPlantOrIsRefusedByName) {
  const auto v = omnimorph();
  physics::Model strange;
  for (const physics::Effect* e : physics::builtin_effects())
    if (!flies_in_lanes(*e) && strange.effects.empty()) {
      Random random(1);
      strange.effects.push_back({e, draw(*e, random)});
    }
  if (strange.effects.empty())  // every effect of the library is in lanes: two cables are not
    strange = with({{"hung_cable", {0.1, 0, 5}}, {"hung_cable", {0.1, 0.5, 5}}});
  BatchConfig config{.plant = tumbling()};
  const std::vector<physics::Model> models{{}, strange};
  Batch batch = Batch::create(v, models, config).value();
  EXPECT_EQ(batch.in_lanes(), 1u);
  EXPECT_LT(difference(v, models, config), 1e-12);
  config.unsupported = BatchConfig::Unsupported::refuse;
  const auto refused = Batch::create(v, models, config);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find(strange.effects[0].effect->info().id), std::string::npos);
  EXPECT_NE(refused.error().text().find("vehicle 1"), std::string::npos);
  config.plant.integrator = Integrator::semi_implicit_euler;
  EXPECT_FALSE(Batch::create(v, models, config));
}

TEST(Batch, ALostVehicleStaysAndTheOthersFlyOn) {
  const auto v = omnimorph();
  BatchConfig config;
  config.initial.resize(3);
  config.initial[1].v_WB_W = Vec3(990, 0, 0);
  config.plant.environment.gravity = 0;
  Batch b = Batch::create(v, std::vector<physics::Model>(3), config).value();
  EXPECT_EQ(b.step(1000), 3u);
  EXPECT_EQ(b.step(1000), 2u);
  EXPECT_TRUE(b.lost(1));
  EXPECT_FALSE(b.lost(0) || b.lost(2));
  EXPECT_LE(b.body(1).p_WB.x(), 1000);
  EXPECT_GT(b.body(1).p_WB.x(), 998);
  config.initial.resize(2);
  EXPECT_FALSE(Batch::create(v, std::vector<physics::Model>(3), config));
  EXPECT_FALSE(Batch::create(v, std::vector<physics::Model>{with({{"payload_mass", {-2}}})}, {}));
  EXPECT_FALSE(b.set_command(0, std::vector<double>(8, std::nan("")), 0));
  EXPECT_FALSE(b.set_command(0, std::vector<double>(7, 1.0), 0));
}

TEST(Batch, ResetsToWhereItBegan) {
  const std::vector<physics::Model> models{{}, with({{"transport_delay", {0.01, 0.02}}})};
  Batch b = Batch::create(omnimorph(), models, {.plant = tumbling()}).value();
  const auto fly = [&b] {
    for (std::size_t i = 0; i < 2; ++i) EXPECT_TRUE(b.set_command(i, std::vector<double>(8, 650.0), 0.5));
    b.step(200);
    return b.body(1).p_WB;
  };
  const Vec3 first = fly();
  b.reset();
  EXPECT_EQ(b.time(), 0);
  EXPECT_EQ(b.body(1).p_WB, tumbling().initial.p_WB);
  EXPECT_EQ(fly(), first);
}

TEST(Batch, StepsWithoutAllocation) {
  const auto v = omnimorph();
  physics::Model all;
  for (const physics::Effect* e : physics::builtin_effects()) {
    Random random(1);
    if (flies_in_lanes(*e)) all.effects.push_back({e, draw(*e, random)});
  }
  Batch batch = Batch::create(v, std::vector<physics::Model>(11, all), {.plant = tumbling()}).value();
  Plant plant = Plant::create(v, all, tumbling()).value();
  const std::vector<double> speed(8, 600.0);
  batch.step();
  (void)plant.step();
  const long before = counted::allocations;
  for (int k = 0; k < 50; ++k) {
    batch.set_command(3, speed, 0.3);
    batch.step();
    (void)batch.specific_force(3);
    plant.set_command(speed, 0.3);
    if (!plant.step()) break;
  }
  if (counted::works) {
    EXPECT_EQ(counted::allocations - before, 0);
    delete new int(1);
    free(malloc(1));
    EXPECT_GT(counted::allocations, before);  // the counter counts
  }
}

}  // namespace
}  // namespace omniflight::simulation
