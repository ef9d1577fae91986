// Laws that hold for every effect of the library, and hand formulas for single ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <set>

#include "omniflight_core/random.hpp"
#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {
namespace {

vehicle::Vehicle cube() {
  vehicle::Vehicle v;
  v.name = "cube";
  v.mass = 1.3;
  v.inertia = Vec3(0.012, 0.013, 0.014).asDiagonal();
  for (int i = 0; i < 8; ++i) {
    vehicle::Rotor r;
    r.p_BR = 0.125 * Vec3(i & 1 ? -1 : 1, i & 2 ? -1 : 1, i & 4 ? -1 : 1);
    r.tilts = true;
    r.tilt_axis_B = i % 2 ? Vec3::UnitX() : Vec3::UnitY();
    r.spin = i < 4 ? 1 : -1;
    r.thrust_coefficient = 4.76e-6;
    r.drag_ratio = 0.0165;
    r.bidirectional = true;
    r.max_thrust = 6.25;
    r.radius = 0.1;
    r.board = i / 4;
    v.rotors.push_back(r);
  }
  return v;
}

Situation random_situation(std::uint64_t seed) {
  static const vehicle::Vehicle v = cube();
  Random rng(seed);
  const auto vec = [&](double s) { return Vec3(s * rng.normal(), s * rng.normal(), s * rng.normal()); };
  const RigidState body{Vec3(0, 0, 1.2) + vec(0.3), exp_rotation(vec(0.6)), vec(1.0), vec(1.5)};
  std::array<double, 8> speed, acceleration;
  for (auto& s : speed) s = 600 + 100 * rng.normal();
  for (auto& a : acceleration) a = 500 * rng.normal();
  Situation s;
  prepare(v, body, 0.5, speed, acceleration, {}, s);
  s.a_WB_B = vec(2.0);
  s.dw_WB_B = vec(5.0);
  return s;
}

std::vector<double> typical(const Effect& e) {
  std::vector<double> theta;
  for (const auto& p : e.info().parameters) theta.push_back(p.typical != 0 ? p.typical : 0.1 * p.upper);
  return theta;
}

TEST(Effects, WhatNeedsNoRotorSpeedDoesNotDependOnIt) {
  for (const Effect* e : builtin_effects()) {
    const auto& signals = e->info().signals;
    if (!e->acts_on_wrench() || std::find(signals.begin(), signals.end(), "rotor_speed") != signals.end())
      continue;
    Situation s = random_situation(11);
    s.neighbour_count = 1;
    s.neighbours[0].p_WN = s.body.p_WB + Vec3(0.05, 0, 0.6);
    Wrench turning, resting;
    e->add_wrench(s, typical(*e).data(), turning);
    for (auto& r : s.rotors) r.speed = r.acceleration = r.thrust = 0;
    e->add_wrench(s, typical(*e).data(), resting);
    EXPECT_EQ(turning.at(s), resting.at(s)) << e->info().id;
  }
}

TEST(Effects, IdsAreUniqueAndEveryFieldIsFilled) {
  std::set<std::string> ids;
  for (const Effect* e : builtin_effects()) {
    const EffectInfo& info = e->info();
    EXPECT_TRUE(ids.insert(info.id).second) << info.id;
    EXPECT_EQ(find_effect(info.id), e);
    for (const std::string* text :
         {&info.term, &info.equation, &info.latex, &info.source, &info.separated_by})
      EXPECT_FALSE(text->empty()) << info.id;
    EXPECT_FALSE(info.channels.empty()) << info.id;
    EXPECT_LE(e->parameter_count(), kMaxParameters);
    for (const auto& p : info.parameters) {
      EXPECT_LT(p.lower, p.upper) << info.id << " " << p.name;
      EXPECT_GE(p.typical, p.lower);
      EXPECT_LE(p.typical, p.upper);
    }
  }
  EXPECT_EQ(find_effect("magic"), nullptr);
}

TEST(Effects, NeutralParametersAreExactlyNothing) {
  for (const Effect* e : builtin_effects()) {
    if (!e->acts_on_wrench()) continue;
    std::vector<double> theta;
    for (const auto& p : e->info().parameters) theta.push_back(p.neutral);
    const Situation s = random_situation(3);
    Wrench w;
    e->add_wrench(s, theta.data(), w);
    EXPECT_EQ(w.at(s).norm(), 0.0) << e->info().id;
  }
}

/// States in which every effect acts and every parameter counts, in one at least: below a neighbour, with a
/// reversed rotor; nearly at rest; low, as in a rope that still carries it; high, at the end of a rope; and
/// higher than a cable is long.
std::vector<Situation> acting_states() {
  static const vehicle::Vehicle v = cube();
  std::vector<Situation> out;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Situation s = random_situation(seed);
    RigidState body = s.body;
    if (seed == 1) body.v_WB_W *= 0.02;
    if (seed == 2) body.p_WB.z() = 0.7;
    if (seed == 3) body.p_WB.z() = 2.4, body.v_WB_W.z() = 0.4;
    if (seed == 4) body.p_WB.z() = 6.0;
    std::array<double, 8> speed, acceleration;
    for (std::size_t i = 0; i < 8; ++i) {
      speed[i] = s.rotors[i].speed;
      acceleration[i] = s.rotors[i].acceleration;
    }
    speed[seed] = -500;
    prepare(v, body, s.alpha, speed, acceleration, {}, s);
    s.neighbour_count = 1;
    s.neighbours[0].p_WN = s.body.p_WB + Vec3(0.05, -0.1, 0.6);
    out.push_back(s);
  }
  return out;
}

