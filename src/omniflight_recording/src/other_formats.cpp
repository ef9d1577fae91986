#include "other_formats.hpp"

#include <cstdint>

namespace omniflight::recording {
namespace {

bool starts(std::string_view head, std::string_view with) { return head.substr(0, with.size()) == with; }

/// MAVLink with a time stamp before each packet: u64 microseconds since 1970, big endian, then 0xFE or 0xFD.
bool is_tlog(std::string_view head) {
  if (head.size() < 10) return false;
  std::uint64_t us = 0;
  for (int i = 0; i < 8; ++i) us = us << 8 | static_cast<unsigned char>(head[static_cast<std::size_t>(i)]);
  const auto magic = static_cast<unsigned char>(head[8]);
  constexpr std::uint64_t k2005 = 1'104'537'600'000'000, k2100 = 4'102'444'800'000'000;
  return (magic == 0xfe || magic == 0xfd) && us > k2005 && us < k2100;
}

struct Known {
  OtherFormat format;
  bool (*sniff)(std::string_view head);
};

constexpr const char* kMavlogdump =
    "Convert it with pymavlink: mavlogdump.py --format csv --types ATTITUDE FILE > attitude.csv, a table for "
    "each type of message; then omniflight import attitude.csv --map MAP";

const Known kKnown[] = {
    {{"a MAVLink telemetry log (.tlog)", kMavlogdump}, is_tlog},
    {{"an ArduPilot log (.bin)",
      "Convert it with pymavlink: mavlogdump.py --format csv --types IMU FILE > imu.csv, a table for each "
      "type "
      "of message (IMU, ATT, XKF1, RCOU, BAT); then omniflight import imu.csv --map MAP"},
     [](std::string_view h) { return starts(h, "\xa3\x95\x80"); }},
    {{"an ArduPilot log as text (.log)",
      "Convert it with pymavlink: mavlogdump.py --format csv --types IMU FILE > imu.csv; then omniflight "
      "import "
      "imu.csv --map MAP"},
     [](std::string_view h) { return starts(h, "FMT, 128, 89"); }},
    {{"a MATLAB file (.mat)",
      "Write its table as CSV: in MATLAB writetable(TABLE, 'flight.csv'), or python3 -c \"import scipy.io, "
      "pandas; m = scipy.io.loadmat('FILE', squeeze_me=True); pandas.DataFrame({k: m[k] for k in ['t', "
      "'x']}).to_csv('flight.csv')\"; then omniflight import flight.csv --map MAP"},
     [](std::string_view h) { return starts(h, "MATLAB 5.0 MAT-file") || starts(h, "MATLAB 7.3 MAT-file"); }},
    {{"an HDF5 file",
      "Write its table as CSV: python3 -c \"import pandas; pandas.read_hdf('FILE').to_csv("
      "'flight.csv')\"; then omniflight import flight.csv --map MAP"},
     [](std::string_view h) { return starts(h, "\x89HDF\r\n\x1a\n"); }},
    {{"a Parquet file",
      "Write it as CSV: python3 -c \"import pandas; pandas.read_parquet('FILE').to_csv("
      "'flight.csv')\"; then omniflight import flight.csv --map MAP"},
     [](std::string_view h) { return starts(h, "PAR1"); }},
    {{"a Betaflight blackbox log",
      "Convert it with blackbox-tools: blackbox_decode FILE; then omniflight import FILE.01.csv --map MAP"},
     [](std::string_view h) { return starts(h, "H Product:Blackbox flight data recorder"); }},
    {{"a ROS 1 bag of an old version", "Convert it with ROS: rosbag reindex FILE; rosbag fix FILE new.bag"},
     [](std::string_view h) { return starts(h, "#ROSBAG V1") || starts(h, "#ROSRECORD V"); }},
    {{"compressed by zstd", "Unpack it: zstd -d FILE"},
     [](std::string_view h) { return starts(h, "\x28\xb5\x2f\xfd"); }},
    {{"compressed by bzip2", "Unpack it: bunzip2 -k FILE"},
     [](std::string_view h) { return starts(h, "BZh"); }},
    {{"compressed by xz", "Unpack it: unxz -k FILE"},
     [](std::string_view h) {
       return starts(h, std::string_view("\xfd"
                                         "7zXZ\0",
                                         6));
     }},
    {{"a zip archive (or a spreadsheet)", "Unpack it: unzip FILE; save a spreadsheet as CSV"},
     [](std::string_view h) { return starts(h, "PK\x03\x04"); }},
};

}  // namespace

const OtherFormat* find_other_format(std::string_view head) {
  for (const Known& known : kKnown)
    if (known.sniff(head)) return &known.format;
  return nullptr;
}

}  // namespace omniflight::recording
