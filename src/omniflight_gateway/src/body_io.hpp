// Big-endian reading and writing of message bodies.
#pragma once

#include <string>
#include <string_view>

#include "omniflight_gateway/tk3_frame.hpp"

namespace omniflight::gateway {

class BodyWriter {
 public:
  explicit BodyWriter(char letter) { body.push(static_cast<std::uint8_t>(letter)); }
  BodyWriter& u8(std::uint8_t v) {
    body.push(v);
    return *this;
  }
  BodyWriter& u16(std::uint16_t v) {
    return u8(static_cast<std::uint8_t>(v >> 8)).u8(static_cast<std::uint8_t>(v));
  }
  BodyWriter& i16(std::int16_t v) { return u16(static_cast<std::uint16_t>(v)); }
  BodyWriter& u32(std::uint32_t v) {
    return u16(static_cast<std::uint16_t>(v >> 16)).u16(static_cast<std::uint16_t>(v));
  }
  BodyWriter& text(std::string_view s) {
    for (const char c : s) body.push(static_cast<std::uint8_t>(c));
    return *this;
  }
  Body body;
};

/// Reads after the letter; the caller checks left() before reading.
class BodyReader {
 public:
  explicit BodyReader(const Body& body) : bytes_(body.view()) {}
  std::size_t left() const { return bytes_.size() - at_; }
  std::uint8_t u8() { return bytes_[at_++]; }
  std::uint16_t u16() {
    const unsigned high = u8();
    return static_cast<std::uint16_t>(high << 8 | u8());
  }
  std::int16_t i16() { return static_cast<std::int16_t>(u16()); }
  std::uint32_t u32() {
    const std::uint32_t high = u16();
    return high << 16 | u16();
  }
  std::string text() {
    std::string s(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), bytes_.end());
    at_ = bytes_.size();
    return s;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 1;
};

}  // namespace omniflight::gateway
