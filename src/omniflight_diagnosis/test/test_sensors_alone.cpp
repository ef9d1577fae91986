// Recordings that carry no wrench, and several recordings of which each has sensors of its own.
#include <gtest/gtest.h>

#include <algorithm>

#include "../src/sensor_checks/allocation_check.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using test::omnimorph;

Recording with_only(Recording r, const std::vector<std::string>& names) {
  std::erase_if(r.signals,
                [&](const auto& s) { return std::find(names.begin(), names.end(), s.first) == names.end(); });
  return r;
}

Recording flown(const vehicle::Vehicle& v, const std::string& file, std::uint64_t seed = 1,
                double duration_s = 16) {
  test::Flown f;
  f.duration_s = duration_s, f.seed = seed;
  f.force_noise_N = 0.01, f.torque_noise_Nm = 0.0005;  // what the air does hides no sensor
  Recording r = test::fly(v, {}, f);
  r.file = file;
  return r;
}

/// An inertial sensor that lies on a table.
Recording at_rest(const Vec3& bias, double gravity) {
  Recording r;
  r.file = "table";
  r.duration_s = 12;
  Random random(3, "table");
  for (const char* name : {"acc", "gyro"}) {
    recording::Signal& s = r.signals[name];
    s.name = name;
    s.unit = s.name == "acc" ? "m/s2" : "rad/s";
    s.values.resize(2400, 3);
    for (int i = 0; i < 2400; ++i) {
      s.t_s.push_back(i / 200.0);
      const Vec3 noise(random.normal(), random.normal(), random.normal());
      s.values.row(i) =
          (s.name == "acc" ? Vec3(Vec3(0, 0, gravity) + 0.05 * noise) : Vec3(bias + 0.003 * noise))
              .transpose();
    }
  }
  return r;
}

const Finding* find(const Diagnosis& d, const char* effect) {
  const auto at = std::find_if(d.findings.begin(), d.findings.end(),
                               [&](const Finding& f) { return f.effect == effect; });
  return at == d.findings.end() ? nullptr : &*at;
}

double fact(const Intake& in, const char* signal, const char* quantity) {
  for (const SensorFact& f : in.sensors)
    if (f.signal == signal && f.quantity == quantity) return f.value;
  ADD_FAILURE() << "no " << quantity << " of " << signal;
  return 0;
}

bool lacks(const Intake& in, const char* signal) {
  return std::any_of(in.missing.begin(), in.missing.end(),
                     [&](const MissingSignal& m) { return m.signal == signal && !m.costs.empty(); });
}

TEST(SensorsAlone, AnInertialSensorAloneIsJudgedAndThePhysicsIsNot) {
  const vehicle::Vehicle v = omnimorph();
  const Recording r = with_only(flown(v, "imu"), {"acc", "gyro"});
  const auto d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(d->verdict, Verdict::unusable);
  EXPECT_TRUE(d->findings.empty()) << d->summary;
  EXPECT_TRUE(d->model.empty());
  EXPECT_EQ(d->intake.missing.front().signal, "rotor_speed");
  EXPECT_TRUE(lacks(d->intake, "attitude"));
  EXPECT_TRUE(lacks(d->intake, "position"));
  EXPECT_NEAR(fact(d->intake, "acc", "white noise, RMS"), 0.05, 0.02);
  EXPECT_NEAR(fact(d->intake, "gyro", "white noise, RMS"), 0.005, 0.002);
  EXPECT_NEAR(fact(d->intake, "motion", "force needed, mean"), v.mass * 9.81, 0.02 * v.mass * 9.81);
  EXPECT_NE(d->summary.find("Record 'rotor_speed' first"), std::string::npos) << d->summary;
  EXPECT_NE(to_json(*d).find("\"missing\""), std::string::npos);
}

