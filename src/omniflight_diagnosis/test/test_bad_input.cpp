// Input that is wrong in a way a user gets wrong: answered with the reason, never with a finding.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_recording/formats.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using test::omnimorph;

recording::Recording good(const vehicle::Vehicle& v) {
  test::Flown flown;
  flown.duration_s = 12;
  flown.sway = 0.2;
  return test::fly(v, {}, flown);
}

/// What is said about it: the summary when it is unusable, the error, or what was found in spite of all.
std::string answer(const recording::Recording& r, const vehicle::Vehicle& v) {
  const auto d = diagnose(std::span(&r, 1), {}, v);
  if (!d)
    return d.error().code == ErrorCode::bad_input ? d.error().text() : "wrong code: " + d.error().text();
  if (d->verdict == Verdict::unusable && d->findings.empty()) return d->summary;
  return "FOUND " + to_string(d->verdict) + ": " + d->summary;
}

#define EXPECT_SAYS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST(BadInput, AGoodRecordingIsNotObjectedTo) {
  const vehicle::Vehicle v = omnimorph();
  EXPECT_SAYS(answer(good(v), v), "FOUND nothing_missing");
}

TEST(BadInput, EmptyAndShortRecordings) {
  const vehicle::Vehicle v = omnimorph();
  EXPECT_SAYS(answer(recording::Recording{}, v), "no sample");
  recording::Recording r = good(v);
  for (auto& [name, s] : r.signals) {
    s.t_s.resize(1);
    s.values.conservativeResize(1, Eigen::NoChange);
  }
  EXPECT_SAYS(answer(r, v), "holds 1 sample only");
}

TEST(BadInput, ValuesThatAreNotFinite) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = good(v);
  r.signals["gyro"].values(100, 1) = std::nan("");
  EXPECT_SAYS(answer(r, v), "'gyro' holds values that are not finite");
}

TEST(BadInput, UnitsAreToldByMagnitude) {
  const vehicle::Vehicle v = omnimorph();
  const struct {
    const char* signal;
    double scale;
    const char* says;
  } cases[] = {{"gyro", 180 / kPi, "degrees per second"},
               {"acc", 1 / kGravity, "'acc'"},
               {"acc", 100, "mm/s2"},
               {"alpha", 180 / kPi, "degrees"},
               {"rotor_speed", 30 / kPi, "rev/min"},
               {"rotor_speed", 0.5 / kPi, "Hz"},
               {"position", 1000, "millimetres"}};
  for (const auto& c : cases) {
    recording::Recording r = good(v);
    r.signals[c.signal].values *= c.scale;
    const std::string said = answer(r, v);
    EXPECT_SAYS(said, "cannot be used");
    EXPECT_SAYS(said, c.says);
  }
  recording::Recording r = good(v);
  for (auto& [name, s] : r.signals)
    for (double& t : s.t_s) t *= 1000;
  EXPECT_SAYS(answer(r, v), "milliseconds");
}

TEST(BadInput, ConventionsAreToldByContradiction) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = good(v);
  Eigen::MatrixXd& q = r.signals["attitude"].values;
  const Eigen::MatrixXd right = q;
  q << right.col(1), right.col(2), right.col(3), right.col(0);
  EXPECT_SAYS(answer(r, v), "x, y, z, w");
  q << right.col(0), -right.col(1), -right.col(2), -right.col(3);
  EXPECT_SAYS(answer(r, v), "body<-world");
  q = right;
  r.signals["acc"].values *= -1;
  EXPECT_SAYS(answer(r, v), "opposite sign");
}

TEST(BadInput, AGyroInDegreesIsToldFromABodyThatHardlyTurns) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown f;
  f.duration_s = 12;
  f.sway = 0.03;
  recording::Recording r = test::fly(v, {}, f);
  EXPECT_EQ(answer(r, v).find("cannot be used"), std::string::npos) << answer(r, v);
  r.signals["gyro"].values *= 180 / kPi;
  EXPECT_SAYS(answer(r, v), "degrees per second");
}

TEST(BadInput, AnAttitudeTurnedRoundIsToldByTheThrustWhereThereIsNoImu) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown f;
  f.duration_s = 12;
  f.sway = 0.5;
  recording::Recording r = test::fly(v, {}, f);
  r.signals.erase("acc");
  r.signals.erase("gyro");
  EXPECT_EQ(answer(r, v).find("cannot be used"), std::string::npos) << answer(r, v);
  r.signals["attitude"].values.rightCols(3) *= -1;
  EXPECT_SAYS(answer(r, v), "body<-world");
}

TEST(BadInput, MotorsThatOnlyIdleOrCarryAnotherVehicleAreToldByTheirDuty) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = good(v);
  test::drive_by_duty(r, v, 1.0);
  EXPECT_EQ(answer(r, v).find("cannot be used"), std::string::npos) << answer(r, v);
  vehicle::Vehicle heavy = v, light = v;
  heavy.mass *= 10;
  light.mass *= 0.1;
  EXPECT_SAYS(answer(r, heavy), "cannot fly");
  EXPECT_SAYS(answer(r, light), "does not fit this recording");
  r.signals["pwm"].values *= 0.15;
  EXPECT_SAYS(answer(r, v), "never flew");
}

TEST(BadInput, AVehicleThatDoesNotFit) {
  vehicle::Vehicle v = omnimorph();
  const recording::Recording r = good(v);
  for (double factor : {10.0, 0.1}) {
    vehicle::Vehicle other = v;
    other.mass *= factor;
    const std::string said = answer(r, other);
    EXPECT_SAYS(said, "does not fit this recording");
  }
  vehicle::Vehicle fewer = v;
  fewer.rotors.resize(6);
  EXPECT_SAYS(answer(r, fewer), "has 8 rotors");
}

TEST(BadInput, AVehicleThatNeverFlew) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = good(v);
  Random random(3, "rest");
  for (const char* name : {"position", "velocity", "gyro", "acc"})
    for (Eigen::Index i = 0; i < r.signals[name].size(); ++i)
      for (Eigen::Index c = 0; c < 3; ++c)
        r.signals[name].values(i, c) = (name[0] == 'a' && c == 2 ? kGravity : 0) + 1e-3 * random.normal();
  r.signals["attitude"].values.rowwise() = Eigen::RowVector4d(1, 0, 0, 0);
  Eigen::MatrixXd& speed = r.signals["rotor_speed"].values;
  speed.setConstant(200);  // idling
  EXPECT_SAYS(answer(r, v), "never flew");
  speed.setZero();
  EXPECT_SAYS(answer(r, v), "never flew");
}

TEST(BadInput, ATimeThatRunsBackwardsInAFile) {
  const std::string path = testing::TempDir() + "backwards.csv";
  std::ofstream(path) << "t_s,px_m,py_m,pz_m\n0,0,0,1\n0.1,0,0,1\n0.05,0,0,1\n";
  const auto r = recording::load(path);
  ASSERT_FALSE(r);
  EXPECT_SAYS(r.error().text(), "time runs backwards");
  EXPECT_SAYS(r.error().text(), ":4");
}

}  // namespace
}  // namespace omniflight::diagnosis
