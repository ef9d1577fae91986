#include "omniflight_allocation/feasible_set.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "hover_by_qp.hpp"
#include "omniflight_core/random.hpp"
#include "omnimorph.hpp"

namespace omniflight::allocation {
namespace {

const double kIsotropic = std::acos(1.0 / std::sqrt(3.0));  // 54.7356 deg

// Chapter 5 of the thesis; its absolute figures agree on a largest thrust of 5.95 N.
TEST(Design, PublishedForceFigures) {
  const auto r = design(omnimorph(1.595), {to_radians(30), to_radians(45), kIsotropic}, 5.95);
  ASSERT_TRUE(r) << r.error().text();
  const double vertex[] = {0.408, 0.707, 0.866}, surface[] = {0.289, 0.500, 0.707};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(r->points[i].force_at_zero_torque.uniformity_vertex, vertex[i], 5e-4);
    EXPECT_NEAR(r->points[i].force_at_zero_torque.uniformity_surface, surface[i], 5e-4);
    EXPECT_EQ(r->points[i].rank, 6);
  }
  EXPECT_NEAR(r->points[2].force_at_zero_torque.d_min_surface, 19.43, 5e-3);
  EXPECT_NEAR(r->points[0].mass_limit, 1.21305, 5e-6);
  ASSERT_TRUE(r->omnidirectional_tilt);
  EXPECT_NEAR(to_degrees(*r->omnidirectional_tilt), 41.10, 5e-3);
}

TEST(Design, TheShippedVehicleIsTheOneOfTheFigures) {
  const auto v = vehicle::load_vehicle(OMNIFLIGHT_SOURCE_ROOT "/configs/vehicles/omnimorph/omnimorph.yaml");
  ASSERT_TRUE(v) << v.error().text();
  const DesignResult r = design(*v, {to_radians(30), kIsotropic}, 5.95, 1.595).value();
  EXPECT_NEAR(r.points[0].mass_limit, 1.21305, 5e-6);
  EXPECT_NEAR(r.points[1].force_at_zero_torque.d_min_surface, 19.43, 5e-3);
  EXPECT_NEAR(to_degrees(r.omnidirectional_tilt.value()), 41.10, 5e-3);
  for (int deg = 0; deg <= 60; ++deg) {  // the spin directions must not cost yaw on the way
    EXPECT_EQ(WrenchSet::create(*v, to_radians(deg)).value().rank(), deg == 0 ? 4 : 6) << deg;
  }
}

TEST(Design, ForceBodyHasItsClosedForm) {
  for (const double deg : {10.0, 30.0, 45.0, to_degrees(kIsotropic), 60.0}) {
    const double a = to_radians(deg), f = 6.25, s = std::sin(a), c = std::cos(a);
    const auto set = WrenchSet::create(omnimorph(), a);
    ASSERT_TRUE(set);
    const Polytope body = set->force_at_torque(Vec3::Zero());
    std::vector<Vec3> expected;
    for (const double p : {-1.0, 1.0}) {
      expected.emplace_back(0, 0, p * 8 * c * f);
      for (const double q : {-1.0, 1.0}) {
        expected.emplace_back(p * 4 * s * f, q * 4 * s * f, 0);
        expected.emplace_back(p * 4 * s * f, 0, q * 4 * c * f);
        expected.emplace_back(0, p * 4 * s * f, q * 4 * c * f);
      }
    }
    ASSERT_EQ(body.vertices.size(), expected.size()) << deg;
    for (const Vec3& e : expected) {
      double nearest = HUGE_VAL;
      for (const Vec3& v : body.vertices) nearest = std::min(nearest, (v - e).norm());
      EXPECT_LT(nearest, 1e-7) << deg;
    }
    EXPECT_NEAR(set->omnidirectional_force(), measure(body).d_min_surface, 1e-9);
  }
}

/// Closed, outward and convex: F = 2 V - 4 (Euler), no vertex outside a triangle's plane, the volume of the
/// body.
TEST(Design, TrianglesAreTheSurface) {
  std::vector<HalfSpace> sides;
  for (int i = 0; i < 3; ++i)
    for (const double sign : {-1.0, 1.0}) sides.push_back({sign * Vec3::Unit(i), 1.0});
  const Polytope cube = intersect({}, sides, 4, 1e-9);
  const auto of_cube = triangles(cube);
  ASSERT_EQ(of_cube.size(), 12u);
  double volume = 0;
  for (const auto& [a, b, c] : of_cube)
    volume += cube.vertices[static_cast<std::size_t>(a)].dot(cube.vertices[static_cast<std::size_t>(b)].cross(
                  cube.vertices[static_cast<std::size_t>(c)])) /
              6;
  EXPECT_NEAR(volume, 8, 1e-12);

  const auto point = design(omnimorph(), {to_radians(40)})->points[0];
  for (const auto& [vertices, surface] : {std::pair(point.force_vertices, point.force_triangles),
                                          {point.torque_vertices, point.torque_triangles}}) {
    EXPECT_EQ(surface.size(), 2 * vertices.size() - 4);
    for (const auto& [a, b, c] : surface) {
      const Vec3 p = vertices[static_cast<std::size_t>(a)];
      const Vec3 n =
          (vertices[static_cast<std::size_t>(b)] - p).cross(vertices[static_cast<std::size_t>(c)] - p);
      for (const Vec3& v : vertices) EXPECT_LE(n.dot(v - p), 1e-6 * n.norm());
    }
  }
  const auto flat = design(omnimorph(), {0.0})->points[0];
  EXPECT_TRUE(flat.force_triangles.empty()) << "along one axis only";
}

TEST(Design, TorqueFigures) {
  vehicle::Vehicle v = omnimorph();
  for (auto& rotor : v.rotors) rotor.drag_ratio = 0;
  const auto r = design(v, {to_radians(30), to_radians(45), kIsotropic}, 5.95, 1.595).value();
  const double vertex[] = {0.437, 0.632, 0.765}, surface[] = {0.401, 0.535, 0.608};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(r.points[i].torque_at_zero_force.uniformity_vertex, vertex[i], 1e-3);
    EXPECT_NEAR(r.points[i].torque_at_zero_force.uniformity_surface, surface[i], 1e-3);
  }
  EXPECT_EQ(r.points[0].torque_at_any_attitude.dimension, -1);  // 1.595 kg is not omnidirectional at 30 deg
  EXPECT_NEAR(r.points[1].torque_at_any_attitude.d_min_surface, 0.33, 0.01);
  EXPECT_NEAR(r.points[2].torque_at_any_attitude.d_min_surface, 0.75, 0.01);
}

