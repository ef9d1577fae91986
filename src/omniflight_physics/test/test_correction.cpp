#include "omniflight_physics/correction.hpp"

#include <cstdio>
#include <fstream>

#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

Vec6 wrench(const Correction& c, const Situation& s) {
  const ActiveEffect e = as_effect(c);
  Wrench w;
  e.effect->add_wrench(s, e.theta.data(), w);
  return w.at(s);
}

int quantity(const std::string& name) {
  const auto all = quantities();
  for (std::size_t k = 0; k < all.size(); ++k)
    if (name == all[k].name) return static_cast<int>(k);
  ADD_FAILURE() << name;
  return 0;
}

/// One of every form.
std::vector<Correction> examples() {
  using F = Feature::Form;
  return {{.channel = 1,
           .world = false,
           .feature = {.first = quantity("body_z_speed"), .second = quantity("distance_from_middle")},
           .coefficient = -1.93,
           .mean = 0.125,
           .low = -4,
           .high = 4},
          {.channel = 5, .feature = {.first = quantity("yaw_rate")}, .coefficient = -0.01},
          {.channel = 2,
           .world = true,
           .feature = {.form = F::bump, .center = {0.1, -0.2, 1.1}, .length = 0.25},
           .coefficient = 0.7,
           .mean = 0.3},
          {.channel = 0,
           .world = true,
           .feature = {.form = F::wave, .length = 0.31, .direction = 0.6, .phase = 1.57},
           .coefficient = 0.2},
          {.channel = 0,
           .world = true,
           .feature = {.form = F::pulse, .frequency = 1.3, .phase = -0.4},
           .coefficient = 0.2}};
}

TEST(Correction, IsWhatItSays) {
  const std::vector<Correction> all = examples();
  for (const Situation& s : six_states()) {
    const Vec3 p = s.body.p_WB, v = s.body.q_WB.conjugate() * s.body.v_WB_W;
    EXPECT_NEAR(wrench(all[0], s)[1], -1.93 * (v.z() * std::hypot(p.x(), p.y()) - 0.125), 1e-12);
    EXPECT_NEAR(wrench(all[1], s)[5], -0.01 * s.body.w_WB_B.z(), 1e-15);
    const double bump = std::exp(-0.5 * (p - Vec3(0.1, -0.2, 1.1)).squaredNorm() / 0.0625);
    const Vec3 in_world = s.body.q_WB * Vec3(wrench(all[2], s).head<3>());
    EXPECT_LT((in_world - Vec3(0, 0, 0.7 * (bump - 0.3))).norm(), 1e-12);
    const double along = std::cos(0.6) * p.x() + std::sin(0.6) * p.y();
    EXPECT_NEAR((s.body.q_WB * Vec3(wrench(all[3], s).head<3>())).x(),
                0.2 * std::cos(2 * kPi * along / 0.31 - 1.57), 1e-12);
    EXPECT_NEAR((s.body.q_WB * Vec3(wrench(all[4], s).head<3>())).x(),
                0.2 * std::cos(2 * kPi * 1.3 * s.t + 0.4), 1e-12);
  }
}

TEST(Correction, IsHeldWhereItWasSeen) {
  const Correction c{
      .channel = 2, .feature = {.first = quantity("height")}, .coefficient = 2, .low = 0.5, .high = 1.5};
  EXPECT_NEAR(wrench(c, hover(1.2))[2], 2.4, 1e-12);
  EXPECT_NEAR(wrench(c, hover(9.0))[2], 3.0, 1e-12);
  EXPECT_NEAR(wrench(c, hover(0.1))[2], 1.0, 1e-12);
}

TEST(Correction, OnlyTheCoefficientHasADerivative) {
  for (const Correction& c : examples())
    for (const Situation& s : six_states()) {
      const ActiveEffect e = as_effect(c);
      const int n = e.effect->parameter_count();
      Vec6 value;
      std::vector<double> jacobian(static_cast<std::size_t>(6 * n));
      e.effect->wrench_with_jacobian(s, e.theta.data(), value.data(), jacobian.data());
      const Eigen::Map<const Eigen::MatrixXd> J(jacobian.data(), 6, n);
      EXPECT_LT((value - wrench(c, s)).norm(), 1e-15);
      Correction more = c, less = c;
      more.coefficient += 1e-4;
      less.coefficient -= 1e-4;
      const Vec6 slope = (wrench(more, s) - wrench(less, s)) / 2e-4;
      EXPECT_LT((J.rowwise().sum() - slope).norm(), 1e-6);
    }
}

TEST(Correction, AModelFileHoldsItToTheLastDigit) {
  std::vector<ActiveEffect> effects{{find_effect("hung_cable"), {0.25, 0.42, 5.0}}};
  for (const Correction& c : examples()) effects.push_back(as_effect(c));
  const std::string path = ::testing::TempDir() + "/correction.yaml";
  const std::string text = model_yaml(effects, "test");
  std::ofstream(path) << text;
  const auto model = load_model(path);
  ASSERT_TRUE(model) << model.error().text() << "\n" << text;
  ASSERT_EQ(model->effects.size(), effects.size());
  for (std::size_t k = 0; k < effects.size(); ++k) {
    EXPECT_EQ(model->effects[k].effect, effects[k].effect);
    EXPECT_EQ(model->effects[k].theta, effects[k].theta) << k << "\n" << text;
  }
  std::remove(path.c_str());
}

TEST(Correction, IsNoHypothesis) {
  const ActiveEffect e = as_effect(examples()[0]);
  EXPECT_TRUE(is_correction(e));
  EXPECT_EQ(find_effect(e.effect->info().id), nullptr);
  EXPECT_FALSE(is_correction({find_effect("hung_cable"), {}}));
}

TEST(Correction, NonsenseIsRefusedWithFieldAndValue) {
  const std::string rest = ", coefficient: 1, mean: 0, from: 0, to: 1}";
  const std::pair<std::string, const char*> bad[] = {
      {"{channel: Fq, follows: [height]" + rest, "channel"},
      {"{channel: Fz, follows: [hight]" + rest, "height"},
      {"{channel: Fz, follows: [height, height, height]" + rest, "follows"},
      {"{channel: Fz, follows: []" + rest, "follows"},
      {"{channel: Mz, axes: world, follows: [height]" + rest, "axes"},
      {"{channel: Fz, near: {center: [0, 0, .nan], width: 1}" + rest, "center"},
      {"{channel: Fz, near: {center: [0, 0, 0], width: 0}" + rest, "width"},
      {"{channel: Fz, wave: {length: 1, direction: 9, phase: 0}" + rest, "direction"},
      {"{channel: Fz, pulse: {frequency: -1, phase: 0}" + rest, "frequency"},
      {"{channel: Fz, follows: [height], near: {center: [0, 0, 0], width: 1}" + rest, "follows"},
      {"{channel: Fz, follows: [height], coefficient: 1e9, mean: 0, from: 0, to: 1}", "coefficient"},
      {"{channel: Fz, follows: [height], coefficient: 1, mean: 0, from: 2, to: 1}", "from"}};
  const std::string path = ::testing::TempDir() + "/bad_correction.yaml";
  for (const auto& [item, named] : bad) {
    std::ofstream(path) << "schema: omniflight.model/1\neffects: []\ncorrections: [" << item << "]\n";
    const auto model = load_model(path);
    ASSERT_FALSE(model) << item;
    EXPECT_NE(model.error().text().find(named), std::string::npos) << item << "\n" << model.error().text();
  }
  std::remove(path.c_str());
}

}  // namespace
}  // namespace omniflight::physics::testing
