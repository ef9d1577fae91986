// ROS 2 bags in SQLite of a made-up flight, sound and damaged; and those of others where they are at hand.
#include <gtest/gtest.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <random>

#include "notes.hpp"
#include "real_data.hpp"
#include "sample_bag2.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

constexpr std::uint64_t kEpoch = 1'700'000'000'000'000'000;

class Rosbag2 : public testing::Test {
 protected:
  fs::path file = fs::temp_directory_path() / ("omniflight_bag2_" + std::to_string(::getpid()) + ".db3");
  void TearDown() override { fs::remove(file); }

  std::string flight(bool definitions, std::uint64_t steps) const {
    sample::Bag2 bag(file, definitions);
    bag.topic(1, "/imu", "sensor_msgs/msg/Imu", definitions ? sample::imu_topic().schema_text : "");
    bag.topic(2, "/vrpn/drone/pose", "geometry_msgs/msg/PoseStamped",
              definitions ? sample::pose_topic().schema_text : "");
    for (std::uint64_t k = 0; k < steps; ++k) {
      const std::uint64_t ns = kEpoch + k * 1'000'000;
      bag.message(1, ns, sample::imu_message(ns));
      if (k % 10 == 0) bag.message(2, ns, sample::pose_message(ns));
    }
    return bag.bytes();
  }
};

Result<Recording> read(std::string_view bytes) { return sample::read_as("rosbag2_sqlite", bytes); }

TEST_F(Rosbag2, AFlightComesBackWithAndWithoutDefinitionsInTheBag) {
  for (const bool definitions : {true, false}) {
    const auto r = read(flight(definitions, 500));
    ASSERT_TRUE(r) << r.error().text();
    EXPECT_FALSE(r->lost_anything()) << r->notes.front().text;
    ASSERT_EQ(samples(*r, "gyro"), 500);
    ASSERT_EQ(samples(*r, "position"), 50);
    EXPECT_NEAR(r->start_s, 1.7e9, 1e-6);
    EXPECT_NEAR(r->find("gyro")->t_s[499], 0.499, 1e-9);
    EXPECT_EQ(r->find("acc")->values(3, 0), 0.1);
    EXPECT_EQ(r->find("position")->source, "/vrpn/drone/pose pose.position.x");
    EXPECT_TRUE(has_note(*r, "topic '/vrpn/drone/pose' was taken for what it is by its type"));
    EXPECT_EQ(r->metadata.at("rosbag2.messages"), "550");
  }
}

TEST_F(Rosbag2, MessagesThatWereCompressedOneByOneAreUnpacked) {
  const auto packed = [](const std::string& message) {
    std::string out(ZSTD_compressBound(message.size()), '\0');
    out.resize(ZSTD_compress(out.data(), out.size(), message.data(), message.size(), 1));
    return out;
  };
  sample::Bag2 bag(file, false);
  bag.topic(1, "/imu", "sensor_msgs/msg/Imu");
  for (std::uint64_t k = 0; k < 20; ++k)
    bag.message(1, k * 1'000'000, packed(sample::imu_message(k * 1'000'000)));
  bag.message(1, 20'000'000, packed(std::string(300u << 20, '\0')));  // a bomb of 300 MB
  bag.message(1, 21'000'000, packed(sample::imu_message(0)).substr(0, 25));
  const auto r = read(bag.bytes()).value();
  EXPECT_EQ(samples(r, "gyro"), 20);
  EXPECT_TRUE(has_note(r, "/imu: 2 messages do not fit their definition"));
}

TEST_F(Rosbag2, TheFileIsNotTouchedAndAWriteAheadLogIsTold) {
  const std::string bytes = flight(true, 20);
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  const auto before = fs::last_write_time(file);
  fs::permissions(file, fs::perms::owner_read);
  ASSERT_TRUE(load(file));
  EXPECT_EQ(fs::last_write_time(file), before);
  EXPECT_EQ(sample::slurp(file), bytes);
  EXPECT_FALSE(fs::exists(file.string() + "-journal") || fs::exists(file.string() + "-shm"));
  std::ofstream(file.string() + "-wal") << "frames";
  EXPECT_TRUE(has_note(load(file).value(), "write-ahead log beside it"));
  fs::remove(file.string() + "-wal");
  std::string wal = bytes;
  wal[18] = wal[19] = 2;  // the mark of a database that was written with one
  EXPECT_EQ(samples(read(wal).value(), "gyro"), 20);
}

TEST_F(Rosbag2, Px4OverRos2IsConvertedAndPutOnOneClock) {
  for (const bool in_body : {false, true}) {  // the velocity in world axes, or in those of the body
    sample::Bag2 bag(file, true);
    bag.topic(1, "/fmu/out/vehicle_odometry", "px4_msgs/msg/VehicleOdometry", sample::kPx4Odometry);
    bag.topic(2, "/mocap/pose", "geometry_msgs/msg/PoseStamped", sample::pose_topic().schema_text);
    for (std::uint64_t k = 0; k < 100; ++k) {
      const std::uint64_t us = 30'000'000 + k * 10'000, ns = kEpoch + k * 10'000'000;
      bag.message(1, ns, sample::px4_odometry(us, sample::moment(1e-2 * static_cast<double>(k)), in_body));
      bag.message(2, ns, sample::pose_message(ns));
    }
    const auto r = read(bag.bytes());
    ASSERT_TRUE(r) << r.error().text();
    EXPECT_TRUE(has_note(*r, "another clock"));
    EXPECT_LT(r->duration_s, 1.0);
    const Signal &q = *r->find("est_attitude"), &p = *r->find("est_position"), &v = *r->find("est_velocity");
    ASSERT_EQ(q.size(), 100);
    for (Eigen::Index i = 0; i < 100; ++i) {
      const auto m = sample::moment(1e-2 * static_cast<double>(i));
      const Quat here(q.values(i, 0), q.values(i, 1), q.values(i, 2), q.values(i, 3));
      EXPECT_LT(log_rotation(m.q_WB.conjugate() * here).norm(), 1e-6);
      EXPECT_LT((Vec3(p.values.row(i)) - m.p_WB).norm(), 1e-6);
      EXPECT_LT((Vec3(v.values.row(i)) - m.v_WB).norm(), 1e-6);
    }
  }
}

