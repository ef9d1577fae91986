// Maps of topics: the shipped ones, what is refused, and what a user's own map decides.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>

#include "../src/topic_map.hpp"
#include "notes.hpp"
#include "sample_bag2.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

class TopicMaps : public testing::Test {
 protected:
  fs::path folder = fs::temp_directory_path() / ("omniflight_maps_" + std::to_string(::getpid()));
  void SetUp() override {
    fs::create_directories(folder);
    setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  }
  void TearDown() override { fs::remove_all(folder); }

  fs::path write(const std::string& topics) const {
    std::ofstream(folder / "mine.yaml") << "schema: omniflight.topic_map/1\ntopics:\n" << topics;
    return folder / "mine.yaml";
  }
  std::string refusal(const std::string& topics) const {
    const auto map = load_topic_map(write(topics));
    return map ? "" : map.error().text();
  }
  /// IMU and two poses; both are stamped.
  std::string bag() const {
    sample::Bag2 out(folder / "bag_0.db3", false);
    out.topic(1, "/imu", "sensor_msgs/msg/Imu");
    out.topic(2, "/b/pose", "geometry_msgs/msg/PoseStamped");
    out.topic(3, "/a/pose", "geometry_msgs/msg/PoseStamped");
    for (std::uint64_t k = 0; k < 20; ++k) {
      out.message(1, k * 1'000'000, sample::imu_message(k * 1'000'000));
      out.message(2, k * 1'000'000, sample::pose_message(k * 1'000'000));
      if (k % 2 == 0) out.message(3, k * 1'000'000, sample::pose_message(k * 1'000'000));
    }
    return out.bytes();
  }
};

TEST_F(TopicMaps, TheShippedOnesLoadAndEverySignalIsCanonical) {
  TopicMap map = topic_map_for({}).value();
  const std::size_t own = map.entries.size();
  ASSERT_TRUE(add_shipped_maps(map)) << add_shipped_maps(map).error().text();
  EXPECT_GT(map.entries.size(), own + 30);
  for (const TopicEntry& entry : map.entries)
    for (const TopicSignal& signal : entry.signals)
      EXPECT_NE(find_spec(signal.signal), nullptr) << signal.signal;
  const auto of = [&](const char* topic, const char* type) { return entries_for(map, topic, type); };
  EXPECT_EQ(map.entries[of("/uav1/mavros/imu/data", "sensor_msgs/Imu").front()].map, "mavros");
  EXPECT_EQ(map.entries[of("/imu", "sensor_msgs/Imu").front()].map, "ros");
  EXPECT_EQ(map.entries[of("/fmu/out/vehicle_attitude_v1", "px4_msgs/VehicleAttitude").front()].map, "px4");
  EXPECT_TRUE(of("vehicle_attitude_groundtruth_x", "").empty());
  EXPECT_TRUE(of("/omniflight/odometry", "nav_msgs/Odometry").empty());  // ours are named, never guessed
}

TEST_F(TopicMaps, AnAerostackBagFillsEstimateReferenceAndTruth) {
  sample::Bag2 out(folder / "bag_0.db3", false);
  out.topic(1, "/drone0/sensor_measurements/imu", "sensor_msgs/msg/Imu");
  out.topic(2, "/drone0/self_localization/pose", "geometry_msgs/msg/PoseStamped");
  out.topic(3, "/drone0/motion_reference/pose", "geometry_msgs/msg/PoseStamped");
  out.topic(4, "/drone0/ground_truth/pose", "geometry_msgs/msg/PoseStamped");
  for (std::uint64_t k = 0; k < 20; ++k) {
    const std::uint64_t ns = k * 1'000'000;
    out.message(1, ns, sample::imu_message(ns));
    for (int topic = 2; topic <= 4; ++topic) out.message(topic, ns, sample::pose_message(ns));
  }
  const auto r = sample::read_as("rosbag2_sqlite", out.bytes()).value();
  for (const char* name : {"gyro", "acc", "est_position", "est_attitude", "ref_position", "ref_attitude",
                           "truth_position", "truth_attitude"})
    EXPECT_EQ(samples(r, name), 20) << name;
  EXPECT_EQ(r.find("position"), nullptr);  // no estimate is taken for motion capture
  EXPECT_EQ(r.find("est_position")->source, "/drone0/self_localization/pose pose.position.x");
  TopicMap map = topic_map_for({}).value();
  ASSERT_TRUE(add_shipped_maps(map));
  const auto motor = entries_for(map, "/drone0/actuator_command/motor", "as2_msgs/Motor");
  EXPECT_EQ(map.entries[motor.front()].map, "aerostack2");
}

