#include "omniflight_gateway/tk3_frame.hpp"

namespace omniflight::gateway {
namespace {

constexpr std::uint8_t kStart = '^';
constexpr std::uint8_t kEnd = '$';
constexpr std::uint8_t kInvalid = '!';
constexpr std::uint8_t kEscape = '\\';

constexpr bool is_special(std::uint8_t c) {
  return c == kStart || c == kEnd || c == kInvalid || c == kEscape;
}
constexpr std::uint8_t invert(std::uint8_t c) { return static_cast<std::uint8_t>(~c); }

}  // namespace

Wire encode_frame(const Body& body) {
  Wire wire;
  wire.push(kStart);
  for (const std::uint8_t c : body.view()) {
    if (is_special(c)) {
      wire.push(kEscape);
      wire.push(invert(c));
    } else {
      wire.push(c);
    }
  }
  wire.push(kEnd);
  return wire;
}

bool FrameDecoder::refuse(std::uint64_t& count) {
  ++count;
  state_ = State::outside;
  return false;
}

bool FrameDecoder::push(std::uint8_t byte) {
  if (byte == kStart) {
    if (state_ != State::outside) ++statistics_.restarted;
    state_ = State::inside;
    body_.size = 0;
    return false;
  }
  if (state_ == State::outside) {
    ++statistics_.stray_bytes;
    return false;
  }
  if (byte == kInvalid) return refuse(statistics_.invalidated);
  if (state_ == State::escaped) {
    if (!is_special(invert(byte))) return refuse(statistics_.bad_escape);
    state_ = State::inside;
    return body_.push(invert(byte)) ? false : refuse(statistics_.too_long);
  }
  if (byte == kEscape) {
    state_ = State::escaped;
    return false;
  }
  if (byte == kEnd) {
    if (body_.size == 0) return refuse(statistics_.empty);
    state_ = State::outside;
    ++statistics_.frames;
    return true;
  }
  return body_.push(byte) ? false : refuse(statistics_.too_long);
}

}  // namespace omniflight::gateway
