// ROS 1 bags of a made-up flight, sound and damaged; and those of others where they are at hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "notes.hpp"
#include "real_data.hpp"
#include "sample_bag.hpp"
#include "sample_bag1.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

Result<Recording> read(std::string_view bytes) { return sample::read_as("rosbag1", bytes); }

class Rosbag1 : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Compression, Rosbag1, testing::Values("none", "bz2", "lz4"),
                         [](const auto& tested) { return std::string(tested.param); });

TEST_P(Rosbag1, AFlightComesBack) {
  const auto r = read(sample::flight_bag1(GetParam(), 500));
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_FALSE(r->lost_anything()) << r->notes.front().text;
  EXPECT_NEAR(r->start_s, 1.7e9, 1e-6);
  ASSERT_EQ(samples(*r, "gyro"), 500);
  ASSERT_EQ(samples(*r, "est_velocity"), 50);
  EXPECT_EQ(r->find("est_attitude")->source,
            "/odom pose.pose.orientation.w");  // the IMU says that it has none
  for (Eigen::Index i = 0; i < 50; ++i) {
    const auto m = sample::moment(r->find("est_velocity")->t_s[static_cast<std::size_t>(i)]);
    EXPECT_LT((Vec3(r->find("est_velocity")->values.row(i)) - m.v_WB).norm(), 1e-9);  // turned into the world
    EXPECT_LT((Vec3(r->find("est_position")->values.row(i)) - m.p_WB).norm(), 1e-9);
    EXPECT_LT((Vec3(r->find("gyro")->values.row(10 * i)) - m.w_B).norm(), 1e-9);
  }
  ASSERT_EQ(r->topics.size(), 2u);
  EXPECT_EQ(r->topics[0].messages, 500u);
  EXPECT_EQ(r->topics[1].type, "nav_msgs/Odometry");
  EXPECT_EQ(r->metadata.at(std::string("rosbag1.chunks.") + GetParam()), "10");
}

TEST_P(Rosbag1, CutAnywhereItKeepsAPrefixAndTellsTheLoss) {
  const std::string bytes = sample::flight_bag1(GetParam(), 120);
  const auto whole = read(bytes).value();
  Eigen::Index before = 0;
  for (std::size_t size = 13; size < bytes.size(); size += size < 4200 ? 40 : 37) {
    const auto r = read(std::string_view(bytes).substr(0, size));
    ASSERT_TRUE(r) << r.error().text();
    ASSERT_TRUE(r->lost_anything() || samples(*r, "gyro") == 120) << size;
    ASSERT_GE(samples(*r, "gyro"), before) << size;
    before = samples(*r, "gyro");
    ASSERT_TRUE(before == 0 || r->find("gyro")->values == whole.find("gyro")->values.topRows(before)) << size;
  }
  EXPECT_EQ(before, 120);
}

TEST_P(Rosbag1, FlippedBitsNeverLoseAMessageSilently) {
  const std::string bytes = sample::flight_bag1(GetParam(), 120);
  const auto whole = read(bytes).value();
  std::mt19937_64 random(11);
  int told = 0;
  for (int i = 0; i < 600; ++i) {
    std::string damaged = bytes;
    const std::size_t bit = random() % (8 * damaged.size());
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    const auto r = read(damaged);
    if (!r || texts(*r) != texts(whole)) {
      ++told;
      continue;
    }
    ASSERT_EQ(samples(*r, "gyro") + samples(*r, "est_position"), 132) << "bit " << bit;
  }
  EXPECT_GT(told, std::string(GetParam()) == "none" ? 5 : 100);
}

TEST(Rosbag1Damage, ADamagedChunkIsLeftOutAndItsMessagesAreCounted) {
  std::string bytes = sample::flight_bag1("bz2", 150);
  const std::size_t second = bytes.find("compression=bz2", bytes.find("compression=bz2") + 1);
  bytes[second + 200] = static_cast<char>(bytes[second + 200] ^ 0x10);
  const auto r = read(bytes).value();
  EXPECT_EQ(samples(r, "gyro"), 100);
  EXPECT_TRUE(has_note(r, "chunk 2 was left out because it cannot be unpacked (bz2)"));
  EXPECT_TRUE(has_note(r, "chunk 2 held 55 messages, 0 were read"));
}

