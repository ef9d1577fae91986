// Bounds-checked reading of little-endian bytes: after the first overrun everything reads as zero and ok() is
// false.
#pragma once

#include <cstdint>
#include <cstring>
#include <string_view>

namespace omniflight::recording {

class ByteCursor {
 public:
  explicit ByteCursor(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  T get() {
    T value{};
    if (left() < sizeof(T)) {
      ok_ = false;
      at_ = bytes_.size();
      return value;
    }
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  std::string_view take(std::uint64_t count) {
    if (left() < count) {
      ok_ = false;
      at_ = bytes_.size();
      return {};
    }
    const auto out = bytes_.substr(at_, static_cast<std::size_t>(count));
    at_ += static_cast<std::size_t>(count);
    return out;
  }
  /// u32 length, then that many bytes.
  std::string_view string() { return take(get<std::uint32_t>()); }
  /// Up to the next zero byte, which is consumed.
  std::string_view zero_terminated(std::size_t max) {
    const auto end = bytes_.substr(at_, max + 1).find('\0');
    if (end == std::string_view::npos) {
      ok_ = false;
      at_ = bytes_.size();
      return {};
    }
    const auto out = bytes_.substr(at_, end);
    at_ += end + 1;
    return out;
  }
  std::size_t at() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }
  bool ok() const { return ok_; }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace omniflight::recording
