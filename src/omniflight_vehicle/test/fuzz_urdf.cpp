// Vehicles of unknown origin: the same mutated bytes as URDF beside a sound YAML, and as YAML.
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "mutated_inputs.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace {
namespace fs = std::filesystem;

const std::string kYaml = R"(schema: omniflight.vehicle/1
name: fuzz
urdf: fuzz.urdf
mass: 1.0
inertia: [0.01, 0.01, 0.02, 0, 0, 0]
rotors:
  - {position: [0.1, 0, 0], axis: [0, 0, 1], spin: 1, thrust_coefficient: 1.0e-5, drag_ratio: 0.01, min_thrust: 0, max_thrust: 5, radius: 0.1, time_constant: 0.03, board: 0}
  - {position: [-0.1, 0, 0], axis: [0, 0, 1], spin: -1, thrust_coefficient: 1.0e-5, drag_ratio: 0.01, min_thrust: 0, max_thrust: 5, radius: 0.1, time_constant: 0.03, board: 0}
)";
const std::string kUrdf = R"(<?xml version="1.0"?>
<robot name="fuzz">
  <link name="base"><inertial><mass value="1.0"/><origin xyz="0 0 0" rpy="0 0 0"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.3"/></geometry></collision></link>
  <link name="arm"><inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j" type="fixed"><parent link="base"/><child link="arm"/><origin xyz="0.1 0 0" rpy="0 0 0"/></joint>
</robot>
)";

/// In memory where there is such a folder: a file is written at every run.
const fs::path& folder() {
  static const fs::path made = [] {
    const fs::path base = fs::is_directory("/dev/shm") ? "/dev/shm" : fs::temp_directory_path();
    const fs::path path = base / ("omniflight_fuzz_" + std::to_string(::getpid()));
    fs::create_directories(path);
    std::atexit([] { fs::remove_all(folder()); });
    return path;
  }();
  return made;
}

void write(const char* name, std::string_view text) {
  std::ofstream(folder() / name, std::ios::binary) << text;
}
}  // namespace

std::vector<std::string> seeds() { return {kUrdf, kYaml}; }

void feed(std::string_view input) {
  const bool yaml = input.find("schema:") != std::string_view::npos;
  write("fuzz.yaml", yaml ? input : kYaml);
  write("fuzz.urdf", yaml ? kUrdf : input);
  (void)omniflight::vehicle::load_vehicle((folder() / "fuzz.yaml").string());
}