TEST_F(Rosbag2, WhatIsWantedIsNotTakenForWhatIs) {
  sample::Bag2 bag(file, false);
  bag.topic(1, "/goal_pose", "geometry_msgs/msg/PoseStamped");
  bag.topic(2, "/imu", "sensor_msgs/msg/Imu", "", "protobuf");
  bag.topic(3, "/camera", "sensor_msgs/msg/Image");
  bag.message(1, kEpoch, sample::pose_message(kEpoch));
  bag.message(2, kEpoch, "?");
  const auto r = read(bag.bytes()).value();
  EXPECT_TRUE(r.signal_names().empty());
  EXPECT_TRUE(has_note(r, "'/goal_pose' (geometry_msgs/PoseStamped) was not taken for a measurement"));
  EXPECT_TRUE(has_note(r, "its messages are 'protobuf'; cdr is read"));
  EXPECT_TRUE(has_note(r, "topic '/camera' (sensor_msgs/Image) has no known signal"));
}

TEST_F(Rosbag2, CutFilesAreReadAsFarAsTheyAreSound) {
  const std::string bytes = flight(true, 300);
  const auto whole = read(bytes).value();
  int partly = 0;
  for (std::size_t size = 0; size < bytes.size(); size += 991) {
    const auto r = read(std::string_view(bytes).substr(0, size));
    if (!r) continue;
    ASSERT_TRUE(r->lost_anything()) << size;
    const Eigen::Index now = samples(*r, "gyro");
    ASSERT_TRUE(now == 0 || r->find("gyro")->values == whole.find("gyro")->values.topRows(now)) << size;
    partly += now > 0 && now < 300;
  }
  EXPECT_GT(partly, 5);
}

TEST_F(Rosbag2, FlippedBitsNeverLoseAMessageSilently) {
  const std::string bytes = flight(true, 200);
  const auto whole = read(bytes).value();
  const auto texts = [](const Recording& r) {
    std::vector<std::string> out;
    for (const Note& n : r.notes) out.push_back(n.text);
    return out;
  };
  std::mt19937_64 random(3);
  for (int i = 0; i < 600; ++i) {
    std::string damaged = bytes;
    const std::size_t bit = random() % (8 * damaged.size());
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    const auto r = read(damaged);
    if (!r || texts(*r) != texts(whole)) continue;
    ASSERT_EQ(samples(*r, "gyro") + samples(*r, "position"), 220) << "bit " << bit;
  }
}

TEST_F(Rosbag2, OtherDatabasesAndHostileTablesAreRefused) {
  const auto refused = [&](const std::string& sql, const std::string& part) {
    fs::remove(file);
    sqlite3* db = nullptr;
    sqlite3_open(file.c_str(), &db);
    ASSERT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
    const auto r = read(sample::slurp(file));
    ASSERT_FALSE(r);
    EXPECT_NE(r.error().text().find(part), std::string::npos) << r.error().text();
  };
  refused("CREATE TABLE albums(title)", "without the table topics");
  const std::string topics = "CREATE TABLE topics(id, name, type, serialization_format);";
  refused(topics +
              "CREATE VIEW messages AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) "
              "SELECT x AS topic_id, x AS timestamp, x AS data FROM c",
          "messages is no plain table");
  refused(topics + "CREATE TABLE messages(topic_id, timestamp, data GENERATED ALWAYS AS (zeroblob(1000000)))",
          "messages is no plain table");
  refused("CREATE TABLE topics(id); CREATE TABLE messages(id)", "has not the columns");
  EXPECT_FALSE(read(std::string_view("SQLite format 3\0", 16)));
}

TEST(RealRosbag2, EverySqliteBagOfOthersIsReadCompletely) {
  NEEDS_REAL_DATA("formats/rosbag2");
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  // counted with the sqlite3 module of Python
  const std::map<std::string, std::uint64_t> reference{
      {"rewriter_a_0.db3", 150},      {"rewriter_b_0.db3", 75},     {"talker.db3", 20},
      {"test_bag_for_seek_0.db3", 5}, {"empty_bag_0.db3", 0},       {"wbag_0.db3", 1246},
      {"wbag_4.db3", 1108},           {"multiple_files_2.db3", 529}};
  int bags = 0;
  for (const auto& entry : fs::recursive_directory_iterator(real_data("formats/rosbag2"))) {
    if (entry.path().extension() != ".db3") continue;
    const auto r = load(entry.path());
    ASSERT_TRUE(r) << r.error().text();
    EXPECT_FALSE(r->lost_anything()) << entry.path() << ": " << r->notes.front().text;
    std::uint64_t sum = 0;
    for (const TopicSummary& t : r->topics) sum += t.messages;
    EXPECT_EQ(std::to_string(sum), r->metadata.at("rosbag2.messages"));
    const auto known = reference.find(entry.path().filename().string());
    EXPECT_TRUE(known == reference.end() || sum == known->second) << entry.path() << " " << sum;
    ++bags;
  }
  EXPECT_GT(bags, 12);
}

}  // namespace
