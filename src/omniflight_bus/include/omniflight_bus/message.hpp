// Owning a C message: RAII, and access to its strings and sequences. Every byte a Message owns is freed with
// it.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

#include "omniflight_msgs/types.hpp"

namespace omniflight::bus {

namespace detail {
void free_contents(const msgs::MessageType& type, void* sample);
void* reallocate_zeroed(void* buffer, std::size_t old_bytes, std::size_t new_bytes);
}  // namespace detail

/// A zero-initialised message that frees its strings and sequences. Moves, never copies.
template <class T>
class Message {
 public:
  Message() = default;
  ~Message() { detail::free_contents(msgs::TypeSupport<T>::type(), &value_); }
  Message(const Message&) = delete;
  Message& operator=(const Message&) = delete;
  Message(Message&& other) noexcept : value_(other.value_) { other.value_ = T{}; }
  Message& operator=(Message&& other) noexcept {
    std::swap(value_, other.value_);
    return *this;
  }
  T& operator*() { return value_; }
  const T& operator*() const { return value_; }
  T* operator->() { return &value_; }
  const T* operator->() const { return &value_; }

 private:
  T value_{};
};

/// The text of a string field; empty for a null one.
inline std::string_view text(const char* field) {
  return field == nullptr ? std::string_view() : std::string_view(field);
}

/// Sets a string field of a Message; allocates only when the text is longer than the present one.
void set_text(char*& field, std::string_view value);

template <class Sequence>
using Element = std::remove_pointer_t<decltype(Sequence::_buffer)>;

/// The elements of a sequence field.
template <class Sequence>
std::span<Element<Sequence>> view(Sequence& sequence) {
  return {sequence._buffer, sequence._buffer == nullptr ? 0u : sequence._length};
}
template <class Sequence>
std::span<const Element<Sequence>> view(const Sequence& sequence) {
  return {sequence._buffer, sequence._buffer == nullptr ? 0u : sequence._length};
}

/// Sets the length of a sequence field of a Message; new elements are zero, present ones stay. Allocates only
/// to grow beyond the largest length so far.
template <class Sequence>
void resize(Sequence& sequence, std::size_t length) {
  const auto n = static_cast<std::uint32_t>(length);
  if (n > sequence._maximum) {
    constexpr std::size_t size = sizeof(Element<Sequence>);
    sequence._buffer = static_cast<Element<Sequence>*>(
        detail::reallocate_zeroed(sequence._buffer, sequence._maximum * size, n * size));
    sequence._maximum = n;
    sequence._release = true;
  }
  sequence._length = n;
}

/// Copies numbers into a sequence field of a Message.
template <class Sequence>
requires std::is_arithmetic_v<Element<Sequence>>
void assign(Sequence& sequence, std::span<const std::type_identity_t<Element<Sequence>>> values) {
  resize(sequence, values.size());
  for (std::size_t i = 0; i < values.size(); ++i) sequence._buffer[i] = values[i];
}

using Time = msgs::builtin_interfaces::Time;

/// Nanoseconds since the epoch of the clock in use; a stamp holds 0 ... 2^31 s.
inline std::int64_t nanoseconds(const Time& stamp) {
  return static_cast<std::int64_t>(stamp.sec) * 1'000'000'000 + static_cast<std::int64_t>(stamp.nanosec);
}
inline Time stamp(std::int64_t ns) {
  const std::int64_t fraction = ((ns % 1'000'000'000) + 1'000'000'000) % 1'000'000'000;
  Time out;
  out.sec = static_cast<std::int32_t>((ns - fraction) / 1'000'000'000);
  out.nanosec = static_cast<std::uint32_t>(fraction);
  return out;
}

}  // namespace omniflight::bus
