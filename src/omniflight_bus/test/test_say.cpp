#include "omniflight_bus/say.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

namespace omniflight::bus {
namespace {

TEST(LineLimit, TenThousandASecondBecomeFifteenAndEveryOneIsCounted) {
  LineLimit limit;
  std::uint64_t said = 0, held_back = 0;
  for (int k = 0; k < 100'000; ++k)
    if (const auto before = limit.allow(1e-4 * k)) {
      ++said;
      held_back += *before;
    }
  EXPECT_GE(said, 32u + 149u);
  EXPECT_LE(said, 32u + 150u);
  const auto last = limit.allow(100.0);
  ASSERT_TRUE(last);
  EXPECT_EQ(said + held_back + *last, 100'000u);
}

TEST(LineLimit, FewLinesAreAllSaidAndAClockThatRunsBackGivesNoTokens) {
  LineLimit few;
  for (int k = 0; k < 100; ++k) EXPECT_EQ(few.allow(0.1 * k), 0u) << k;
  LineLimit back(15.0, 1.0);
  EXPECT_TRUE(back.allow(100.0));
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(back.allow(-static_cast<double>(k)));
}

TEST(Say, AStormTakesNoTimeAndTellsWhatItHeldBack) {
  using Clock = std::chrono::steady_clock;
  ::testing::internal::CaptureStderr();
  std::vector<double> took_us;
  const auto storm_begins = Clock::now();
  for (int k = 0; k < 10'000; ++k) {
    const auto begin = Clock::now();
    say("storm", "warning number " + std::to_string(k));
    took_us.push_back(1e6 * std::chrono::duration<double>(Clock::now() - begin).count());
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  say("storm", "the next one");
  const std::string said = ::testing::internal::GetCapturedStderr();
  const double lasted_s = std::chrono::duration<double>(Clock::now() - storm_begins).count();
  const auto lines = std::count(said.begin(), said.end(), '\n');
  std::sort(took_us.begin(), took_us.end());
  std::printf("10001 lines: %ld said, p99 of a call %.2f us\n", static_cast<long>(lines), took_us[9900]);
  EXPECT_GE(lines, 33);
  // 32 at once and 15 a second: a busy machine takes longer than the 0.2 s of the pause
  EXPECT_LE(static_cast<double>(lines), 32.0 + 15.0 * lasted_s + 1.0);
  EXPECT_NE(said.find("the next one ("), std::string::npos) << said.substr(said.size() - 200);
  EXPECT_NE(said.find(" lines were held back before this one)"), std::string::npos);
  EXPECT_LT(took_us[9900], 50.0) << "a control period of 1 ms is to stay unchanged";
}

}  // namespace
}  // namespace omniflight::bus