// Every half space and every vertex against the definition: u within its limits, the rest exactly zero.
TEST(Design, SlicesHoldExactlyWhatTheRotorsCanGive) {
  Random rng(21);
  vehicle::Vehicle v = omnimorph();
  v.center_of_mass = Vec3(0.01, -0.02, 0.015);
  for (auto& rotor : v.rotors) rotor.max_thrust = rng.uniform(4, 7);
  v.rotors[3].bidirectional = false;
  const double alpha = to_radians(37);
  const auto set = WrenchSet::create(v, alpha).value();
  const Polytope body = set.force_at_torque(Vec3::Zero());
  ASSERT_EQ(body.dimension, 3);
  vehicle::Vehicle probe = v;  // a body of mass 1/g in an attitude asks for a unit force in a direction
  for (const Vec3& vertex : body.vertices) {
    const Vec3 up = vertex.normalized();
    const Quat q_WB = Quat::FromTwoVectors(up, Vec3::UnitZ());
    probe.mass = vertex.norm() / kGravity * 0.9999;
    const bool holds_zero = measure(body).holds_zero;
    EXPECT_TRUE(!holds_zero || hover_feasible(probe, q_WB, alpha));
    probe.mass = vertex.norm() / kGravity * 1.0001;
    EXPECT_FALSE(hover_feasible(probe, q_WB, alpha));
  }
  for (int i = 0; i < 300; ++i) {
    const Vec3 d = Vec3(rng.normal(), rng.normal(), rng.normal()).normalized();
    double reach = HUGE_VAL;
    for (const HalfSpace& h : body.facets)
      if (h.normal.dot(d) > 0) reach = std::min(reach, h.offset / h.normal.dot(d));
    const Quat q_WB = Quat::FromTwoVectors(d, Vec3::UnitZ());
    probe.mass = reach / kGravity * 0.9999;
    ASSERT_TRUE(hover_feasible(probe, q_WB, alpha));
    probe.mass = reach / kGravity * 1.0001;
    ASSERT_FALSE(hover_feasible(probe, q_WB, alpha));
  }
}

TEST(Design, UntiltedOmniMorphPushesOnlyAlongItsAxis) {
  const auto r = design(omnimorph(), {0.0}).value();
  EXPECT_EQ(r.points[0].rank, 4);
  EXPECT_EQ(r.points[0].force_at_zero_torque.dimension, 1);
  EXPECT_NEAR(r.points[0].force_at_zero_torque.d_max, 50.0, 1e-9);
  EXPECT_EQ(r.points[0].force_at_zero_torque.uniformity_vertex, 0.0);
  EXPECT_EQ(r.points[0].mass_limit, 0.0);
}