TEST(Effects, DerivativeIsThatOfTheWrench) {
  for (const Effect* e : builtin_effects()) {
    if (!e->acts_on_wrench()) continue;
    const auto theta = typical(*e);
    double acts = 0;
    std::vector<double> counts(theta.size(), 0.0);
    for (const Situation& s : acting_states()) {
      std::array<double, 6> value;
      std::array<double, 6 * kMaxParameters> J;
      e->wrench_with_jacobian(s, theta.data(), value.data(), J.data());
      Wrench direct;
      e->add_wrench(s, theta.data(), direct);
      EXPECT_LT((direct.at(s) - Eigen::Map<const Vec6>(value.data())).norm(),
                1e-12 * (1 + direct.at(s).norm()))
          << e->info().id;
      acts = std::max(acts, direct.at(s).norm());
      for (std::size_t k = 0; k < theta.size(); ++k) {
        const double h = 1e-6 * std::max(1e-3, std::abs(theta[k]));
        auto up = theta, down = theta;
        up[k] += h;
        down[k] -= h;
        Wrench a, b;
        e->add_wrench(s, up.data(), a);
        e->add_wrench(s, down.data(), b);
        const Vec6 numeric = (a.at(s) - b.at(s)) / (2 * h);
        const Vec6 exact = Eigen::Map<const Vec6>(J.data() + 6 * k);
        EXPECT_LT((numeric - exact).norm(), 1e-6 * (1 + exact.norm())) << e->info().id << " " << k;
        counts[k] = std::max(counts[k], numeric.norm());
      }
    }
    EXPECT_GT(acts, 1e-3) << e->info().id << " is nothing in every state";
    for (std::size_t k = 0; k < theta.size(); ++k)
      EXPECT_GT(counts[k], 1e-3) << e->info().id << " does not know its " << e->info().parameters[k].name;
  }
}

