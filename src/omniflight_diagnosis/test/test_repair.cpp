// What loggers and sensors do to a recording is found, cut or put right, and said; what is usual is left
// alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

const vehicle::Vehicle& vehicle() {
  static const vehicle::Vehicle v = test::omnimorph();
  return v;
}

test::Flown lively() {
  test::Flown f;
  f.duration_s = 24;
  f.sway = 0.3;
  f.torque_noise_Nm = 0.0003;
  return f;
}

Recording flown() {
  static const Recording r = test::fly(vehicle(), {}, lively());
  return r;
}

/// The samples of (from, to] repeat the one before.
void freeze(Recording& r, const std::string& name, double from, double to) {
  Signal& s = r.signals[name];
  for (Eigen::Index i = 1; i < s.size(); ++i)
    if (const double t = s.t_s[static_cast<std::size_t>(i)]; t > from && t <= to)
      s.values.row(i) = s.values.row(i - 1);
}

void shift(Recording& r, const std::string& name, double by_s) {
  for (double& t : r.signals[name].t_s) t += by_s;
}

const Window* cut(const Flight& f, const std::string& why) {
  for (const Window& w : f.excluded)
    if (w.why.find(why) != std::string::npos) return &w;
  return nullptr;
}

bool noted(const Flight& f, const std::string& text) {
  return std::any_of(f.notes.begin(), f.notes.end(),
                     [&](const std::string& n) { return n.find(text) != std::string::npos; });
}

TEST(Repair, WhatStandsStillFromTheFirstSampleOnHasNotBegun) {
  Recording r = flown();
  freeze(r, "position", -1, 1.5);
  freeze(r, "attitude", -1, 1.5);
  const auto f = prepare_flight(r, vehicle(), {});
  ASSERT_TRUE(f) << f.error().text();
  EXPECT_TRUE(cut(*f, "position and attitude frozen"));
  EXPECT_TRUE(f->faults.empty());
  EXPECT_TRUE(noted(*f, "position and attitude stand still up to 1.5"));
  freeze(r, "position", 10, 11.5);
  const auto again = prepare_flight(r, vehicle(), {});
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->faults.size(), 1u) << "a later one is";
}

TEST(Repair, AFrozenPoseIsCutOutAndAFinding) {
  Recording r = flown();
  freeze(r, "position", 10, 11.5);
  freeze(r, "attitude", 10, 11.5);
  const auto f = prepare_flight(r, vehicle(), {});
  ASSERT_TRUE(f) << f.error().text();
  const Window* w = cut(*f, "position and attitude frozen");
  ASSERT_TRUE(w);
  EXPECT_NEAR(w->from_s, 10, 0.03);
  EXPECT_NEAR(w->to_s, 11.5, 0.03);
  EXPECT_FALSE(cut(*f, "gap"));
  ASSERT_EQ(f->faults.size(), 1u);
  EXPECT_EQ(f->faults[0].effect, "stale_samples");
  const auto d = diagnose(std::span(&r, 1), {}, vehicle());
  ASSERT_TRUE(d) << d.error().text();
  ASSERT_EQ(d->findings.size(), 1u) << d->summary;
  EXPECT_EQ(d->findings[0].effect, "stale_samples");
  EXPECT_NE(d->summary.find("10.00 s"), std::string::npos) << d->summary;
}

TEST(Repair, RotorsThatStandAsOrderedAreNotFrozen) {
  Recording r = flown();
  r.signals["rotor_command"] = r.signals["rotor_speed"];
  r.signals["rotor_command"].name = "rotor_command";
  freeze(r, "rotor_speed", 10, 11.5);
  const auto stuck = prepare_flight(r, vehicle(), {});
  ASSERT_TRUE(stuck) << stuck.error().text();
  EXPECT_EQ(stuck->faults.size(), 1u);
  freeze(r, "rotor_command", 10, 11.5);
  const auto still = prepare_flight(r, vehicle(), {});
  ASSERT_TRUE(still) << still.error().text();
  EXPECT_TRUE(still->faults.empty()) << still->faults[0].sentence;
}

