#include "parameter_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"

namespace omniflight::cli {
namespace {

/// What the flight itself decides: a parameter here would write elsewhere, or attach what is not of the
/// flight.
constexpr const char* kOwn[] = {"recorder.file",     "recorder.overwrite",     "recorder.attachments",
                                "recorder.metadata", "recorder.record_truth",  "monitor.summary_file",
                                "planner.plan",      "planner.mission",        "emulator.link_directory",
                                "gateway.devices",   "gateway.summary_file",   "gateway.plan",
                                "natnet.config",     "natnet_emulator.config", "allocator.tilt_schedule",
                                "controller.map"};

bool is_word(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(),
                                      [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
}

}  // namespace

Status check_parameters(const std::map<std::string, std::string>& parameters,
                        const std::vector<std::string>& components) {
  for (const auto& [key, value] : parameters) {
    const std::string where = "-p " + files::shown(key);
    const auto dot = key.find('.');
    const std::string component = key.substr(0, dot),
                      name = dot == std::string::npos ? "" : key.substr(dot + 1);
    if (!is_word(component) || !is_word(name))
      return bad_input("is not component.parameter", where, "For instance controller.kp");
    if (std::find(components.begin(), components.end(), component) == components.end()) {
      const std::string near = files::nearest_word(component, components);
      return bad_input("this flight has no component " + files::shown(component), where,
                       near.empty() ? fmt::format("It has {}", fmt::join(components, ", "))
                                    : "Did you mean '" + near + "." + name + "'?");
    }
    if (std::find(std::begin(kOwn), std::end(kOwn), key) != std::end(kOwn))
      return bad_input("is decided by the flight itself", where,
                       "Use the options of fly (--out, --plan, --devices)");
    if (std::any_of(value.begin(), value.end(), [](unsigned char c) { return c < 0x20 && c != '\t'; }))
      return bad_input("has a value of several lines", where,
                       "Give one YAML value, for instance [10, 10, 10]");
    const auto yaml = files::YamlReader::parse(name + ": " + value, where);
    if (!yaml) return Failure(yaml.error());
    if (yaml->keys() != std::vector<std::string>{name})
      return bad_input(files::shown(value) + " is not one YAML value", where, "For instance [10, 10, 10]");
  }
  return {};
}

}  // namespace omniflight::cli
