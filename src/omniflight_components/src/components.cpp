#include "omniflight_components/components.hpp"

#include "factories.hpp"

namespace omniflight::components {
namespace {
struct Entry {
  const char* name;
  std::unique_ptr<bus::Component> (*make)();
};
// in starting order: the recorder first, the clock master last
constexpr Entry kComponents[] = {
    {"recorder", make_recorder},     {"monitor", make_monitor},
    {"planner", make_planner},       {"allocator", make_allocator},
    {"controller", make_controller}, {"emulator", make_emulator},
    {"natnet", make_natnet},         {"natnet_emulator", make_natnet_emulator},
    {"gateway", make_gateway},       {"simulator", make_simulator},
};
}  // namespace

const std::vector<std::string>& component_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const Entry& e : kComponents) out.emplace_back(e.name);
    return out;
  }();
  return names;
}

std::unique_ptr<bus::Component> make_component(const std::string& name) {
  for (const Entry& e : kComponents)
    if (name == e.name) return e.make();
  return nullptr;
}

}  // namespace omniflight::components
