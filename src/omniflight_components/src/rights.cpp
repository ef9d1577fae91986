#include "omniflight_components/rights.hpp"

#include <algorithm>

#include "omniflight_bus/heartbeat.hpp"
#include "omniflight_components/topics.hpp"

namespace omniflight::components {
namespace {

using Topics = std::vector<std::string>;

std::map<std::string, bus::Rights> make_rights() {
  namespace t = topics;
  const Topics everything{"*"};
  std::map<std::string, bus::Rights> out{
      {"recorder", {{t::recorder}, everything}},
      {"planner", {{t::trajectory, t::replanning}, {t::controller, t::mission}}},
      {"allocator",
       {{t::allocator, t::command, t::lost_rotors, t::joints, t::robot_description},
        {t::controller, t::rotors, t::failsafe, t::gate}}},
      {"controller",
       {{t::controller, t::failsafe, t::transforms},
        {t::trajectory, t::imu, t::mocap, t::wish, t::battery, t::allocator, t::lost_rotors, t::tick}}},
      {"monitor", {{t::diagnostics}, {t::imu, t::mocap, t::rotors, t::command, t::tick}}},
      {"simulator",
       {{t::imu, t::mocap, t::rotors, t::battery, t::tick, t::truth},
        {t::command, t::recorder, t::failsafe}}},
      {"mujoco_plant",
       {{t::imu, t::mocap, t::rotors, t::battery, t::tick, t::truth},
        {t::command, t::recorder, t::failsafe}}},
      {"gateway",
       {{t::imu, t::rotors, t::battery, t::tick, t::gate},
        {t::command, t::recorder, t::failsafe, t::wish, t::mocap, bus::heartbeat_topic}}},
      {"emulator", {{t::mocap, t::emulated_mocap, t::truth}, {t::tick}}},
      {"natnet", {{t::mocap}, {}}},
      {"natnet_emulator", {{}, {t::emulated_mocap}}},
      {"operator", {{t::wish, t::mission}, everything}},
  };
  bus::Rights all{{}, everything};
  for (auto& [role, rights] : out) {
    if (role == "operator") continue;  // no component
    rights.publish.insert(rights.publish.end(), {t::state, bus::heartbeat_topic});
    all.publish.insert(all.publish.end(), rights.publish.begin(), rights.publish.end());
  }
  std::sort(all.publish.begin(), all.publish.end());
  all.publish.erase(std::unique(all.publish.begin(), all.publish.end()), all.publish.end());
  out["container"] = all;
  return out;
}

}  // namespace

const std::map<std::string, bus::Rights>& rights_of_roles() {
  static const std::map<std::string, bus::Rights> rights = make_rights();
  return rights;
}

}  // namespace omniflight::components
