#include "real_time.hpp"

#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace omniflight::components {
namespace {

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

/// A line of /proc/self/maps.
struct Mapping {
  std::uintptr_t begin = 0, end = 0;
  std::string rights, name;  ///< "rw-p"; a file, "[heap]", or nothing
  bool of_file = false;
};

std::vector<Mapping> mappings() {
  std::vector<Mapping> out;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    Mapping m;
    char dash = 0;
    std::string offset, device;
    std::uint64_t inode = 0;
    std::istringstream fields(line);
    fields >> std::hex >> m.begin >> dash >> m.end >> m.rights >> offset >> device >> std::dec >> inode;
    fields >> m.name;
    m.of_file = inode != 0;
    if (m.rights.size() == 4) out.push_back(std::move(m));
  }
  return out;
}

/// Brings programs, libraries and every heap into RAM. A heap of a thread can be recognised by its address,
/// which glibc aligns to the largest size of one (malloc/arena.c, HEAP_MAX_SIZE). Stacks stay as they are: of
/// their 8 MB little is used. Linux before 5.14 has no such call, and pages come when they are first used.
void populate_memory() {
#ifdef MADV_POPULATE_WRITE
  if (kSanitized) return;
  constexpr std::uintptr_t kHeapAlignment = 64u << 20;
  for (const Mapping& m : mappings()) {
    const bool writable = m.rights[1] == 'w', is_private = m.rights[3] == 'p';
    const bool heap = m.name == "[heap]" || (m.name.empty() && m.begin % kHeapAlignment == 0);
    if (m.rights[0] != 'r' || !is_private || !(m.of_file || (writable && heap))) continue;
    (void)madvise(reinterpret_cast<void*>(m.begin), m.end - m.begin,
                  writable ? MADV_POPULATE_WRITE : MADV_POPULATE_READ);
  }
#endif
}

/// Touches the memory that the calling thread will ask for, and lets the allocator keep it: what is returned
/// to the system has to be faulted in again, in the middle of a period.
void fault_memory_in() {
  constexpr std::size_t kHeap = 16u << 20, kBlock = 64u << 10, kStack = 256u << 10;
  mallopt(M_TRIM_THRESHOLD, 512 << 20);
  mallopt(M_MMAP_MAX, 0);
  std::vector<std::vector<char>> heap;
  heap.reserve(kHeap / kBlock);
  for (std::size_t taken = 0; taken < kHeap; taken += kBlock) heap.emplace_back(kBlock, '\1');
  char stack[kStack];
  explicit_bzero(stack, kStack);  // is never optimised away
}

}  // namespace

void widen_thread_heaps() {
  // The middleware keeps up to 512 unacknowledged messages of each of two topics, of 4 kB each. It reuses
  // blocks that another thread has allocated, and lets them grow in the heap of that thread.
  mallopt(M_TOP_PAD, 4 << 20);
}

void ask_for_real_time(const char* name) {
  constexpr int kPriority = 20;  // above the components' SCHED_RR 10, below the kernel's threads at 50
  const sched_param priority{.sched_priority = kPriority};
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority); error != 0)
    std::fprintf(stderr, "[%s] no real-time priority (%s): periods may be missed under load\n", name,
                 std::strerror(error));
  rlimit limit{};
  // With a limit later allocations would fail instead.
  const bool unlimited =
      geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
  // What exists is locked when it is used: of a stack of 8 MB little is. What is mapped later, such as the
  // heap of a thread that has not allocated yet, comes into RAM at once; not the shadow memory of a
  // sanitizer, which is larger than any RAM.
  constexpr int kFuture = kSanitized ? MCL_FUTURE | MCL_ONFAULT : MCL_FUTURE;
  if (!unlimited || mlockall(MCL_CURRENT | MCL_ONFAULT) != 0 || mlockall(kFuture) != 0)
    std::fprintf(stderr, "[%s] memory is not locked (%s)\n", name,
                 unlimited ? std::strerror(errno) : "limit memlock");
  populate_memory();
  fault_memory_in();
}

}  // namespace omniflight::components
