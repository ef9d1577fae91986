// Missions that tests make of a shipped one.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "bench.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/mission.hpp"

namespace omniflight::planning {

inline void use_shipped_configs() { setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1); }
/// The YAML of trajectory_2 with further keys; its heights are 0.9 to 2.0 m over a counter of 0.58 m.
inline std::string trajectory_2_with(const std::string& keys) {
  std::string bytes = files::read_file(kConfigs / "missions/trajectory_2.yaml", 1 << 20).value();
  return bytes.insert(bytes.find("start: {position"), keys + "\n");
}
/// A file of this name in the tests' folder.
inline std::filesystem::path written(const std::string& name, const std::string& bytes) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / name;
  std::ofstream(path) << bytes;
  return path;
}
inline Result<Mission> mission_of(const std::string& yaml, const std::string& name) {
  return load_mission(written(name + ".yaml", yaml).string());
}

}  // namespace omniflight::planning
