// Crazyflie micro-SD logs of a made-up flight, sound, cut and damaged.
#include <gtest/gtest.h>

#include "notes.hpp"
#include "sample_bag.hpp"
#include "sample_microsd.hpp"

using namespace omniflight;
using namespace omniflight::recording;

namespace {

Result<Recording> read(std::string_view bytes) { return sample::read_as("crazyflie_microsd", bytes); }

TEST(MicroSd, AFlightComesBackInSiUnits) {
  const auto r = read(sample::microsd_log(500));
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_FALSE(r->lost_anything());
  ASSERT_EQ(samples(*r, "gyro"), 500);
  ASSERT_EQ(samples(*r, "position"), 50);
  for (Eigen::Index i = 0; i < 50; ++i) {
    const auto m = sample::moment(0.01 * static_cast<double>(i));
    EXPECT_LT((Vec3(r->find("position")->values.row(i)) - m.p_WB).norm(), 1e-6);
    EXPECT_LT((Vec3(r->find("gyro")->values.row(10 * i)) - m.w_B).norm(), 1e-6);
    const Vec3 up = m.q_WB.conjugate() * Vec3(0, 0, kGravity);
    EXPECT_LT((Vec3(r->find("acc")->values.row(10 * i)) - up).norm(), 1e-5);
    EXPECT_NEAR(std::abs(r->find("attitude")->values(i, 0)), std::abs(m.q_WB.w()), 1e-6);
  }
  EXPECT_NEAR(r->find("rotor_speed")->values(0, 3), 15003 * kPi / 30, 1e-9);
  EXPECT_NEAR(r->find("vbat")->values(0, 0), 3.9, 1e-9);
}

TEST(MicroSd, CutAtEveryByteItKeepsAPrefixAndTellsTheLoss) {
  const std::string bytes = sample::microsd_log(40);
  const auto whole = read(bytes).value();
  Eigen::Index before = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto r = read(std::string_view(bytes).substr(0, size));
    if (!r) continue;
    ASSERT_TRUE(r->lost_anything()) << size;
    const Eigen::Index n = samples(*r, "gyro");
    ASSERT_GE(n, before) << size;
    before = n;
    ASSERT_TRUE(n == 0 || r->find("gyro")->values == whole.find("gyro")->values.topRows(n)) << size;
  }
  EXPECT_EQ(before, 40);
}

TEST(MicroSd, EveryFlippedBitIsRefusedOrTold) {
  const std::string bytes = sample::microsd_log(12);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string damaged = bytes;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
    const auto r = read(damaged);
    ASSERT_TRUE(!r || r->lost_anything()) << "bit " << bit;
  }
}

}  // namespace
