// Whether the accelerometer or the markers are away from the origin of the body.
#include <gtest/gtest.h>

#include "../src/lever.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

test::Flown swaying() {
  test::Flown f;
  f.force_noise_N = 0;  // moves the accelerometer of this generator, not its position
  f.torque_noise_Nm = 0;
  f.sway = 0.3;
  return f;
}

Options told() {
  Options o;
  o.tolerance.accelerometer_lateral = o.tolerance.accelerometer_vertical = 0.005;
  o.tolerance.world_force = 0.0002;
  return o;
}

/// What kinematics and forces together say of r [m].
Kinematics judged(const recording::Recording& r, const vehicle::Vehicle& v) {
  auto k = judge_kinematics(r, told());
  auto flight = prepare_flight(r, v, told());
  EXPECT_TRUE(k && flight);
  if (!k || !flight) return {};
  attribute_lever(*flight, v, told(), *k);
  return *k;
}

TEST(Lever, AnAccelerometerOffTheOriginIsOne) {
  const vehicle::Vehicle v = test::omnimorph();
  const test::Flown f = swaying();
  recording::Recording r = test::fly(v, {}, f);
  const Vec3 r_BI(0.05, 0, -0.03);
  auto& acc = r.signals["acc"];
  const double h = 1e-3;
  const auto arm = [&](double t) { return Vec3(test::attitude(t, f) * r_BI); };
  for (Eigen::Index i = 0; i < acc.values.rows(); ++i) {
    const double t = acc.t_s[static_cast<std::size_t>(i)];
    const Vec3 a_W = (arm(t + h) - 2 * arm(t) + arm(t - h)) / (h * h);
    acc.values.row(i) += (test::attitude(t, f).conjugate() * a_W).transpose();
  }
  const Kinematics k = judged(r, v);
  EXPECT_TRUE(k.find("imu_lever_arm"));
  EXPECT_FALSE(k.find("mocap_offset"));
}

TEST(Lever, MarkersOffTheOriginAreNot) {
  const vehicle::Vehicle v = test::omnimorph();
  const test::Flown f = swaying();
  recording::Recording r = test::fly(v, {}, f);
  const Vec3 d(0.05, 0, -0.03);
  auto& position = r.signals["position"];
  for (Eigen::Index i = 0; i < position.values.rows(); ++i)
    position.values.row(i) += (test::attitude(position.t_s[static_cast<std::size_t>(i)], f) * d).transpose();
  const Kinematics k = judged(r, v);
  EXPECT_FALSE(k.find("imu_lever_arm"));
  const Kinematics::Part* part = k.find("mocap_offset");
  ASSERT_TRUE(part);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(part->value[c], d[c], 4 * part->se[c] + 1e-4) << c;
}

}  // namespace
}  // namespace omniflight::diagnosis
