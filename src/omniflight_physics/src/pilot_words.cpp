#include "omniflight_physics/pilot_words.hpp"

#include <algorithm>

namespace omniflight::physics {

std::string say(const PilotWords& words, const KnownValues& values) {
  if (!words.say) return {};
  const auto there = [&](const std::string& name) { return values(name) != 0; };
  if (!words.needs.empty() && std::none_of(words.needs.begin(), words.needs.end(), there)) return {};
  return words.say(values);
}

}  // namespace omniflight::physics
