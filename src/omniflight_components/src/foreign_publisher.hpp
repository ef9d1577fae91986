// Saying that somebody else publishes where one publisher is followed.
#pragma once

#include <string>

#include "omniflight_bus/event.hpp"
#include "omniflight_bus/say.hpp"

namespace omniflight::components {

/// The first refused message is said, then every thousandth.
inline void say_foreign(const bus::Event& event) {
  constexpr std::uint64_t kEvery = 1000;
  if (event.kind == bus::EventKind::foreign_publisher && event.count % kEvery == 1)
    bus::say("bus", "a second publisher of " + event.topic + " is refused (" + std::to_string(event.count) +
                        " messages so far)");
}

}  // namespace omniflight::components
