#include <gtest/gtest.h>

#include "omniflight_allocation/actuation.hpp"
#include "omnimorph.hpp"

namespace omniflight::allocation {
namespace {

using Kind = ActuationKind;

/// n rotors on a circle of 0.2 m, spins alternating, each leaning by `cant` [rad] about its own arm to
/// alternating sides.
vehicle::Vehicle ring(int n, double mass, double cant = 0) {
  vehicle::Vehicle v;
  v.name = "ring";
  v.mass = mass;
  v.inertia = Vec3(0.01, 0.01, 0.02).asDiagonal();
  for (int k = 0; k < n; ++k) {
    const double angle = (k + 0.5) * 2 * kPi / n;
    const Vec3 arm(std::cos(angle), std::sin(angle), 0);
    vehicle::Rotor r;
    r.p_BR = 0.2 * arm;
    r.axis_B = Eigen::AngleAxisd(k % 2 == 0 ? cant : -cant, arm) * Vec3::UnitZ();
    r.spin = k % 2 == 0 ? 1 : -1;
    r.thrust_coefficient = 5e-6;
    r.drag_ratio = 0.016;
    r.max_thrust = 6.0;
    v.rotors.push_back(r);
  }
  return v;
}

TEST(ActuationClass, OfAQuadrotorIsUnderactuatedAlongItsThrustAxis) {
  const auto c = classify_actuation(ring(4, 1.2)).value();
  ASSERT_EQ(c.tilts.size(), 1u);
  const ActuationAtTilt& a = c.tilts.front();
  EXPECT_EQ(a.kind, Kind::underactuated);
  EXPECT_EQ(a.rank, 4);
  EXPECT_EQ(a.force_rank, 1);
  EXPECT_LT((a.thrust_axis_B - Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(a.thrust_to_weight, 24 / (1.2 * kGravity), 1e-9);
  // each rotor carries m g / 4 of [0, 6] N: |u - 3| / 3
  EXPECT_NEAR(a.hover_load, std::abs(1.2 * kGravity / 4 - 3) / 3, 1e-9);
  EXPECT_EQ(a.lean, 0.0);
  EXPECT_TRUE(c.singular.empty());
  EXPECT_EQ(c.words(), "underactuated (thrust along 0.00 0.00 1.00)");
}

TEST(ActuationClass, DoesNotDependOnTheBodyFrame) {
  const Quat q = exp_rotation(Vec3(0.4, -1.1, 0.3));
  for (const double cant : {0.0, 0.5}) {
    const auto v = ring(6, 2.3, cant);
    auto turned = v;
    for (vehicle::Rotor& r : turned.rotors) r.p_BR = q * r.p_BR, r.axis_B = q * r.axis_B;
    turned.inertia = q.toRotationMatrix() * v.inertia * q.toRotationMatrix().transpose();
    const auto a = actuation_at(v, 0).value(), b = actuation_at(turned, 0).value();
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.rank, b.rank);
    EXPECT_NEAR(a.thrust_to_weight, b.thrust_to_weight, 1e-6);
    EXPECT_NEAR(a.lean, b.lean, cant > 0 ? to_radians(1) : 1e-9);  // azimuths are sampled
    EXPECT_LT((q * a.thrust_axis_B - b.thrust_axis_B).norm(), 1e-6);
  }
}

TEST(ActuationClass, OfACantedHexarotorIsFullUpToALean) {
  EXPECT_EQ(actuation_at(ring(6, 2.3), 0)->kind, Kind::underactuated);
  const auto a = actuation_at(ring(6, 2.3, to_radians(30)), 0).value();
  EXPECT_EQ(a.kind, Kind::fully_actuated);
  EXPECT_EQ(a.rank, 6);
  EXPECT_NEAR(a.thrust_to_weight, 6 * 6 * std::cos(to_radians(30)) / (2.3 * kGravity), 1e-6);
  EXPECT_GT(a.lean, to_radians(5));
  EXPECT_LT(a.lean, to_radians(30));
  // a centre of mass beside the middle changes what is left, not the class
  auto off = ring(6, 2.3, to_radians(30));
  off.center_of_mass = Vec3(0.02, 0, 0);
  const auto b = actuation_at(off, 0).value();
  EXPECT_EQ(b.kind, Kind::fully_actuated);
  EXPECT_LT(b.reserve(), a.reserve());
}

TEST(ActuationClass, SaysWhatCannotBeHeldOrTurned) {
  EXPECT_FALSE(actuation_at(ring(4, 3.0), 0)->hovers());
  EXPECT_NE(classify_actuation(ring(4, 3.0))->words().find("too heavy"), std::string::npos);
  const auto three = actuation_at(ring(3, 0.5), 0).value();  // a fixed trirotor has no yaw of its own
  EXPECT_EQ(three.kind, Kind::no_full_torque);
  EXPECT_EQ(three.rank, 3);
}

TEST(ActuationClass, OfOmniMorphGoesThroughAllKindsOverTheTilt) {
  const auto c = classify_actuation(omnimorph(1.595, 5.95)).value();
  EXPECT_EQ(c.tilts.size(), 61u);
  EXPECT_EQ(c.tilts[0].kind, Kind::underactuated);
  EXPECT_EQ(c.tilts[30].kind, Kind::fully_actuated);
  EXPECT_EQ(c.tilts[41].kind, Kind::fully_actuated);  // thesis: omnidirectional from about 42 deg
  EXPECT_EQ(c.tilts[42].kind, Kind::omnidirectional);
  EXPECT_DOUBLE_EQ(c.tilts[42].lean, kPi);
  auto one_by_one = omnimorph();
  one_by_one.tilt.kind = vehicle::TiltKind::individual;
  EXPECT_NE(classify_actuation(one_by_one)->words().find("at a common tilt"), std::string::npos);
  EXPECT_EQ(c.words().find("at a common tilt"), std::string::npos);
  for (std::size_t k = 1; k < c.tilts.size(); ++k)
    EXPECT_GE(c.tilts[k].lean, c.tilts[k - 1].lean - 1e-3) << k;
  ASSERT_EQ(c.singular.size(), 1u);
  EXPECT_EQ(c.singular[0].alpha, 0.0);
  EXPECT_EQ(c.singular[0].rank, 4);
}

/// Where the drag torque and the moment of the tilted thrusts about z cancel: drag_ratio = 0.125 m
/// tan(alpha).
TEST(ActuationClass, OfOmniMorphWithTheOtherSpinsLosesYawAtAnAngle) {
  auto v = omnimorph();
  for (vehicle::Rotor& r : v.rotors) r.spin = -r.spin;
  const auto c = classify_actuation(v).value();
  ASSERT_EQ(c.singular.size(), 2u);
  const SingularTilt& s = c.singular[1];
  EXPECT_NEAR(s.alpha, std::atan(0.0165 / 0.125), 1e-6);
  EXPECT_EQ(s.rank, 5);
  EXPECT_EQ(s.lost, "torque about z");
  EXPECT_EQ(actuation_at(v, s.alpha + 1e-13)->rank, 5);
  EXPECT_NE(c.words().find("7.52 deg rank 5, without torque about z"), std::string::npos) << c.words();
}

/// Four rotors without drag torque turn the body about z only by leaning about their arms.
TEST(ActuationClass, OfFourTiltingRotorsNamesTheTiltWithoutYaw) {
  auto v = ring(4, 1.2);
  v.tilt = {vehicle::TiltKind::common, to_radians(-10), to_radians(30), 1.0};
  for (std::size_t k = 0; k < 4; ++k) {
    vehicle::Rotor& r = v.rotors[k];
    r.drag_ratio = 0, r.tilts = true;
    r.tilt_axis_B = (k % 2 == 0 ? 1 : -1) * r.p_BR.normalized();
  }
  const auto c = classify_actuation(v).value();
  ASSERT_EQ(c.singular.size(), 1u);
  EXPECT_NEAR(c.singular[0].alpha, 0.0, 1e-8);
  EXPECT_EQ(c.singular[0].rank, 3);
  EXPECT_EQ(c.singular[0].lost, "torque about z");
  EXPECT_EQ(actuation_at(v, to_radians(20))->rank, 4);
}

/// The published criterion of seven rotors that turn one way (Tognon and Franchi, RA-L 3(3), 2018): equal
/// thrusts give no wrench, so that any wrench is reached with positive thrusts, and the matrix is well
/// conditioned.
TEST(ActuationClass, OfSevenRotorsThatTurnOneWayIsOmnidirectional) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  const auto v = vehicle::load_vehicle("o7_plus").value();
  ASSERT_EQ(v.rotor_count(), 7);
  Eigen::MatrixXd B = v.allocation_matrix(0);
  const double length = B.bottomRows<3>().norm() / std::sqrt(7.0);
  B.bottomRows<3>() /= length;
  EXPECT_LT(B.rowwise().sum().norm(), 1e-4) << "balanced, as far as six digits tell";
  const Eigen::VectorXd s = Eigen::JacobiSVD<Eigen::MatrixXd>(B).singularValues();
  EXPECT_LT(s[0] / s[5], 1.11);
  for (const vehicle::Rotor& r : v.rotors) EXPECT_FALSE(r.bidirectional);
  // every direction of force and torque is a positive combination: least-norm thrusts and a multiple of ones
  const Eigen::MatrixXd inverse = B.completeOrthogonalDecomposition().pseudoInverse();
  for (int k = 0; k < 12; ++k) {
    const Vec6 wrench = (k < 6 ? 1.0 : -1.0) * Vec6::Unit(k % 6);
    Eigen::VectorXd u = inverse * wrench;
    u.array() -= u.minCoeff();
    EXPECT_LT((B * u - wrench).norm(), 1e-4) << k;
  }
  const auto c = classify_actuation(v).value();
  EXPECT_EQ(c.words(), "omnidirectional");
  auto without_one = v;
  without_one.rotors.pop_back();
  EXPECT_NE(classify_actuation(without_one)->words(), "omnidirectional") << "seven are the fewest";
}

}  // namespace
}  // namespace omniflight::allocation
