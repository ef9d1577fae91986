// Memory that is read at random: in large pages where the system has them, because looking up the address of
// a small page costs as much as the read, and twice that in a virtual machine.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>

namespace omniflight::planning {

/// For std::vector. Less than a quarter of a large page is left to the common heap.
template <class T>
struct LargePages {
  using value_type = T;
  static constexpr std::size_t kPage = std::size_t{2} << 20;  // bytes, of x86-64 and most of aarch64

  LargePages() = default;
  template <class U>
  LargePages(const LargePages<U>&) {}

  T* allocate(std::size_t n) {
    if (!is_large(n)) return static_cast<T*>(::operator new(n * sizeof(T), std::align_val_t(alignof(T))));
    if (n > static_cast<std::size_t>(-1) / sizeof(T) - 1) throw std::bad_alloc();
    const std::size_t bytes = (n * sizeof(T) + kPage - 1) / kPage * kPage;
    void* memory = std::aligned_alloc(kPage, bytes);
    if (memory == nullptr) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
    (void)madvise(memory, bytes, MADV_HUGEPAGE);  // a wish: without them it is only slower
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t n) {
    if (is_large(n))
      std::free(memory);
    else
      ::operator delete(memory, std::align_val_t(alignof(T)));
  }
  template <class U>
  bool operator==(const LargePages<U>&) const {
    return true;
  }

 private:
  static bool is_large(std::size_t n) { return n > kPage / 4 / sizeof(T); }
};

}  // namespace omniflight::planning
