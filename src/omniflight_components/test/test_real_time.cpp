// Memory of the control loop is in RAM before the loop begins, also where it grows in the heap of another
// thread.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <latch>
#include <thread>
#include <vector>

#include "../src/page_faults.hpp"
#include "../src/real_time.hpp"

namespace omniflight::components {
namespace {

constexpr std::size_t kBlocks = 256, kSmall = 128, kGrown = 4096;

/// Page faults of a real-time thread that grows blocks of another thread, as the middleware does which reuses
/// blocks of its receiving threads. Those have allocated before the loop began, or do so first afterwards.
std::uint64_t faults_of_growing(bool late_receiver) {
  std::vector<void*> blocks(kBlocks);
  std::latch ready(1), allocated(1), done(1);
  std::thread receiver([&] {
    if (late_receiver) ready.wait();
    for (void*& block : blocks) block = std::malloc(kSmall);
    allocated.count_down();
    done.wait();
  });
  if (!late_receiver) allocated.wait();
  std::uint64_t faults = 0;
  std::thread loop([&] {
    ask_for_real_time("test");
    ready.count_down();
    allocated.wait();
    LoopPageFaults counted;
    counted.begin();
    for (void*& block : blocks) {
      block = std::realloc(block, kGrown);
      std::memset(block, 1, kGrown);
    }
    counted.end();
    faults = counted.count();
  });
  loop.join();
  done.count_down();
  receiver.join();
  for (void* block : blocks) std::free(block);
  std::printf("%zu blocks of another thread grown to %zu bytes: %lu page faults\n", kBlocks, kGrown,
              static_cast<unsigned long>(faults));
  return faults;
}

class RealTime : public testing::TestWithParam<bool> {};

TEST_P(RealTime, BlocksOfAnotherThreadGrowWithoutPageFaults) {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "a sanitizer has an allocator of its own";
#endif
  if (geteuid() != 0) GTEST_SKIP() << "memory is not locked";
  widen_thread_heaps();
  EXPECT_LE(faults_of_growing(GetParam()), 10u);
}
INSTANTIATE_TEST_SUITE_P(Heaps, RealTime, testing::Values(false, true),
                         [](const auto& which) { return which.param ? "MadeLater" : "MadeBefore"; });

}  // namespace
}  // namespace omniflight::components
