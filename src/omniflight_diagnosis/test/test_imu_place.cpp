// Inertial sensors that sit elsewhere, are scaled and turned, as far as it is told.
#include <cmath>
#include <string>

#include "../src/conditioning/imu_place.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

const Vec3 kPlace(0.06, -0.04, 0.05);

/// A nominal flight that sways by 45 deg, by an accelerometer that is perfect.
recording::Recording swaying(const vehicle::Vehicle& v) {
  test::Flown f;
  f.sway = 0.8;
  f.gyro_noise = 0.001;
  f.torque_noise_Nm = 0.002;
  return test::fly(v, {}, f);
}

/// The same accelerometer at kPlace: what turning adds is taken from the path, not from the gyro.
recording::Recording elsewhere(recording::Recording r) {
  test::Flown f;
  f.sway = 0.8;
  recording::Signal& acc = r.signals.at("acc");
  constexpr double h = 1e-3;
  const auto rate = [&](double t) {
    return Vec3(log_rotation(test::attitude(t - h, f).conjugate() * test::attitude(t + h, f)) / (2 * h));
  };
  for (Eigen::Index i = 0; i < acc.size(); ++i) {
    const double t = acc.t_s[static_cast<std::size_t>(i)];
    const Vec3 w = rate(t), dw = (rate(t + h) - rate(t - h)) / (2 * h);
    acc.values.row(i) += (dw.cross(kPlace) + w.cross(w.cross(kPlace))).transpose();
  }
  return r;
}

TEST(ImuPlace, ReadsAsAtTheOrigin) {
  const vehicle::Vehicle v = test::omnimorph();
  const recording::Recording origin = swaying(v), moved = elsewhere(origin);
  const auto back = at_origin(moved, kPlace);
  const Eigen::MatrixXd &a = origin.find("acc")->values, &b = moved.find("acc")->values,
                        &c = back.find("acc")->values;
  const Eigen::Index n = a.rows() - 4;
  const double away = (b - a).middleRows(2, n).norm(), left = (c - a).middleRows(2, n).norm();
  EXPECT_GT(away / std::sqrt(3.0 * static_cast<double>(n)), 0.1) << "m/s^2, or this test tells nothing";
  EXPECT_LT(left, 0.35 * away) << "noise of the gyro's differences is all that stays";
  EXPECT_EQ(at_origin(moved, Vec3::Zero()).find("acc")->values, b);
}

TEST(ImuPlace, WhereItIsToldNothingIsMissing) {
  const vehicle::Vehicle v = test::omnimorph();
  const auto r = elsewhere(swaying(v));
  Options o;
  o.rollouts = false;
  o.threads = 2;
  const auto untold = diagnose(std::span(&r, 1), {}, v, o);
  o.imu_position = kPlace;
  const auto told = diagnose(std::span(&r, 1), {}, v, o);
  ASSERT_TRUE(untold && told);
  EXPECT_EQ(told->verdict, Verdict::nothing_missing) << told->summary;
  for (const std::size_t c : {0u, 1u, 2u})
    EXPECT_LT(told->fit.in_sample[c].rms_before, 0.8 * untold->fit.in_sample[c].rms_before) << c;
}

// Diagnosis and check each put a recording in order first; moved twice it would be as far off on the other
// side.
TEST(ImuPlace, WithoutMotorsItIsTakenIntoAccountOnce) {
  const vehicle::Vehicle v = test::omnimorph();
  recording::Recording origin = swaying(v), r = elsewhere(origin);
  origin.signals.erase("rotor_speed");
  r.signals.erase("rotor_speed");
  Options o;
  // "a vehicle of 1.3 kg needs 13 N on average and 13.5 N at most" to move like this
  const auto most = [](const Result<Diagnosis>& d) {
    EXPECT_TRUE(d);
    const std::string words = " N on average and ";
    const std::size_t at = d ? d->summary.find(words) : std::string::npos;
    EXPECT_NE(at, std::string::npos);
    return at == std::string::npos ? 0.0 : std::stod(d->summary.substr(at + words.size()));
  };
  const double truth = most(diagnose(std::span(&origin, 1), {}, v, o)),
               untold = most(diagnose(std::span(&r, 1), {}, v, o));
  EXPECT_GT(std::abs(untold - truth), 0.3);
  o.imu_position = kPlace;
  EXPECT_NEAR(most(diagnose(std::span(&r, 1), {}, v, o)), truth, 0.1);
  EXPECT_NEAR(most(check(std::span(&r, 1), v, o)), truth, 0.1);
}

TEST(ImuPlace, ScaleAndAlignmentWithinWhatIsToldAreNoFinding) {
  const vehicle::Vehicle v = test::omnimorph();
  auto r = swaying(v);
  Eigen::MatrixXd& acc = r.signals.at("acc").values;
  const Vec3 scale(0.02, -0.015, 0.0), turn(0.015, -0.02, 0.02);
  for (Eigen::Index i = 0; i < acc.rows(); ++i) {
    const Vec3 f = acc.row(i).transpose();
    acc.row(i) += (scale.cwiseProduct(f) + turn.cross(f)).transpose();
  }
  Options o;
  o.rollouts = false;
  o.threads = 2;
  o.tolerance.accelerometer_lateral = 0.02;
  o.tolerance.accelerometer_vertical = 0.02;
  const auto untold = diagnose(std::span(&r, 1), {}, v, o);
  o.tolerance.accelerometer_scale = 0.02;
  o.tolerance.accelerometer_misalignment = 0.02;
  const auto told = diagnose(std::span(&r, 1), {}, v, o);
  ASSERT_TRUE(untold && told);
  EXPECT_EQ(told->verdict, Verdict::nothing_missing) << told->summary;
  double left_untold = 0, left_told = 0;
  for (const std::size_t c : {0u, 1u, 2u}) {
    left_untold += std::pow(untold->fit.in_sample[c].rms_after, 2);
    left_told += std::pow(told->fit.in_sample[c].rms_after, 2);
  }
  printf("left: %.4f N untold, %.4f N told\n", std::sqrt(left_untold), std::sqrt(left_told));
  EXPECT_LT(left_told, 0.9 * left_untold);
}

}  // namespace
}  // namespace omniflight::diagnosis