TEST(SensorsAlone, APoseAloneTellsTheForceItNeedsAndNotWhoGaveIt) {
  const vehicle::Vehicle v = omnimorph();
  Recording r = with_only(flown(v, "mocap"), {"position", "attitude"});
  recording::Signal reference = r.signals["position"];
  reference.name = "ref_position";
  reference.values.col(1).array() += 0.02;
  r.signals["ref_position"] = reference;
  const auto d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(d->verdict, Verdict::unusable);
  EXPECT_TRUE(d->findings.empty()) << d->summary;
  EXPECT_TRUE(lacks(d->intake, "acc"));
  EXPECT_FALSE(lacks(d->intake, "ref_position"));
  EXPECT_NEAR(fact(d->intake, "motion", "force needed, mean"), v.mass * 9.81, 0.05 * v.mass * 9.81);
  EXPECT_NEAR(fact(d->intake, "position", "tracking error y, mean"), -0.02, 1e-6);
  EXPECT_EQ(fact(d->intake, "motion", "time in free fall"), 0);
}

TEST(SensorsAlone, WhatRotorSpeedsWouldHaveToldOfAMotionIsSaid) {
  const vehicle::Vehicle v = omnimorph();
  const Recording whole = flown(v, "whole");
  const Recording r = with_only(whole, {"position", "attitude", "acc", "gyro", "alpha"});
  const auto d = diagnose(std::span(&r, 1), {}, v);
  const auto c = check(std::span(&whole, 1), v);
  ASSERT_TRUE(d) << d.error().text();
  ASSERT_TRUE(c) << c.error().text();
  EXPECT_EQ(d->verdict, Verdict::unusable);
  EXPECT_NE(d->summary.find("With rotor speeds this motion could show"), std::string::npos) << d->summary;
  // what the flight with its rotors shows clearly is among it
  for (const Detectability& seen : c->intake.detectability) {
    if (seen.sigma < 10) continue;
    const auto& told = d->intake.detectability;
    const auto at = std::find_if(told.begin(), told.end(),
                                 [&](const Detectability& x) { return x.effect == seen.effect; });
    ASSERT_NE(at, told.end()) << seen.effect;
    EXPECT_GT(at->sigma, 3) << seen.effect;
  }
}

TEST(SensorsAlone, ALeverWithoutForcesIsOfEitherSensor) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown f;
  f.duration_s = 40, f.sway = 0.3, f.force_noise_N = 0.01, f.torque_noise_Nm = 0.0005;
  f.accelerometer_noise = 0.02, f.gyro_noise = 0.002;
  Recording r = with_only(test::fly(v, {}, f), {"position", "attitude", "acc", "gyro"});
  for (Eigen::Index i = 0; i < r.signals["position"].size(); ++i) {
    const auto q = r.signals["attitude"].values.row(i);
    r.signals["position"].values.row(i) += (Quat(q[0], q[1], q[2], q[3]) * Vec3(0, 0.1, 0)).transpose();
  }
  const auto d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(d) << d.error().text();
  const Finding* lever = find(*d, "imu_lever_arm");
  ASSERT_NE(lever, nullptr) << d->summary;
  EXPECT_EQ(lever->cannot_be_told_apart_from, std::vector<std::string>{"mocap_offset"});
  EXPECT_NEAR(lever->parameters[1].value, -0.1, 0.02);
}

TEST(SensorsAlone, AFallIsSeenInThePose) {
  const vehicle::Vehicle v = omnimorph();
  Recording r;
  r.file = "dropped";
  recording::Signal& p = r.signals["position"];
  p.name = "position", p.unit = "m";
  p.values = Eigen::MatrixXd::Zero(800, 3);
  for (int i = 0; i < 800; ++i) {
    p.t_s.push_back(i / 100.0);
    const double fallen = std::clamp(i / 100.0 - 4, 0.0, 0.6);
    p.values(i, 2) = 3 - 0.5 * 9.81 * fallen * fallen;  // and is caught
  }
  r.duration_s = 8;
  const auto d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(d) << d.error().text();
  // the low pass blurs both ends
  EXPECT_GT(fact(d->intake, "motion", "time in free fall"), 0.25) << d->summary;
  EXPECT_LT(fact(d->intake, "motion", "time in free fall"), 0.6) << d->summary;
}