TEST(Design, PlanarQuadrotor) {
  vehicle::Vehicle v;
  v.mass = 0.04;
  v.inertia = Vec3(2e-5, 2e-5, 3e-5).asDiagonal();
  for (int i = 0; i < 4; ++i) {
    vehicle::Rotor r;
    const double angle = kPi / 4 + i * kPi / 2;
    r.p_BR = 0.05 * Vec3(std::cos(angle), std::sin(angle), 0);
    r.spin = i % 2 == 0 ? 1 : -1;
    r.thrust_coefficient = 1e-8;
    r.drag_ratio = 0.006;
    r.max_thrust = 0.2;
    v.rotors.push_back(r);
  }
  const auto r = design(v, {0.0}).value();
  EXPECT_EQ(r.points[0].force_at_zero_torque.dimension, 1);
  EXPECT_NEAR(r.points[0].force_at_zero_torque.d_max, 0.8, 1e-12);
  EXPECT_FALSE(r.omnidirectional_tilt);
  // at 0.4 N every rotor gives 0.1 N: four times 0.1 N at 0.006 m of yaw torque to spare
  const Polytope torque = WrenchSet::create(v, 0).value().torque_at_force(Vec3(0, 0, 0.4));
  double yaw = 0;
  for (const Vec3& vertex : torque.vertices) yaw = std::max(yaw, vertex.z());
  EXPECT_NEAR(yaw, 4 * 0.1 * 0.006, 1e-12);
  EXPECT_TRUE(hover_feasible(v, Quat::Identity(), 0, 0.4));
  EXPECT_TRUE(WrenchSet::create(v, 0).value().force_at_torque(Vec3(1, 0, 0)).empty());
}

TEST(Hover, FollowsTheMassLimitOfTheDesigner) {
  Random rng(5);
  vehicle::Vehicle v = omnimorph();
  for (auto& rotor : v.rotors) rotor.max_thrust = 5.95;
  const double alpha = to_radians(30);
  v.mass = 1.2130 * 0.8;
  for (int i = 0; i < 300; ++i) {
    const Quat q = exp_rotation(2.0 * Vec3(rng.normal(), rng.normal(), rng.normal()));
    ASSERT_TRUE(hover_feasible(v, q, alpha, 0.2));
  }
  v.mass = 1.2131;
  EXPECT_TRUE(hover_feasible(v, Quat::Identity(), alpha));
  EXPECT_FALSE(hover_feasible(v, exp_rotation(Vec3(kPi / 2, 0, 0)), alpha));
  const auto u = hover_thrusts(v, Quat::Identity(), alpha, 0);
  ASSERT_TRUE(u);
  EXPECT_LT(
      (v.allocation_matrix(alpha) * *u - (Vec6() << 0, 0, v.mass * kGravity, 0, 0, 0).finished()).norm(),
      1e-4);
}

TEST(Design, RefusesWhatMakesNoSense) {
  const double nan = std::nan("");
  EXPECT_NE(design(omnimorph(), {to_radians(61)}).error().text().find("60.0"), std::string::npos);
  for (const double bad : {nan, -1.0, HUGE_VAL}) {
    EXPECT_FALSE(design(omnimorph(), {0.5}, bad));
    EXPECT_FALSE(design(omnimorph(), {0.5}, 0, bad));
  }
  EXPECT_FALSE(design(omnimorph(), {nan}));
  EXPECT_FALSE(RotorLoad::create(omnimorph(), nan));
  EXPECT_FALSE(RotorLoad::create(vehicle::Vehicle{}, 0.5));
  EXPECT_TRUE(std::isinf(RotorLoad::create(omnimorph(), 0.5)->hover_load(Quat(nan, 0, 0, 0))));
}

TEST(Design, WritesJson) {
  const nlohmann::json j = design(omnimorph(), {0.5}, 5.95).value();
  EXPECT_EQ(j.at("schema"), "omniflight.design/1");
  EXPECT_NEAR(j.at("points")[0].at("force_at_zero_torque").at("d_min_surface").get<double>(),
              4 * 5.95 * std::sin(0.5), 1e-9);
  EXPECT_EQ(j.at("points")[0].at("force_vertices_N").size(), 14u);
}

}  // namespace
}  // namespace omniflight::allocation