TEST_F(TopicMaps, MistakesAreNamedWithLineAndNextStep) {
  const auto signal = [&](const std::string& rest) {
    return refusal("  - topic: x\n    signals:\n      - {signal: " + rest + "}\n");
  };
  EXPECT_NE(signal("atitude, fields: [q]").find("Did you mean 'attitude'?"), std::string::npos);
  EXPECT_NE(signal("gyro, fields: [w], frame: ned").find("Use flu or frd"), std::string::npos);
  EXPECT_NE(signal("gyro, fields: [w], unit: rpm").find("Known: rad/s, deg/s, rev/min"), std::string::npos);
  EXPECT_NE(signal("gyro, fields: [x, y]").find("3 components"), std::string::npos);
  EXPECT_NE(signal("attitude, fields: [q], quaternion: wyxz").find("Use wxyz or xyzw"), std::string::npos);
  EXPECT_NE(signal("gyro, fields: [w], colour: red").find("colour"), std::string::npos);
  EXPECT_NE(signal("gyro, fields: [w], frame: ned").find("mine.yaml:5"), std::string::npos);
  EXPECT_NE(refusal("  - signals: [{signal: vbat, fields: [v]}]\n").find("neither topic nor type"),
            std::string::npos);
  const auto csv = load_topic_map(fs::path(OMNIFLIGHT_SOURCE_ROOT) / "configs/csv_maps/nanobench.yaml");
  ASSERT_FALSE(csv);
  EXPECT_NE(csv.error().text().find("This map is for CSV"), std::string::npos);
}

TEST_F(TopicMaps, AChangedMapOfTheConfigurationIsReadAgain) {
  fs::create_directories(folder / "configs/topic_maps");
  fs::create_directories(folder / "configs/vehicles");
  setenv("OMNIFLIGHT_CONFIGS", (folder / "configs").c_str(), 1);
  const auto entries = [&](const std::string& topics) {
    std::ofstream(folder / "configs/topic_maps/site.yaml") << "schema: omniflight.topic_map/1\ntopics:\n"
                                                           << topics;
    TopicMap map = topic_map_for({}).value();
    const auto ok = add_shipped_maps(map);
    return ok ? static_cast<int>(entries_for(map, "/x", "").size()) : -1;
  };
  const std::string topic = "  - topic: x\n    signals: [{signal: vbat, fields: [v]}]\n";
  EXPECT_EQ(entries(topic), 1);
  EXPECT_EQ(entries(topic), 1);
  EXPECT_EQ(entries(topic + topic), 2);
  EXPECT_EQ(entries("  - topic: x\n"), -1);
}

TEST_F(TopicMaps, OfTwoTopicsOneIsTakenAndTheOtherIsSaid) {
  const auto r = sample::read_as("rosbag2_sqlite", bag()).value();
  EXPECT_EQ(r.find("position")->source, "/a/pose pose.position.x");
  EXPECT_EQ(r.find("position")->size(), 10);
  EXPECT_TRUE(has_note(r, "position: /a/pose was taken; /b/pose would give it, too"));
}

TEST_F(TopicMaps, TheMapOfTheUserDecides) {
  const auto map = write(
      "  - topic: /b/pose\n    signals:\n"
      "      - {signal: position, fields: [pose.position.x, pose.position.y, pose.position.z], frame: ned, "
      "scale: 2}\n"
      "      - {signal: attitude, fields: [pose.orientation.x, pose.orientation.y, pose.orientation.z, "
      "pose.orientation.w], quaternion: xyzw}\n"
      "      - {signal: velocity, fields: [no.such.field]}\n");
  const auto r = sample::read_as("rosbag2_sqlite", bag(), {.map = map}).value();
  const Signal& p = *r.find("position");
  EXPECT_EQ(p.source, "/b/pose pose.position.x, converted from NED");
  ASSERT_EQ(p.size(), 20);
  const double t = 0.007;  // written as (t, 2 t, 3 t)
  EXPECT_NEAR(p.values(7, 0), 2 * 2 * t, 1e-12);
  EXPECT_NEAR(p.values(7, 1), 2 * t, 1e-12);
  EXPECT_NEAR(p.values(7, 2), -2 * 3 * t, 1e-12);
  EXPECT_NEAR(r.find("attitude")->values(7, 0), std::cos(t / 2), 1e-12);
  EXPECT_EQ(r.find("gyro")->size(), 20);  // the shipped maps go on to read the rest
  EXPECT_TRUE(has_note(r, "velocity was not read, because its type has no field 'no.such.field'"));
}

TEST_F(TopicMaps, WhereItSaysWhichMessagesCount) {
  const auto map = write(
      "  - topic: /imu\n    signals:\n"
      "      - {signal: gyro, fields: [angular_velocity.x, angular_velocity.y, angular_velocity.z], unit: "
      "deg/s, "
      "where: [{field: header.stamp.nanosec, differs: 5000000}]}\n"
      "      - {signal: acc, fields: [linear_acceleration.x, linear_acceleration.y, linear_acceleration.z], "
      "unit: g, range: [-1, 9.8151]}\n");
  const auto r = sample::read_as("rosbag2_sqlite", bag(), {.map = map}).value();
  EXPECT_EQ(r.find("gyro")->size(), 19);
  EXPECT_NEAR(r.find("gyro")->values(3, 1), std::cos(0.003) * kPi / 180, 1e-12);
  EXPECT_EQ(r.find("acc")->size(), 6);  // 9.81 + t
  EXPECT_NEAR(r.find("acc")->values(0, 0), 0.1 * kGravity, 1e-12);
  EXPECT_TRUE(has_note(r, "/imu: 14 messages were left out whose acc is not valid"));
}

}  // namespace