TEST(SensorsAlone, WhatARestingSensorReadsIsItsError) {
  const vehicle::Vehicle v = omnimorph();
  for (const auto& [bias, gravity, gyro, acc] : {std::tuple{Vec3(0, 0, 0), 9.81, false, false},
                                                 {Vec3(0, 0.05, 0), 9.81, true, false},
                                                 {Vec3(0, 0, 0), 9.4, false, true}}) {
    const Recording r = at_rest(bias, gravity);
    const auto d = diagnose(std::span(&r, 1), {}, v);
    ASSERT_TRUE(d) << d.error().text();
    EXPECT_EQ(find(*d, "gyro_error") != nullptr, gyro) << d->summary;
    EXPECT_EQ(find(*d, "accelerometer_error") != nullptr, acc) << d->summary;
    if (gyro) {
      const ParameterValue& y = find(*d, "gyro_error")->parameters[1];
      EXPECT_LT(y.low, 0.05);
      EXPECT_GT(y.high, 0.05);
      EXPECT_NEAR(y.value, 0.05, 0.001);
    }
  }
}

TEST(SensorsAlone, APoseThatFreezesAndJumpsIsNamedAndOneThatStandsIsNot) {
  const vehicle::Vehicle v = omnimorph();
  Recording r = with_only(flown(v, "mocap"), {"position", "attitude"});
  const auto whole = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(whole) << whole.error().text();
  EXPECT_EQ(find(*whole, "stale_samples"), nullptr) << whole->summary;
  Eigen::MatrixXd& p = r.signals["position"].values;
  for (Eigen::Index i = 320; i < 380; ++i) p.row(i) = p.row(320);  // it climbs there
  const auto d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(d) << d.error().text();
  ASSERT_NE(find(*d, "stale_samples"), nullptr) << d->summary;
  EXPECT_EQ(find(*d, "stale_samples")->channels.front(), "position");
  const auto m = std::find_if(d->mismatch.begin(), d->mismatch.end(),
                              [](const Mismatch& x) { return x.channel == "position"; });
  ASSERT_NE(m, d->mismatch.end());
  ASSERT_EQ(m->windows_s.size(), 1u);
  EXPECT_NEAR(m->windows_s[0].first, 3.2, 0.02);
}

TEST(SensorsAlone, SeveralFlightsOfMotorsAloneAreJudgedTogetherAtTheirTilt) {
  const vehicle::Vehicle v = omnimorph();
  const physics::Effect* offset = physics::find_effect("com_offset");
  std::vector<Recording> all;
  for (const std::uint64_t seed : {1, 2, 3}) {
    test::Flown f;
    f.duration_s = 16, f.seed = seed, f.alpha = 0.3 + 0.1 * static_cast<double>(seed);
    all.push_back(
        with_only(test::fly(v, {{offset, {0.03, 0.0, 0.0}}}, f), {"rotor_speed", "gyro", "acc", "alpha"}));
    all.back().file = "flight" + std::to_string(seed);
  }
  for (const std::size_t count : {1u, 3u}) {
    const auto d = diagnose(std::span(all.data(), count), {}, v);
    ASSERT_TRUE(d) << d.error().text();
    ASSERT_NE(find(*d, "com_offset"), nullptr) << d->summary;
    EXPECT_NEAR(find(*d, "com_offset")->parameters[0].value, 0.03, 0.002) << d->summary;
    EXPECT_NEAR(find(*d, "com_offset")->parameters[1].value, 0, 0.002) << d->summary;
    EXPECT_EQ(d->inputs.size(), count);
    EXPECT_EQ(d->further.size(), count - 1);
  }
}

TEST(SensorsAlone, AFlightWithoutItsMotorsStandsBesideOneThatHasThem) {
  const vehicle::Vehicle v = omnimorph();
  const Recording both[] = {with_only(flown(v, "imu"), {"acc", "gyro"}), flown(v, "whole", 2)};
  const auto d = diagnose(both, {}, v);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(d->verdict, Verdict::nothing_missing) << d->summary;
  EXPECT_NE(d->summary.find("the wrench in imu"), std::string::npos) << d->summary;
  EXPECT_EQ(d->inputs.size(), 2u);
}

