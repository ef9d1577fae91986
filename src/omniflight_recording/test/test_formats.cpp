// Recognising by content: what is read, what is known and not read, and bags in several files.
#include <gtest/gtest.h>
#include <unistd.h>

#include "real_data.hpp"
#include "sample_bag2.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

class Formats : public testing::Test {
 protected:
  fs::path folder = fs::temp_directory_path() / ("omniflight_formats_" + std::to_string(::getpid()));
  void SetUp() override {
    fs::create_directories(folder);
    setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  }
  void TearDown() override { fs::remove_all(folder); }
  std::string answer(std::string_view content) const {
    std::ofstream(folder / "log") << content;
    const auto r = load(folder / "log");
    return r ? "read as " + r->format : r.error().text();
  }
  void part(const std::string& name, std::uint64_t from, std::uint64_t to) const {
    sample::Bag2 bag(folder / name, false);
    bag.topic(1, "/imu", "sensor_msgs/msg/Imu");
    for (std::uint64_t k = from; k < to; ++k) {
      const std::uint64_t ns = 1'700'000'000'000'000'000 + k * 1'000'000;
      bag.message(1, ns, sample::imu_message(ns));
    }
  }
};

TEST_F(Formats, KnownFormatsThatAreNotReadNameTheCommandThatConvertsThem) {
  const auto converts = [&](std::string_view content, const char* name, const char* command) {
    const std::string text = answer(content);
    EXPECT_NE(text.find(name), std::string::npos) << text;
    EXPECT_NE(text.find(command), std::string::npos) << text;
  };
  converts("MATLAB 5.0 MAT-file, Platform: GLNXA64", ".mat", "scipy.io.loadmat");
  converts(std::string_view("\x00\x06\x0a\x24\x18\x1e\x40\x00\xfd\x09\x00\x00", 12), ".tlog",
           "mavlogdump.py");
  converts(
      "\xa3\x95\x80\x80\x59"
      "FMT",
      "ArduPilot", "mavlogdump.py --format csv");
  converts("FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n", "ArduPilot", "mavlogdump.py");
  converts("\x28\xb5\x2f\xfd....", "zstd", "zstd -d FILE");
  converts("#ROSBAG V1.2\n", "old version", "rosbag fix");
  converts("neither this nor that", "not a recording of a known format", "PX4 ULog; ROS 1 bag; ROS 2 bag");
}

TEST_F(Formats, ABagInSeveralFilesIsOneRecording) {
  part("flight_2.db3", 20, 30);
  part("flight_10.db3", 28, 40);  // begins before the one before ends
  part("flight_1.db3", 0, 20);
  const auto r = load(folder);
  ASSERT_TRUE(r) << r.error().text();
  const Signal& gyro = *r->find("gyro");
  ASSERT_EQ(gyro.size(), 40);
  for (std::size_t i = 1; i < gyro.t_s.size(); ++i) EXPECT_NEAR(gyro.t_s[i] - gyro.t_s[i - 1], 1e-3, 1e-6);
  EXPECT_NEAR(r->duration_s, 0.039, 1e-6);
  EXPECT_EQ(r->topics.front().messages, 42u);
  EXPECT_EQ(r->metadata.at("parts"), "3");
  const bool told = std::any_of(r->notes.begin(), r->notes.end(), [](const Note& n) {
    return n.text.find("flight_10.db3: 2 samples of gyro overlap") != std::string::npos;
  });
  EXPECT_TRUE(told);
  part("other_0.db3", 0, 5);
  EXPECT_NE(load(folder).error().text().find("several recordings"), std::string::npos);
}

TEST(RealSplitBags, PartsAreJoined) {
  NEEDS_REAL_DATA("formats/rosbag2");
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  const fs::path all = real_data("formats/rosbag2/rosbag2_py/test/resources");
  for (const char* storage : {"sqlite3", "mcap"}) {
    const auto r = load(all / storage / "reindex_test_bags/multiple_files");
    ASSERT_TRUE(r) << r.error().text();
    std::uint64_t sum = 0;
    for (const TopicSummary& t : r->topics) sum += t.messages;
    EXPECT_EQ(sum, 1324u + 1324u + 529u) << storage;
  }
}

}  // namespace
