// What a program says of itself on stderr: a storm of lines costs no time and hides no count.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace omniflight::bus {

/// Token bucket over lines: `burst` at once, `rate_hz` a second after that. Time is an argument.
class LineLimit {
 public:
  /// 15 a second, 32 at once: what NASA's core Flight Executive allows an application (EVS).
  explicit LineLimit(double rate_hz = 15.0, double burst = 32.0)
      : rate_hz_(rate_hz), burst_(burst), tokens_(burst) {}
  /// Whether a line may be said at now_s [s], and then how many were held back since the last one that was.
  std::optional<std::uint64_t> allow(double now_s);

 private:
  double rate_hz_, burst_, tokens_;
  std::optional<double> last_s_;
  std::uint64_t held_back_ = 0;
};

/// A line "[who] what" on stderr, within one LineLimit of the process. A line that comes after others were
/// held back tells how many. From any thread.
void say(std::string_view who, std::string_view what);

}  // namespace omniflight::bus