TEST(SensorsAlone, TheSecondRecordingHasSensorsToo) {
  const vehicle::Vehicle v = omnimorph();
  Recording both[] = {flown(v, "first", 1, 30), flown(v, "second", 2, 30)};
  both[1].signals["gyro"].values.col(0).array() += 0.1;
  const auto d = diagnose(both, {}, v);
  ASSERT_TRUE(d) << d.error().text();
  ASSERT_NE(find(*d, "gyro_error"), nullptr) << d->summary;
  EXPECT_EQ(find(*d, "gyro_error")->recordings, std::vector<std::string>{"second"});
  both[0].signals["gyro"].values.col(0).array() += 0.1;
  const auto again = diagnose(both, {}, v);
  ASSERT_TRUE(again) << again.error().text();
  ASSERT_NE(find(*again, "gyro_error"), nullptr) << again->summary;
  EXPECT_EQ(find(*again, "gyro_error")->recordings, (std::vector<std::string>{"first", "second"}));
  EXPECT_EQ(std::count_if(again->findings.begin(), again->findings.end(),
                          [](const Finding& f) { return f.effect == "gyro_error"; }),
            1);
}

TEST(SensorsAlone, ACheckLooksAtEveryRecording) {
  const vehicle::Vehicle v = omnimorph();
  Recording three[] = {flown(v, "first"), flown(v, "second", 2),
                       with_only(flown(v, "third"), {"acc", "gyro"})};
  Eigen::MatrixXd& speed = three[1].signals["rotor_speed"].values;
  for (Eigen::Index i = 400; i < 900; ++i) speed(i, 2) = speed(400, 2);
  const auto c = check(three, v);
  ASSERT_TRUE(c) << c.error().text();
  EXPECT_EQ(c->inputs.size(), 3u);
  EXPECT_EQ(c->intake.recording, "first");
  ASSERT_EQ(c->further.size(), 2u);
  EXPECT_FALSE(c->further[0].detectability.empty());
  EXPECT_EQ(c->further[1].missing.front().signal, "rotor_speed");
  ASSERT_NE(find(*c, "rotor_speed_sensor_fault"), nullptr) << c->summary;
  EXPECT_EQ(find(*c, "rotor_speed_sensor_fault")->recordings, std::vector<std::string>{"second"});
  EXPECT_EQ(c->verdict, Verdict::unusable);                             // of the third
  for (recording::Recording& r : three) r.signals["rotor_speed"] = {};  // and one that is no flight at all
  three[0] = with_only(three[0], {"acc"});
  three[0].signals["acc"].t_s.resize(5);
  three[0].signals["acc"].values.conservativeResize(5, Eigen::NoChange);
  const auto others = check(three, v);
  ASSERT_TRUE(others) << others.error().text();
  EXPECT_EQ(others->inputs.size(), 3u);
  EXPECT_NE(others->summary.find("first: This recording cannot be used"), std::string::npos)
      << others->summary;
  EXPECT_FALSE(check(std::span(three, 1), v));
}

TEST(SensorsAlone, WhatAnAllocatorCouldNotGiveIsAComparisonWithItsTimes) {
  Recording r;
  for (const char* name : {"qddr", "qdd"}) {
    recording::Signal& s = r.signals[name];
    s.name = name;
    s.values = Eigen::MatrixXd::Zero(1000, 6);
    for (int i = 0; i < 1000; ++i) {
      s.t_s.push_back(i / 100.0);
      const bool late = s.name == "qdd";
      s.values(i, 0) = 2 * std::sin(0.3 * (i - (late ? 1 : 0)));              // given, a sample late
      s.values(i, 2) = late && i >= 400 && i < 600 ? 1.0 : (i >= 400) * 3.0;  // not given for 2 s
    }
  }
  const auto m = locate_allocation(r);
  ASSERT_EQ(m.size(), 1u);
  EXPECT_EQ(m[0].channel, "az");
  EXPECT_NE(m[0].where.find("comparison without noise"), std::string::npos) << m[0].where;
  ASSERT_EQ(m[0].windows_s.size(), 1u);
  EXPECT_NEAR(m[0].windows_s[0].first, 4, 0.02);
  EXPECT_NEAR(m[0].windows_s[0].second, 6, 0.02);
}

}  // namespace
}  // namespace omniflight::diagnosis
