#include "omniflight_bus/say.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <utility>

namespace omniflight::bus {

std::optional<std::uint64_t> LineLimit::allow(double now_s) {
  if (last_s_) tokens_ = std::min(burst_, tokens_ + rate_hz_ * std::max(0.0, now_s - *last_s_));
  last_s_ = now_s;
  if (tokens_ < 1.0) {
    ++held_back_;
    return {};
  }
  tokens_ -= 1.0;
  return std::exchange(held_back_, 0);
}

void say(std::string_view who, std::string_view what) {
  static std::mutex mutex;
  static LineLimit limit;
  const double now_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  std::optional<std::uint64_t> held_back;
  {
    const std::lock_guard lock(mutex);
    held_back = limit.allow(now_s);
  }
  if (!held_back) return;
  const auto width = [](std::string_view text) {
    return static_cast<int>(std::min<std::size_t>(text.size(), 2000));
  };
  if (*held_back > 0)
    std::fprintf(stderr, "[%.*s] %.*s (%llu lines were held back before this one)\n", width(who), who.data(),
                 width(what), what.data(), static_cast<unsigned long long>(*held_back));
  else
    std::fprintf(stderr, "[%.*s] %.*s\n", width(who), who.data(), width(what), what.data());
}

}  // namespace omniflight::bus
