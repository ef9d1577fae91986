// Regressors know nothing of the noise of their own sample, nor of what a disturbance did to the reference.
#include "../src/regression/predetermined.hpp"

#include <cstdio>
#include <cstdlib>

#include "../src/conditioning/reference_motion.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr int kLag = 12;
constexpr double kTurn = 100, kRate = 3, kSpeed = 200;  ///< rad/s^2, rad/s, rad/s: errors of one sample

/// A signal at 50 Hz over `duration` [s], `value` a row at a time [s].
template <class Value>
recording::Signal signal(const std::string& name, double duration, const Value& value) {
  recording::Signal out;
  out.name = name;
  const auto n = static_cast<Eigen::Index>(50 * duration);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = 0.02 * static_cast<double>(i);
    const Eigen::VectorXd row = value(t);
    if (i == 0) out.values.resize(n, row.size());
    out.t_s.push_back(t);
    out.values.row(i) = row.transpose();
  }
  return out;
}

Flight flown() {
  const test::Flown f;
  recording::Recording r = test::fly(test::omnimorph(), {}, f);
  r.signals["ref_position"] =
      signal("ref_position", f.duration_s, [&](double t) { return test::path(t, f); });
  auto flight = prepare_flight(r, test::omnimorph(), {});
  EXPECT_TRUE(flight);
  return std::move(*flight);
}

/// What errors of the sample `wrong` of the first segment do to the regressors of the sample `at`: the
/// largest of their shares in angular acceleration, rate and speed of a rotor.
double share(int wrong, int at, bool reference_alone) {
  const vehicle::Vehicle v = test::omnimorph();
  Mat6 inertia = Mat6::Identity();
  inertia.diagonal() << v.mass, v.mass, v.mass, v.inertia.diagonal();
  Flight flight = flown();
  const auto predict = [&] {
    return predetermined(flight, inertia, v.center_of_mass, 0.025, kLag,
                         reference_alone)[static_cast<std::size_t>(at)];
  };
  const physics::Situation before = predict();
  physics::Situation& x = flight.situation[static_cast<std::size_t>(flight.segments[0].begin + wrong)];
  x.dw_WB_B.x() += kTurn;
  x.body.w_WB_B.x() += kRate;
  x.rotors[0].speed += kSpeed;
  const physics::Situation after = predict();
  return std::max({std::abs(after.dw_WB_B.x() - before.dw_WB_B.x()) / kTurn,
                   std::abs(after.body.w_WB_B.x() - before.body.w_WB_B.x()) / kRate,
                   std::abs(after.rotors[0].speed - before.rotors[0].speed) / kSpeed});
}

TEST(Predetermined, ASampleIsNoRegressorOfItself) {
  for (const int i : {1, 5, kLag - 1, kLag, 200}) EXPECT_LT(share(i, i, false), 0.1) << i;
  EXPECT_GT(share(200 - kLag, 200, false), 0.1);  // its past is
}

/// RMS error of the predicted speeds of the rotors [rad/s] over all segments.
double missed(const Flight& flight) {
  const vehicle::Vehicle v = test::omnimorph();
  Mat6 inertia = Mat6::Identity();
  inertia.diagonal() << v.mass, v.mass, v.mass, v.inertia.diagonal();
  const auto predicted = predetermined(flight, inertia, v.center_of_mass, 0.025, kLag, false);
  double squares = 0;
  std::size_t row = 0, count = 0;
  for (const Segment& segment : flight.segments)
    for (int i = segment.begin; i < segment.end; ++i, ++row)
      for (std::size_t r = 0; r < v.rotors.size(); ++r, ++count)
        squares += std::pow(
            predicted[row].rotors[r].speed - flight.situation[static_cast<std::size_t>(i)].rotors[r].speed,
            2);
  EXPECT_EQ(row, predicted.size());
  return std::sqrt(squares / static_cast<double>(count));
}

TEST(Predetermined, SegmentsBetweenGapsTellTogetherHowTheVehicleAnswers) {
  Flight flight = flown();
  const double whole = missed(flight);
  const Segment all = flight.segments[0];
  constexpr int kSegment = 80, kGap = 4;
  flight.segments.clear();
  double squares = 0;
  Flight alone = flight;
  for (int begin = all.begin; begin + kSegment <= all.end; begin += kSegment + kGap) {
    flight.segments.push_back({begin, begin + kSegment});
    alone.segments = {flight.segments.back()};
    squares += std::pow(missed(alone), 2);
  }
  ASSERT_GT(flight.segments.size(), 5U);
  const double together = missed(flight),
               each = std::sqrt(squares / static_cast<double>(flight.segments.size()));
  std::printf(
      "speeds of rotors are missed by %.1f rad/s without gaps, %.1f rad/s in segments of 2 s, %.1f rad/s "
      "in each by itself\n",
      whole, together, each);
  EXPECT_LT(together, 1.3 * whole);
  EXPECT_LT(together, 0.9 * each);
}

TEST(Predetermined, TheReferenceAloneKnowsOfNoSample) {
  for (const int i : {0, 200, 200 - kLag}) EXPECT_LT(share(i, 200, true), 0.02) << i;
}

/// Reference of a flight along x, whose recorded attitude leans by `lean` [rad] about y.
Eigen::MatrixXd reference(const vehicle::Vehicle& v, double lean) {
  recording::Recording r;
  r.signals["ref_velocity"] = signal("ref_velocity", 5, [](double t) { return Vec3(std::sin(2 * t), 0, 0); });
  r.signals["ref_attitude"] = signal("ref_attitude", 5, [&](double t) {
    return Eigen::Vector4d(std::cos(0.5 * lean * t), 0, std::sin(0.5 * lean * t), 0);
  });
  Grid grid;
  grid.step = 3;
  grid.rate_hz = 120;
  for (int i = 0; i < 580; ++i) grid.t.push_back(i / grid.rate_hz);
  return reference_motion(r, grid, v, {});
}

TEST(Predetermined, WhatAPositionLoopAsksForIsNoReference) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  const auto v = vehicle::load_vehicle("quadrotor_1200g");
  ASSERT_TRUE(v);
  const Eigen::MatrixXd upright = reference(*v, 0), leaning = reference(*v, 0.1);
  ASSERT_EQ(upright.cols(), 12);
  EXPECT_LT((upright - leaning).cwiseAbs().maxCoeff(), 1e-9);
  // thrust carries the acceleration 2 cos 2t: its body has no other specific force than along its axis
  EXPECT_LT(upright.block(30, 3, 520, 2).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_GT(upright.col(7).segment(30, 520).cwiseAbs().maxCoeff(), 0.1);  // and it turns about y
  const vehicle::Vehicle free = test::omnimorph();
  EXPECT_GT((reference(free, 0) - reference(free, 0.1)).cwiseAbs().maxCoeff(), 0.05);
}

}  // namespace
}  // namespace omniflight::diagnosis
