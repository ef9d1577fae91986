// The aerodynamic effects that were there first, against published constants and laws.
#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

/// AscTec Hummingbird as RotorPy publishes it (hummingbird_params.py): four rotors of 0.10 m radius.
vehicle::Vehicle hummingbird() {
  vehicle::Vehicle v;
  v.name = "hummingbird";
  v.mass = 0.5;
  v.inertia = Vec3(3.65e-3, 3.68e-3, 7.03e-3).asDiagonal();
  const double d = 0.17 * std::sqrt(0.5);
  for (int i = 0; i < 4; ++i) {
    vehicle::Rotor r;
    r.p_BR = Vec3(i < 2 ? d : -d, i == 0 || i == 3 ? d : -d, 0);
    r.spin = i % 2 ? -1 : 1;
    r.thrust_coefficient = 5.57e-6;
    r.drag_ratio = 1.36e-7 / 5.57e-6;
    r.max_thrust = 12;
    r.radius = 0.10;
    v.rotors.push_back(r);
  }
  return v;
}

Situation flying(const Vec3& velocity_W, double speed = 470.0) {
  RigidState body;
  body.v_WB_W = velocity_W;
  return situation(hummingbird(), body, 0.0, std::vector<double>(4, speed));
}

TEST(PublishedAerodynamics, RotorDragIsRotorPysHForce) {
  // -Omega diag(k_d, k_d, k_z) v at each hub, k_d = 1.19e-4 and k_z = 2.32e-4 kg/rad
  const Situation s = flying({2.0, -1.0, 0.7});
  const Vec6 side = wrench_of("rotor_drag", s, {1.19e-4}), along = wrench_of("axial_inflow", s, {2.32e-4});
  EXPECT_LT((side.head<3>() - Vec3(-4 * 470 * 1.19e-4 * 2.0, 4 * 470 * 1.19e-4, 0)).norm(), 1e-12);
  EXPECT_LT((along.head<3>() - Vec3(0, 0, -4 * 470 * 2.32e-4 * 0.7)).norm(), 1e-12);
  // the order of magnitude is what a search starts from
  EXPECT_NEAR(find_effect("rotor_drag")->info().parameters[0].typical, 1.19e-4, 0.5 * 1.19e-4);
  EXPECT_NEAR(find_effect("axial_inflow")->info().parameters[0].typical, 2.32e-4, 0.2 * 2.32e-4);
}

TEST(PublishedAerodynamics, Px4sLossOfThrustWithSpeedIsTheSameInflowCoefficient) {
  // PX4's motor model: thrust * (1 - v/25), iris motor constant 8.54858e-6; hover of 1.5 kg
  const double hover_speed = std::sqrt(1.5 * kGravity / 4 / 8.54858e-6);
  const double kz = 8.54858e-6 * hover_speed / 25;
  EXPECT_NEAR(kz, 2.32e-4, 0.1 * 2.32e-4);
}

TEST(PublishedAerodynamics, Px4sRotorDragIsWithinTheBounds) {
  const auto& p = find_effect("rotor_drag")->info().parameters[0];
  for (const double k : {1.75e-4, 1.19e-4, 8.06428e-5}) {  // iris, Hummingbird, RotorS
    EXPECT_GT(k, p.lower);
    EXPECT_LT(k, p.upper);
  }
}

TEST(PublishedAerodynamics, FlappingMomentTipsTheNoseUpWhenFlyingForward) {
  // body axes forward, left, up: the nose rises about -y, k_flap Omega (v x e3) at each hub
  const Vec6 w = wrench_of("blade_flapping", flying({3.0, 0, 0}), {1e-6});
  EXPECT_LT((w.tail<3>() - Vec3(0, -4 * 1e-6 * 470 * 3.0, 0)).norm(), 1e-15);
  EXPECT_EQ(w.head<3>().norm(), 0.0);
}

TEST(PublishedAerodynamics, ParasiticDragIsRotorPysAtItsArea) {
  // c_D = 0.5e-2 N/(m/s)^2 is an area of 2 c_D / rho
  const Vec6 w = wrench_of("parasitic_drag", flying({4.0, 0, 0}), {2 * 0.5e-2 / 1.2});
  EXPECT_NEAR(w[0], -0.5e-2 * 16, 1e-12);
  const double typical = find_effect("parasitic_drag")->info().parameters[0].typical;
  EXPECT_NEAR(0.5 * 1.2 * typical, 0.5e-2, 0.25e-2);
}

TEST(PublishedAerodynamics, WindIsDragOfTheAirspeedLessDragOfTheSpeed) {
  for (const Situation& s : six_states()) {
    const Vec3 w(0.8, -0.4, 0), v = s.body.v_WB_W, air = w - v;
    const Vec3 f = 0.5 * 1.2 * 0.03 * (air.norm() * air + v.norm() * v);
    const Vec6 got = wrench_of("wind", s, {0.8, -0.4, 0.03});
    EXPECT_LT((got.head<3>() - s.R_WB.transpose() * f).norm(), 1e-9);
  }
  // at rest it blows the vehicle along
  EXPECT_NEAR(wrench_of("wind", hover(1.0), {2.0, 0, 0.05})[0], 0.5 * 1.2 * 0.05 * 4, 1e-6);
}

TEST(GroundEffect, IsCheesemanAndBennett) {
  // T/T_inf = 1/(1 - (R/4z)^2): 16/15 one radius above the floor, 4/3 at half a radius, 1.2 % at 2.3 radii
  const double R = 0.1016;
  const auto ratio = [&](double heights) {
    vehicle::Vehicle v = cube();
    for (auto& r : v.rotors) r.p_BR.z() = 0;
    RigidState body;
    body.p_WB.z() = heights * R;
    const Situation s = situation(v, body, 0.0, std::vector<double>(8, 754.0));
    return 1 + wrench_of("ground_effect", s, {1.0})[2] / rotor_wrench(s)[2];
  };
  EXPECT_NEAR(ratio(1.0), 16.0 / 15.0, 1e-12);
  EXPECT_NEAR(ratio(0.5), 4.0 / 3.0, 1e-12);
  EXPECT_NEAR(ratio(2.3), 1.012, 5e-4);
  EXPECT_LT(ratio(10), 1.001);
}

TEST(GroundEffect, IsTheHandFormulaInEveryFrameAndNeedsAWashThatGoesDown) {
  for (Situation s : six_states()) {
    s.body.p_WB.z() -= 0.7;
    Vec6 expected = Vec6::Zero();
    for (const RotorSituation& r : s.all_rotors()) {
      const double down = (s.R_WB * r.n_B).z() * (r.thrust < 0 ? -1 : 1);
      const double h = std::max((s.body.p_WB + s.R_WB * r.p_BR).z(), 0.05 * r.radius);
      const double x = std::min(0.75, 2.5 * std::pow(r.radius / (4 * h), 2));
      expected += at_hub(r, r.thrust * std::max(0.0, down) * x / (1 - x) * r.n_B);
    }
    EXPECT_LT((wrench_of("ground_effect", s, {2.5}) - expected).norm(), 1e-12);
  }
  RigidState upside_down;
  upside_down.p_WB.z() = 0.3;
  upside_down.q_WB = exp_rotation(Vec3(kPi, 0, 0));
  EXPECT_EQ(
      wrench_of("ground_effect", situation(cube(), upside_down, 0, std::vector<double>(8, 700.0)), {1.0})
          .norm(),
      0.0);
}

}  // namespace
}  // namespace omniflight::physics::testing
