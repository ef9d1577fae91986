// The synthetic logs under configs/sample_logs, one of each format: they are what the writers of these tests
// write. With OMNIFLIGHT_WRITE_SAMPLES=1 they are written anew.
#include <gtest/gtest.h>
#include <unistd.h>

#include "notes.hpp"
#include "sample_bag1.hpp"
#include "sample_bag2.hpp"
#include "sample_genom3.hpp"
#include "sample_microsd.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

const fs::path kFolder = fs::path(OMNIFLIGHT_SOURCE_ROOT) / "configs/sample_logs";

std::string sqlite_bag() {
  const fs::path file =
      fs::temp_directory_path() / ("omniflight_sample_" + std::to_string(::getpid()) + ".db3");
  sample::Bag2 out(file, false);
  out.topic(1, "/imu", "sensor_msgs/msg/Imu");
  out.topic(2, "/mocap/pose", "geometry_msgs/msg/PoseStamped");
  for (std::uint64_t k = 0; k < 200; ++k) {
    const std::uint64_t ns = 1'700'000'000'000'000'000 + k * 1'000'000;
    out.message(1, ns, sample::imu_message(ns));
    if (k % 10 == 0) out.message(2, ns, sample::pose_message(ns));
  }
  const std::string bytes = out.bytes();
  fs::remove(file);
  return bytes;
}

std::string mcap() {
  const fs::path file =
      fs::temp_directory_path() / ("omniflight_sample_" + std::to_string(::getpid()) + ".mcap");
  sample::write_flight(file, 200, 1 << 20);
  const std::string bytes = sample::slurp(file);
  fs::remove(file);
  return bytes;
}

std::string semicolons() {
  std::string out = "t_s;px_m;py_m;pz_m;attitude;\"vbat_V\"\n";
  for (int k = 0; k < 200; ++k) {
    const std::string millis = std::to_string(1000 + k).substr(1);
    out += "0," + millis + ";0," + millis + ";0;1,5;[1, 0, 0, 0];11," + std::to_string(999 - k) + "\n";
  }
  return out;
}

struct SampleLog {
  const char* file;
  const char* format;
  std::string (*bytes)();
  const char* signal;
  Eigen::Index samples;
};
const SampleLog kLogs[] = {
    {"synthetic_px4.ulg", "ulog", [] { return sample::flight_log(200).bytes(); }, "gyro", 200},
    {"synthetic_ros1.bag", "rosbag1", [] { return sample::flight_bag1("lz4", 200); }, "gyro", 200},
    {"synthetic_ros2.db3", "rosbag2_sqlite", sqlite_bag, "gyro", 200},
    {"synthetic_omniflight.mcap", "mcap", mcap, "gyro", 200},
    {"synthetic_crazyflie_microsd", "crazyflie_microsd", [] { return sample::microsd_log(200); }, "gyro",
     200},
    {"synthetic_genom3.log", "genom3", [] { return sample::genom3_log(200); }, "rotor_command", 200},
    {"synthetic_semicolons.csv", "csv", semicolons, "position", 200},
};

class SampleLogs : public testing::TestWithParam<SampleLog> {};
INSTANTIATE_TEST_SUITE_P(Format, SampleLogs, testing::ValuesIn(kLogs),
                         [](const auto& tested) { return std::string(tested.param.format); });

TEST_P(SampleLogs, IsReadAsItsWriterWroteIt) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  const SampleLog& log = GetParam();
  const std::string bytes = log.bytes();
  if (std::getenv("OMNIFLIGHT_WRITE_SAMPLES")) {
    fs::create_directories(kFolder);
    std::ofstream(kFolder / log.file, std::ios::binary) << bytes;
  }
  const auto r = load(kFolder / log.file);
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_EQ(r->format, log.format);
  EXPECT_EQ(samples(*r, log.signal), log.samples);
  EXPECT_FALSE(r->lost_anything()) << texts(*r).front();
  const auto made = sample::read_as(log.format, bytes).value();
  ASSERT_EQ(r->signal_names(), made.signal_names());
  for (const auto& [name, signal] : made.signals) {
    EXPECT_EQ(r->find(name)->t_s, signal.t_s) << name;
    EXPECT_EQ(r->find(name)->values, signal.values) << name;
  }
}

TEST(SampleLogsFolder, HasOneOfEveryFormat) {
  EXPECT_EQ(std::size(kLogs), formats().size());
  for (const Format& format : formats())
    EXPECT_EQ(std::count_if(std::begin(kLogs), std::end(kLogs),
                            [&](const SampleLog& log) { return std::string(log.format) == format.name; }),
              1)
        << format.name;
}

}  // namespace
