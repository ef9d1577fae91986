// Recordings of unknown origin in every format that is read from memory; the first byte says which.
#include <unistd.h>

#include "mutated_inputs.hpp"
#include "sample_bag.hpp"
#include "sample_bag1.hpp"
#include "sample_bag2.hpp"
#include "sample_genom3.hpp"
#include "sample_microsd.hpp"
#include "sample_ulog.hpp"

std::vector<std::string> seeds() {
  namespace fs = std::filesystem;
  std::vector<std::string> out;
  const auto add = [&](const char* name, const std::string& bytes) {
    const auto& known = omniflight::recording::formats();
    for (std::size_t k = 0; k < known.size(); ++k)
      if (known[k].name == std::string(name)) out.push_back(std::string(1, static_cast<char>(k)) + bytes);
  };
  const fs::path file =
      fs::temp_directory_path() / ("omniflight_fuzz_" + std::to_string(::getpid()) + ".mcap");
  for (const std::size_t chunk : {std::size_t{500}, std::size_t{1} << 20}) {
    sample::write_flight(file, 20, chunk);
    add("mcap", sample::slurp(file));
  }
  fs::remove(file);
  {
    const fs::path database =
        fs::temp_directory_path() / ("omniflight_fuzz_" + std::to_string(::getpid()) + ".db3");
    sample::Bag2 bag(database, true);
    bag.topic(1, "/imu", "sensor_msgs/msg/Imu", sample::imu_topic().schema_text);
    bag.topic(2, "/mocap/pose", "geometry_msgs/msg/PoseStamped");
    for (std::uint64_t k = 0; k < 5; ++k) {
      bag.message(1, k * 1'000'000, sample::imu_message(k * 1'000'000));
      bag.message(2, k * 1'000'000, sample::pose_message(k * 1'000'000));
    }
    add("rosbag2_sqlite", bag.bytes());
    fs::remove(database);
  }
  add("ulog", sample::flight_log(10).bytes());
  add("rosbag1", sample::flight_bag1("none", 10));
  add("csv",
      "t_s,px_m,py_m,pz_m,qw,qx,qy,qz,rotor1_radps\n0,0,0,1,1,0,0,0,100\n0.01,0,0,1,1,0,0,0,\n0.02,0,,1,1,0,"
      "0,0,101\n");
  add("csv", "t_s;gyro;\"vbat_V\"\n0,5;[0.1, 0.2 0.3];11,1\n0,6;(1;2;3);\"11,2\"\n");
  add("genom3", sample::genom3_log(5));
  add("crazyflie_microsd", sample::microsd_log(5));
  return out;
}

void feed(std::string_view input) {
  if (input.empty()) return;
  const auto& known = omniflight::recording::formats();
  const auto& format = known[static_cast<unsigned char>(input.front()) % known.size()];
  (void)format.read(input.substr(1), "fuzz", {});
}
