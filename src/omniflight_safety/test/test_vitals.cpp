// From measurements to faults: each limit, and what is unknown.
#include <gtest/gtest.h>

#include <cmath>

#include "omniflight_safety/vitals.hpp"

namespace omniflight::safety {
namespace {

Limits limits() {
  Limits l;
  l.command_stale_s = 0.015;
  l.battery_low_V = 14.0;
  l.battery_empty_V = 13.0;
  l.fence = {Vec3(-1, -1, 0), Vec3(1, 1, 2), 0.5};
  return l;
}

FaultSet only(Fault fault) { return FaultSet{}.set(index(fault)); }

TEST(Vitals, NothingIsWrongWithNothingKnown) {
  EXPECT_EQ(judge(limits(), {}), FaultSet{});
  EXPECT_EQ(judge(Limits{}, {}), FaultSet{});
}

TEST(Vitals, EachLimitIsAFaultOfItsOwn) {
  const auto with = [](auto change) {
    Vitals v;
    change(v);
    return judge(limits(), v);
  };
  EXPECT_EQ(with([](auto& v) { v.pose_age_s = 0.301; }), only(Fault::pose_lost));
  EXPECT_EQ(with([](auto& v) { v.pose_age_s = std::nan(""); }), only(Fault::pose_lost));
  EXPECT_EQ(with([](auto& v) { v.imu_age_s = 0.051; }), only(Fault::imu_lost));
  EXPECT_EQ(with([](auto& v) { v.command_age_s = 0.016; }), only(Fault::commands_lost));
  EXPECT_EQ(with([](auto& v) { v.innovation_m = 0.51; }), only(Fault::estimate_diverged));
  EXPECT_EQ(with([](auto& v) { v.hover_load = 0.98; }), only(Fault::rotors_lost));
  EXPECT_EQ(with([](auto& v) { v.hover_load = HUGE_VAL; }), only(Fault::rotors_lost));
  EXPECT_TRUE(with([](auto& v) { v.hover_load = 0.9; }).none());
  EXPECT_EQ(with([](auto& v) { v.missed_share = 0.06; }), only(Fault::periods_missed));
  EXPECT_EQ(with([](auto& v) { v.battery_V = 13.9; }), only(Fault::battery_low));
  EXPECT_EQ(with([](auto& v) { v.battery_V = 12.9; }), only(Fault::battery_low) | only(Fault::battery_empty));
  EXPECT_EQ(with([](auto& v) { v.battery_V = std::nan(""); }),
            only(Fault::battery_low) | only(Fault::battery_empty));
  EXPECT_EQ(with([](auto& v) { v.p_W = Vec3(1.1, 0, 1); }), only(Fault::geofence_left));
  EXPECT_EQ(with([](auto& v) { v.p_W = Vec3(0, 0, -0.6); }),
            only(Fault::geofence_left) | only(Fault::geofence_far));
  EXPECT_EQ(with([](auto& v) { v.recorder = false; }), only(Fault::recorder_lost));
  EXPECT_EQ(with([](auto& v) { v.planner = false; }), only(Fault::planner_lost));
  EXPECT_EQ(with([](auto& v) { v.boards = false; }), only(Fault::board_lost));
  EXPECT_EQ(with([](auto& v) { v.board_emergency = true; }), only(Fault::board_emergency));
  EXPECT_EQ(with([](auto& v) { v.clock = false; }), only(Fault::clock_broken));
  EXPECT_EQ(with([](auto& v) { v.wish = Wish::hold; }), only(Fault::operator_hold));
  EXPECT_EQ(with([](auto& v) { v.wish = Wish::land; }), only(Fault::operator_land));
  EXPECT_EQ(with([](auto& v) { v.wish = Wish::stop; }), only(Fault::operator_stop));
  EXPECT_EQ(with([](auto& v) { v.wish = Wish::cut; }), only(Fault::emergency_stop));
}

TEST(Vitals, WhatIsNotJudgedIsNoFault) {
  Vitals v;
  v.battery_V = 1.0;
  v.command_age_s = 100.0;
  EXPECT_EQ(judge(Limits{}, v), FaultSet{});
}

TEST(Fence, DistanceOutsideIsTheLargestOverTheAxes) {
  const Fence fence{Vec3(-1, -1, 0), Vec3(1, 1, 2), 0.5};
  EXPECT_DOUBLE_EQ(outside(fence, Vec3(0, 0, 1)), -1.0);
  EXPECT_DOUBLE_EQ(outside(fence, Vec3(1.25, -1.5, 1)), 0.5);
  EXPECT_EQ(outside(fence, Vec3(std::nan(""), 0, 1)), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace omniflight::safety
