// The control loop's own clock: what it misses is counted and left out, and no step of the system clock moves
// it.
#include <gtest/gtest.h>

#include <sys/mman.h>

#include "../src/page_faults.hpp"
#include "../src/period_keeper.hpp"

namespace omniflight::components {
namespace {

TEST(PeriodKeeper, CountsWholeMissedPeriodsAndLeavesThemOut) {
  const WallPace pace;
  PeriodKeeper keeper(pace, 0.02);
  for (int k = 0; k < 3; ++k) keeper.wait();
  const std::uint64_t before = keeper.missed();
  std::this_thread::sleep_for(std::chrono::milliseconds(110));  // five periods and a half
  keeper.wait();
  EXPECT_GE(keeper.missed() - before, 4u);
  EXPECT_GE(keeper.longest_late_s(), 0.08);
  const double t0 = pace.now();
  keeper.wait();
  EXPECT_GT(pace.now() - t0, 0.0005) << "no burst of the periods that were missed";
  EXPECT_EQ(keeper.periods() - keeper.missed(), 5u);
}

TEST(WallPace, CountsFromAnEpochOfTheMonotonicClock) {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  const WallPace pace(std::chrono::nanoseconds(now).count() - 5'000'000'000);
  EXPECT_GE(pace.now(), 5.0);
  EXPECT_LT(pace.now(), 6.0);
}

/// Maps pages and touches each for the first time, which faults once a page.
void fault(std::size_t pages) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* memory = mmap(nullptr, pages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  ASSERT_EQ(madvise(memory, pages * page, MADV_NOHUGEPAGE), 0);
  for (std::size_t k = 0; k < pages; ++k) static_cast<volatile char*>(memory)[k * page] = 1;
  munmap(memory, pages * page);
}

TEST(LoopPageFaults, CountsWhatComesBetweenBeginAndEnd) {
  LoopPageFaults faults;
  fault(50);
  EXPECT_EQ(faults.count(), 0u) << "not begun";
  faults.begin();
  fault(20);
  EXPECT_GE(faults.count(), 20u);
#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(faults.count(), 40u) << "a sanitizer touches memory of its own";
#endif
  faults.end();
  const auto counted = faults.count();
  fault(50);
  faults.end();
  EXPECT_EQ(faults.count(), counted) << "what follows the loop is not the loop's";
}

}  // namespace
}  // namespace omniflight::components
