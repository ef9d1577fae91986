// Bounded reading and plain writing of little-endian bytes.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <omniflight_core/result.hpp>
#include <span>
#include <string>
#include <vector>

#include "omniflight_gateway/natnet_packet.hpp"

namespace omniflight::gateway {

static_assert(std::endian::native == std::endian::little);

/// Versions of the protocol in which the frame's layout changed
inline constexpr NatNetVersion k29{2, 9}, k211{2, 11}, k30{3, 0}, k40{4, 0}, k41{4, 1}, k42{4, 2};

/// After the first error everything reads as zero; look at status() once.
class NatNetReader {
 public:
  NatNetReader(std::span<const std::byte> bytes, const char* what) : bytes_(bytes), what_(what) {}

  template <class T>
  T take(const char* field) {
    T value{};
    if (!need(sizeof(T), field)) return value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  /// A finite number no larger than `most`.
  double number(const char* field, double most = 1e6) {
    const double value = take<float>(field);
    if (!(std::abs(value) <= most)) fail_at(field, "is no number, or far too large");
    return ok() ? value : 0.0;
  }
  /// How many items of at least `least` bytes follow.
  std::size_t count(const char* field, std::size_t least) {
    const auto n = take<std::int32_t>(field);
    if (n < 0 || n > kMost || static_cast<std::size_t>(n) * least > left())
      fail_at(field, "counts " + std::to_string(n) + " items, more than the packet holds");
    return ok() ? static_cast<std::size_t>(n) : 0;
  }
  /// The bytes that a section says it has.
  std::size_t size(const char* field) {
    const auto n = take<std::int32_t>(field);
    if (n < 0 || static_cast<std::size_t>(n) > left()) fail_at(field, "is longer than the packet");
    return ok() ? static_cast<std::size_t>(n) : 0;
  }
  void skip(std::size_t n, const char* field) {
    if (need(n, field)) at_ += n;
  }
  /// Characters up to a zero byte, which is taken.
  std::string text(const char* field, std::size_t longest = 256) {
    for (std::size_t n = 0; n < std::min(longest, left()); ++n)
      if (bytes_[at_ + n] == std::byte{0}) {
        std::string out(reinterpret_cast<const char*>(bytes_.data() + at_), n);
        at_ += n + 1;
        return out;
      }
    fail_at(field, "is a name without an end");
    return {};
  }
  void fail_at(const char* field, const std::string& why) {
    if (ok()) error_ = std::string(field) + " " + why, error_at_ = at_;
  }
  bool ok() const { return error_.empty(); }
  std::size_t at() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }
  Status status() const {
    if (ok()) return {};
    return bad_input(
        error_, std::string(what_) + ", byte " + std::to_string(error_at_),
        "See whether the version of the bit stream is the server's, or let it be asked for (version: auto)");
  }

 private:
  static constexpr std::int32_t kMost = 10000;
  bool need(std::size_t n, const char* field) {
    if (ok() && n > left()) fail_at(field, "is cut off");
    return ok();
  }
  std::span<const std::byte> bytes_;
  const char* what_;
  std::size_t at_ = 0, error_at_ = 0;
  std::string error_;
};

template <class T>
void natnet_put(std::vector<std::byte>& out, T value) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), bytes, bytes + sizeof(T));
}
inline void natnet_put(std::vector<std::byte>& out, const std::string& text) {
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
  out.push_back(std::byte{0});
}

}  // namespace omniflight::gateway