TEST(Repair, AShortFreezeOfAnInertialSensorIsCutOutAndNoted) {
  for (const char* name : {"gyro", "acc", "rotor_speed"}) {
    Recording r = flown();
    freeze(r, name, 8, 8.3);
    const auto f = prepare_flight(r, vehicle(), {});
    ASSERT_TRUE(f) << f.error().text();
    EXPECT_TRUE(cut(*f, std::string(name) + " frozen")) << name;
    EXPECT_TRUE(noted(*f, std::string(name) + " freezes in flight")) << name;
    EXPECT_TRUE(f->faults.empty()) << f->faults[0].sentence;
  }
}

TEST(Repair, HeldRoundedAndRestingSignalsAreNotFrozen) {
  Recording r = flown();
  Signal& p = r.signals["position"];  // 10 Hz on a log of 100 Hz
  for (Eigen::Index i = 0; i < p.size(); ++i)
    if (i % 10 != 0) p.values.row(i) = p.values.row(i - 1);
  Signal& q = r.signals["attitude"];  // to a hundredth
  q.values = (100 * q.values.array()).round() / 100;
  for (const char* name : {"acc", "gyro", "rotor_speed"}) {  // three seconds on the ground
    Signal& s = r.signals[name];
    s.values = (50 * s.values.array()).round() / 50;
    for (Eigen::Index i = 0; i < 300; ++i) s.values.row(i) = s.values.row(0) * (name[0] == 'r' ? 0.1 : 1.0);
  }
  r.signals["velocity"].values.topRows(300).setZero();
  const auto f = prepare_flight(r, vehicle(), {});
  ASSERT_TRUE(f) << f.error().text();
  EXPECT_FALSE(cut(*f, "frozen"));
  EXPECT_FALSE(cut(*f, "clipped"));
  EXPECT_FALSE(noted(*f, "freeze")) << f->notes[0];
}

TEST(Repair, AFlightWithoutNoiseIsNotFrozenWhereItStands) {
  test::Flown f = lively();
  f.sway = 0;
  f.force_noise_N = f.torque_noise_Nm = f.accelerometer_noise = f.gyro_noise = f.speed_noise = 0;
  const auto flight = prepare_flight(test::fly(vehicle(), {}, f), vehicle(), {});
  ASSERT_TRUE(flight) << flight.error().text();
  EXPECT_FALSE(cut(*flight, "frozen"));
  EXPECT_FALSE(cut(*flight, "clipped"));
}

TEST(Repair, ClippedSamplesAreCutOutWithTheirLimit) {
  for (const char* name : {"gyro", "acc"}) {
    Recording r = flown();
    Signal& s = r.signals[name];
    const double middle = s.values.col(0).mean();
    const double limit = middle + 0.8 * (s.values.col(0).maxCoeff() - middle);
    s.values.col(0) = s.values.col(0).cwiseMin(limit);
    const auto f = prepare_flight(r, vehicle(), {});
    ASSERT_TRUE(f) << f.error().text();
    EXPECT_TRUE(cut(*f, std::string(name) + " clipped at")) << name;
    EXPECT_TRUE(noted(*f, std::string("The ") + name + " is clipped at")) << name;
  }
}

TEST(Repair, SamplesWrittenTwiceAreTakenOnce) {
  Recording r = flown();
  Signal& s = r.signals["acc"];
  const Signal once = s;
  s.values.resize(2 * once.size(), 3);
  s.t_s.clear();
  for (Eigen::Index i = 0; i < once.size(); ++i)
    for (const double late : {0.0, 1e-6}) {
      s.values.row(static_cast<Eigen::Index>(s.t_s.size())) = once.values.row(i);
      s.t_s.push_back(once.t_s[static_cast<std::size_t>(i)] + late);
    }
  r.note(recording::Note::Kind::ignored, "gyro: 40 samples repeat a time and were left out", 40);
  const auto f = prepare_flight(r, vehicle(), {});
  ASSERT_TRUE(f) << f.error().text();
  EXPECT_TRUE(noted(*f, "acc (2400) and gyro (40)"));
  const auto calm = prepare_flight(flown(), vehicle(), {});
  EXPECT_LT((f->specific_force - calm->specific_force).norm(), 1e-9);
}

