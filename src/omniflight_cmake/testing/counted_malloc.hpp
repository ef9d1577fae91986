// Counts every allocation of this test program; include in exactly one source. Sanitizers bring their own
// malloc: there nothing is counted and counted::works is false.
#pragma once

#include <cstddef>

namespace counted {
inline long allocations = 0;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool works = false;
#else
inline constexpr bool works = true;
#endif
}  // namespace counted

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
extern "C" void* __libc_malloc(std::size_t size);

extern "C" void* malloc(std::size_t size) {
  ++counted::allocations;
  return __libc_malloc(size);
}
#endif
