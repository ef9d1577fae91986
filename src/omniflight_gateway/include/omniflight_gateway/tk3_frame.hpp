// Framing of the telekyb3 serial protocol: '^' body '$', with '\' + bitwise NOT for the specials ^ $ ! \ and
// '!' for "forget this frame". There is no length and no checksum: plausibility is the reader's business.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace omniflight::gateway {

inline constexpr std::size_t kMaxBody = 64;                ///< bytes, unescaped
inline constexpr std::size_t kMaxWire = 2 * kMaxBody + 2;  ///< bytes, every byte escaped plus both marks

/// Up to N bytes by value, so that neither side of the line allocates.
template <std::size_t N>
struct Bytes {
  std::array<std::uint8_t, N> data{};
  std::size_t size = 0;

  /// False, and nothing written, when full.
  bool push(std::uint8_t byte) {
    if (size == N) return false;
    data[size++] = byte;
    return true;
  }
  std::span<const std::uint8_t> view() const { return {data.data(), size}; }
};
using Body = Bytes<kMaxBody>;
using Wire = Bytes<kMaxWire>;

/// Frames a body for the line.
Wire encode_frame(const Body& body);

/// Why received bytes did not become a frame; all are counts since construction.
struct DecoderStatistics {
  std::uint64_t frames = 0;       ///< complete frames handed out
  std::uint64_t stray_bytes = 0;  ///< bytes outside any frame
  std::uint64_t restarted = 0;    ///< '^' inside a frame: the earlier one lost its end
  std::uint64_t invalidated = 0;  ///< '!' inside a frame
  std::uint64_t bad_escape = 0;   ///< '\' followed by something that is no escaped special
  std::uint64_t too_long = 0;     ///< body over kMaxBody
  std::uint64_t empty = 0;        ///< '^$'
  std::uint64_t refused() const { return restarted + invalidated + bad_escape + too_long + empty; }
};

/// Incremental decoder. Any '^' starts a frame, so that it resynchronises at the first intact frame after
/// noise.
class FrameDecoder {
 public:
  /// Feeds one byte; true when it completed a frame, which body() then holds until the next push.
  bool push(std::uint8_t byte);
  const Body& body() const { return body_; }
  const DecoderStatistics& statistics() const { return statistics_; }
  /// Forgets a frame in progress (after a reconnect); the counts stay.
  void reset() { state_ = State::outside; }

 private:
  enum class State { outside, inside, escaped };
  bool refuse(std::uint64_t& count);

  State state_ = State::outside;
  Body body_;
  DecoderStatistics statistics_;
};

}  // namespace omniflight::gateway