TEST(Effects, TurningTheWorldAboutTheVerticalChangesNothingInTheBody) {
  // Body wrenches of effects without a world direction are the same after a yaw of the whole world.
  const vehicle::Vehicle v = cube();
  const std::set<std::string> directional{"wind",        "constant_pull", "lateral_stiffness", "taut_rope",
                                          "wall_effect", "cable_torsion", "catenary"};
  for (const Effect* e : builtin_effects()) {
    if (!e->acts_on_wrench() || directional.count(e->info().id)) continue;
    const Situation s = random_situation(5);
    const Quat yaw = exp_rotation(Vec3(0, 0, 1.1));
    RigidState turned = s.body;
    turned.p_WB = yaw * turned.p_WB;
    turned.q_WB = yaw * turned.q_WB;
    turned.v_WB_W = yaw * turned.v_WB_W;
    std::array<double, 8> speed, acceleration;
    for (std::size_t i = 0; i < 8; ++i) {
      speed[i] = s.rotors[i].speed;
      acceleration[i] = s.rotors[i].acceleration;
    }
    Situation s2;
    prepare(v, turned, s.alpha, speed, acceleration, {}, s2);
    s2.a_WB_B = s.a_WB_B;
    s2.dw_WB_B = s.dw_WB_B;
    const auto theta = typical(*e);
    Wrench a, b;
    e->add_wrench(s, theta.data(), a);
    e->add_wrench(s2, theta.data(), b);
    EXPECT_LT((a.at(s) - b.at(s2)).norm(), 1e-12) << e->info().id;
  }
}

TEST(Effects, DragTakesEnergy) {
  for (const char* id : {"rotor_drag", "parasitic_drag", "axial_inflow"}) {
    const Effect* e = find_effect(id);
    const auto theta = typical(*e);
    for (std::uint64_t seed = 1; seed < 40; ++seed) {
      const Situation s = random_situation(seed);
      Wrench w;
      e->add_wrench(s, theta.data(), w);
      EXPECT_LE(w.force_B.dot(s.v_WB_B) + w.torque_B.dot(s.body.w_WB_B), 0.0) << id;
    }
  }
}

TEST(Effects, HandFormulas) {
  const Situation s = random_situation(9);
  const double dm = 0.28;
  Wrench payload;
  find_effect("payload_mass")->add_wrench(s, &dm, payload);
  const Vec3 specific = s.a_WB_B - s.g_B;  // R^T (a + g e3)
  EXPECT_LT((payload.at(s).head<3>() + dm * specific).norm(), 1e-12);

  const double kd = 1.9e-6;
  Wrench drag;
  find_effect("rotor_drag")->add_wrench(s, &kd, drag);
  Vec3 f = Vec3::Zero();
  for (int i = 0; i < 8; ++i) {
    const auto& r = s.rotors[static_cast<std::size_t>(i)];
    const Vec3 vi = s.v_WB_B + s.body.w_WB_B.cross(r.p_BR);
    f -= std::abs(r.speed) * kd * (Mat3::Identity() - r.n_B * r.n_B.transpose()) * vi;
  }
  EXPECT_LT((drag.force_B - f).norm(), 1e-12);
}

TEST(Model, RoundTripAndRefusals) {
  const std::string path = ::testing::TempDir() + "/model.yaml";
  std::ofstream(path) << model_yaml({{find_effect("hung_cable"), {0.2512345678901, 0.42, 5.0}}}, "test");
  const auto model = load_model(path);
  ASSERT_TRUE(model) << model.error().text();
  ASSERT_EQ(model->effects.size(), 1u);
  EXPECT_EQ(model->effects[0].theta[0], 0.2512345678901);
  for (const char* body :
       {"effects: [{id: hung_cabel}]", "effects: [{id: hung_cable, parameters: {linear_density: 99}}]",
        "effects: [{id: hung_cable, parameters: {density: 1}}]", "effects: 3"}) {
    std::ofstream(path) << "schema: omniflight.model/1\n" << body << "\n";
    const auto bad = load_model(path);
    ASSERT_FALSE(bad) << body;
    EXPECT_EQ(bad.error().code, ErrorCode::bad_input);
  }
  std::remove(path.c_str());
}

}  // namespace
}  // namespace omniflight::physics
