// A log in NED and FRD, turned as told.
#include "omniflight_recording/axes.hpp"

#include <gtest/gtest.h>

#include "omniflight_core/frames.hpp"

namespace omniflight::recording {
namespace {

Signal one(const char* name, std::vector<double> row) {
  Signal s;
  s.name = name;
  s.t_s = {0};
  s.values = Eigen::Map<Eigen::RowVectorXd>(row.data(), static_cast<Eigen::Index>(row.size()));
  s.source = std::string("column ") + name;
  return s;
}

Recording in_ned() {
  Recording r;
  r.file = "flight.csv";
  // flies east at 2 m/s, 3 m high, nose to the north, rolled to the right by 0.2 rad
  for (Signal s : {one("position", {5, 7, -3}), one("velocity", {0, 2, 0}),
                   one("attitude", {std::cos(0.1), std::sin(0.1), 0, 0}), one("gyro", {0.1, 0.2, 0.3}),
                   one("rotor_speed", {400, 401, 402})})
    r.signals[s.name] = s;
  return r;
}

TEST(Axes, NorthEastDownBecomesEastNorthUp) {
  Recording r = in_ned();
  ASSERT_TRUE(turn_from_ned(r));
  EXPECT_TRUE(r.signals["position"].values.row(0).isApprox(Eigen::RowVector3d(7, 5, 3)));
  EXPECT_TRUE(r.signals["velocity"].values.row(0).isApprox(Eigen::RowVector3d(2, 0, 0)));
  EXPECT_TRUE(r.signals["gyro"].values.row(0).isApprox(Eigen::RowVector3d(0.1, -0.2, -0.3)));
  EXPECT_EQ(r.signals["rotor_speed"].values(0, 1), 401);
  const auto q = r.signals["attitude"].values.row(0);
  const Quat q_WB(q[0], q[1], q[2], q[3]);
  EXPECT_TRUE((q_WB * Vec3::UnitX()).isApprox(Vec3::UnitY(), 1e-12)) << "the nose points north";
  // rolled to the right, what is up for the body leans to the east
  EXPECT_TRUE((q_WB * Vec3::UnitZ()).isApprox(Vec3(std::sin(0.2), 0, std::cos(0.2)), 1e-12));
  ASSERT_EQ(r.notes.size(), 1u);
  EXPECT_NE(r.notes[0].text.find("attitude from NED/FRD"), std::string::npos) << r.notes[0].text;
}

TEST(Axes, NothingIsTurnedTwice) {
  Recording r = in_ned();
  ASSERT_TRUE(turn_from_ned(r));
  const Eigen::MatrixXd before = r.signals["position"].values;
  const Status again = turn_from_ned(r);
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().text().find("twice"), std::string::npos) << again.error().text();
  EXPECT_EQ(r.signals["position"].values, before);
}

TEST(Axes, AWidthThatIsNoVectorIsRefusedBeforeAnythingIsTurned) {
  Recording r = in_ned();
  r.signals["velocity"] = one("velocity", {1, 2});
  EXPECT_FALSE(turn_from_ned(r));
  EXPECT_EQ(r.signals["position"].values(0, 0), 5);
}

}  // namespace
}  // namespace omniflight::recording