const SensorFault* clock_fault(const Flight& f) {
  for (const SensorFault& fault : f.faults)
    if (fault.effect == "clock_offset") return &fault;
  return nullptr;
}

TEST(Repair, AFarClockIsPutRight) {
  const auto calm = prepare_flight(flown(), vehicle(), {});
  ASSERT_TRUE(calm) << calm.error().text();
  EXPECT_FALSE(clock_fault(*calm));
  for (const double by : {0.5, -0.8}) {
    Recording r = flown();
    shift(r, "position", by);
    shift(r, "attitude", by);
    shift(r, "velocity", by);
    const auto f = prepare_flight(r, vehicle(), {});
    ASSERT_TRUE(f) << f.error().text();
    const SensorFault* fault = clock_fault(*f);
    ASSERT_TRUE(fault);
    EXPECT_EQ(fault->channel, "position");
    ASSERT_EQ(fault->parameters.size(), 1u);
    EXPECT_NEAR(fault->parameters[0].value, by, 0.005);
    EXPECT_NE(fault->sentence.find(by > 0 ? "s late" : "s early"), std::string::npos) << fault->sentence;
    ASSERT_FALSE(f->alignment.empty());
    EXPECT_NEAR(f->alignment[0].lag_s, by, 0.005);
  }
}

TEST(Repair, TheClockThatIsAloneIsMoved) {
  Recording with_estimate = flown();
  for (const char* name : {"position", "attitude", "velocity"}) {
    Signal& s = with_estimate.signals[std::string("est_") + name];
    s = with_estimate.signals[name];
    s.name = std::string("est_") + name;
  }
  Recording inertial = with_estimate, pose = with_estimate, estimate = with_estimate;
  for (const char* name : {"acc", "gyro"}) shift(inertial, name, 0.5);
  for (const char* name : {"position", "attitude", "velocity"}) {
    shift(pose, name, 0.5);
    shift(estimate, std::string("est_") + name, 0.5);
  }
  const auto said = [](const Recording& r, const char* text) {
    const auto f = prepare_flight(r, vehicle(), {});
    EXPECT_TRUE(f) << f.error().text();
    const SensorFault* fault = f ? clock_fault(*f) : nullptr;
    return fault && fault->sentence.find(text) != std::string::npos;
  };
  EXPECT_FALSE(said(with_estimate, "clock"));
  EXPECT_TRUE(said(inertial, "clock of the gyro and accelerometer"));
  EXPECT_TRUE(said(pose, "clock of the pose"));
  EXPECT_TRUE(said(estimate, "clock of the vehicle's own estimate"));
}

TEST(Repair, ASkewedPoseIsPutRight) {
  Recording r = flown();
  for (const char* name : {"position", "attitude", "velocity"})
    for (double& t : r.signals[name].t_s) t *= 1 + 2e-3;
  const auto f = prepare_flight(r, vehicle(), {});
  ASSERT_TRUE(f) << f.error().text();
  EXPECT_TRUE(noted(*f, "us a second slower")) << f->notes.size();
  // the attitude at the end is that of the end
  const auto calm = prepare_flight(flown(), vehicle(), {});
  const auto last = [](const Flight& x) { return x.situation[static_cast<std::size_t>(x.size() - 40)]; };
  const double error =
      std::abs(log_rotation(Quat(last(*f).R_WB).conjugate() * test::attitude(last(*f).t, lively())).norm());
  EXPECT_LT(error, 0.005);
}

}  // namespace
}  // namespace omniflight::diagnosis
