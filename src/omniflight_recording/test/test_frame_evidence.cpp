// Axes by evidence: a sound flight is not blamed, each wrong convention is.
#include <gtest/gtest.h>

#include <functional>

#include "../src/frame_evidence.hpp"
#include "sample_ulog.hpp"

using namespace omniflight;
using namespace omniflight::recording;

namespace {

/// Twenty seconds of turning about all axes while moving along all of them.
Recording flight() {
  Recording r;
  const auto make = [&](const char* name, int width, double rate_hz,
                        const std::function<Eigen::VectorXd(double)>& f) {
    Signal& s = r.signals[name];
    s.name = name;
    const auto n = static_cast<Eigen::Index>(20 * rate_hz);
    s.values.resize(n, width);
    for (Eigen::Index i = 0; i < n; ++i) {
      s.t_s.push_back(static_cast<double>(i) / rate_hz);
      s.values.row(i) = f(s.t_s.back()).transpose();
    }
  };
  const auto q = [](double t) {
    return from_roll_pitch_yaw(Vec3(0.4 * std::sin(t), 0.3 * std::sin(1.7 * t), 0.8 * std::sin(0.6 * t)));
  };
  const auto p = [](double t) { return Vec3(std::sin(t), std::cos(0.7 * t), 1 + 0.5 * std::sin(1.3 * t)); };
  const auto v = [](double t) {
    return Vec3(std::cos(t), -0.7 * std::sin(0.7 * t), 0.65 * std::cos(1.3 * t));
  };
  make("est_attitude", 4, 100, [&](double t) {
    const Quat x = q(t);
    return Eigen::Vector4d(x.w(), x.x(), x.y(), x.z());
  });
  make("gyro", 3, 200, [&](double t) -> Eigen::VectorXd {
    return log_rotation(q(t - 1e-4).conjugate() * q(t + 1e-4)) / 2e-4;
  });
  make("acc", 3, 200, [&](double t) -> Eigen::VectorXd { return q(t).conjugate() * Vec3(0, 0, 9.81); });
  make("est_position", 3, 50, [&](double t) -> Eigen::VectorXd { return p(t); });
  make("est_velocity", 3, 50, [&](double t) -> Eigen::VectorXd { return v(t); });
  r.duration_s = 20;
  return r;
}

std::string said(Recording r) {
  note_frame_evidence(r);
  std::string out;
  for (const Note& n : r.notes) out += n.text + "\n";
  return out;
}

TEST(FrameEvidence, ASoundFlightIsNotBlamed) { EXPECT_EQ(said(flight()), ""); }

TEST(FrameEvidence, AGyroInFrdIsTold) {
  Recording r = flight();
  r.signals["gyro"].values.rightCols(2) *= -1;
  EXPECT_NE(said(r).find("gyro: y follows -y, z follows -z of the rate of est_attitude"), std::string::npos)
      << said(r);
}

TEST(FrameEvidence, AVelocityInNedIsTold) {
  Recording r = flight();
  Eigen::MatrixXd& v = r.signals["est_velocity"].values;
  v.col(0).swap(v.col(1));
  v.col(2) *= -1;
  EXPECT_NE(
      said(r).find("est_velocity: x follows y, y follows x, z follows -z of the derivative of est_position"),
      std::string::npos)
      << said(r);
}

TEST(FrameEvidence, AnAccelerometerUpsideDownIsTold) {
  Recording r = flight();
  r.signals["acc"].values.rightCols(2) *= -1;
  EXPECT_NE(said(r).find("acc and est_attitude are not in the same axes"), std::string::npos) << said(r);
}

TEST(FrameEvidence, AQuaternionInAnotherOrderIsTold) {
  Recording r = flight();
  Eigen::MatrixXd& q = r.signals["est_attitude"].values;
  const Eigen::MatrixXd w = q.col(0);
  q.leftCols(3) = q.rightCols(3).eval();
  q.col(3) = w;
  EXPECT_NE(said(r).find("of the rate of est_attitude; a map can say"), std::string::npos) << said(r);
}

TEST(FrameEvidence, WhatDoesNotMoveIsNotJudged) {
  Recording r = flight();
  r.signals["gyro"].values *= -0.01;
  EXPECT_EQ(said(r), "");
}

}  // namespace
