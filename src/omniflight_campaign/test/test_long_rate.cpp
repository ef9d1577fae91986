// How many flights of a minute one core flies in a second, by processor time: other work on the machine
// counts little.
#include <gtest/gtest.h>

#include <ctime>

#include "hovering.hpp"

namespace omniflight::campaign {
namespace {

TEST(Rate, ThirtyFlightsOfAMinuteASecond) {
  const Loop loop = hovering(57.8);
  std::vector<OneFlight> flights;
  for (int k = 0; k < 64; ++k)
    flights.push_back(one(loop, {{"payload_mass", {0.003 * k}}, {"wind", {0.02 * k, 0, 0.02}}}));
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  const double begin = now();
  ASSERT_TRUE(fly_many(loop, flights));
  const double rate = 64 / (now() - begin);
  std::printf("%.1f flights of %.1f s a second of processor time\n", rate, loop.duration);
  EXPECT_GE(rate, 30);
}

}  // namespace
}  // namespace omniflight::campaign