TEST(Rosbag1Damage, BehindGarbageItGoesOnAtTheNextChunk) {
  std::string bytes = sample::flight_bag1("lz4", 150);
  const std::size_t second = bytes.find("compression=lz4", bytes.find("compression=lz4") + 1);
  bytes.replace(second - 8, 8, 8, '\xff');  // the lengths of its header
  const auto r = read(bytes).value();
  EXPECT_EQ(samples(r, "gyro"), 100);
  EXPECT_TRUE(has_note(r, "cannot be read and were skipped"));
}

TEST(Rosbag1Damage, BombsAndUnclosedBagsAreAnswered) {
  std::string bytes = sample::flight_bag1("bz2", 50);
  const std::size_t size_at = bytes.find("size=", bytes.find("compression=bz2")) + 5;
  bytes.replace(size_at, 4, sample::bytes_of(0xffffffffu));
  EXPECT_TRUE(has_note(read(bytes).value(), "more than 100 times"));
  EXPECT_TRUE(has_note(read(sample::flight_bag1("none", 50, 0, false)).value(), "was not closed"));
  EXPECT_FALSE(read("#ROSBAG V1.2\n"));
}

TEST(Rosbag1Clocks, StampsOfAnotherClockAreMoved) {
  // odometry is stamped by a computer that counts from its start; both were logged by one recorder
  std::string records = sample::connection1(0, "/imu", "sensor_msgs/Imu", sample::imu_definition1()) +
                        sample::connection1(1, "/odom", "nav_msgs/Odometry", sample::odometry_definition1());
  const std::uint64_t epoch = 1'700'000'000'000'000'000, boot = 40'000'000'000;
  for (std::uint32_t k = 0; k < 200; ++k) {
    const std::uint64_t ns = k * std::uint64_t{1'000'000};
    records += sample::message1(0, epoch + ns, sample::imu_message1(k, epoch + ns, sample::moment(1e-3 * k)));
    if (k % 10 == 0)
      records +=
          sample::message1(1, epoch + ns, sample::odometry_message1(k, boot + ns, sample::moment(1e-3 * k)));
  }
  const auto r = read("#ROSBAG V2.0\n" + records).value();
  EXPECT_TRUE(has_note(r, "/odom: its stamps are of another clock than those of /imu"));
  EXPECT_LT(r.duration_s, 0.2);
  EXPECT_NEAR(r.find("est_position")->t_s[5], r.find("gyro")->t_s[50], 1e-6);
}

TEST(RealRosbag1, EveryMessageIsReadWhateverTheCompression) {
  NEEDS_REAL_DATA("formats/rosbag1/example.bag");
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  // counted with the package @foxglove/rosbag of npm
  const std::map<std::string, std::uint64_t> reference{
      {"/rosout", 10},         {"/turtle1/color_sensor", 1351}, {"/turtle2/color_sensor", 1344},
      {"/turtle1/pose", 1344}, {"/turtle2/pose", 1344},         {"/turtle1/cmd_vel", 357},
      {"/tf", 2688},           {"/turtle2/cmd_vel", 208},       {"/tf_static", 1}};
  for (const char* name : {"example.bag", "example-bz2.bag", "example-lz4.bag"}) {
    const auto r = load(real_data("formats/rosbag1") / name);
    ASSERT_TRUE(r) << r.error().text();
    EXPECT_FALSE(r->lost_anything()) << name << ": " << r->notes.front().text;
    EXPECT_EQ(r->metadata.at("rosbag1.messages"), "8647") << name;
    std::map<std::string, std::uint64_t> counts;
    for (const TopicSummary& t : r->topics) counts[t.name] = t.messages;
    EXPECT_EQ(counts, reference) << name;
  }
  const auto none = load(real_data("formats/rosbag1/no-messages.bag"));
  ASSERT_TRUE(none) << none.error().text();
  EXPECT_TRUE(none->signal_names().empty());
  EXPECT_FALSE(load(real_data("formats/rosbag1/empty-file.bag")));
}

}  // namespace
