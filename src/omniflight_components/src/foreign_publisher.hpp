// Saying that somebody else publishes where one publisher is followed.
#pragma once

#include <cstdio>

#include "omniflight_bus/event.hpp"

namespace omniflight::components {

/// The first refused message is said, then every thousandth.
inline void say_foreign(const bus::Event& event) {
  constexpr std::uint64_t kEvery = 1000;
  if (event.kind == bus::EventKind::foreign_publisher && event.count % kEvery == 1)
    std::fprintf(stderr, "[bus] a second publisher of %s is refused (%llu messages so far)\n",
                 event.topic.c_str(), static_cast<unsigned long long>(event.count));
}

}  // namespace omniflight::components
