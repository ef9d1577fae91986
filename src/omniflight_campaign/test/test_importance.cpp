// Indices against functions whose indices are known.
#include <gtest/gtest.h>

#include <cmath>

#include "omniflight_campaign/importance.hpp"
#include "omniflight_core/frames.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::campaign {
namespace {

struct Sample {
  std::vector<std::vector<double>> x;
  std::vector<double> y;
};

template <class Function>
Sample sample(std::size_t n, std::size_t parameters, Function f, std::uint64_t seed = 1) {
  Random random(seed);
  Sample s;
  s.x.resize(parameters);
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<double> one;
    for (std::size_t k = 0; k < parameters; ++k) {
      one.push_back(random.uniform());
      s.x[k].push_back(one[k]);
    }
    s.y.push_back(f(one));
  }
  return s;
}

TEST(Importance, OfASumIsTheShareOfItsVariance) {
  // the sum of three uniform numbers with weights 4, 2, 0; its ranks are nearly a linear function of it
  const Sample s = sample(4000, 3, [](auto& x) { return 4 * x[0] + 2 * x[1]; });
  const ImportanceResult r = importance(s.x, s.y);
  ASSERT_EQ(r.of.size(), 3u);
  EXPECT_NEAR(r.of[0].first_order.value, 0.8, 0.05);
  EXPECT_NEAR(r.of[1].first_order.value, 0.2, 0.05);
  EXPECT_NEAR(r.of[2].first_order.value, 0.0, 0.02);
  for (const Importance& i : r.of) {
    EXPECT_LT(i.first_order.low, i.first_order.value);
    EXPECT_GT(i.first_order.high, i.first_order.value);
  }
  EXPECT_GT(r.of[0].rank_coefficient, 0.85);
  EXPECT_GT(r.explained_by_ranks, 0.95);
}

TEST(Importance, OfACurveThatTurnsIsSeenByBinsAndNotByRanks) {
  const Sample s = sample(2000, 2, [](auto& x) { return std::pow(x[0] - 0.5, 2) + 0.01 * x[1]; });
  const ImportanceResult r = importance(s.x, s.y);
  EXPECT_GT(r.of[0].first_order.value, 0.9);
  EXPECT_LT(std::abs(r.of[0].rank_coefficient), 0.1);
  EXPECT_LT(r.explained_by_ranks, 0.2);
}

TEST(Importance, OfAnInteractionIsInNoFirstOrderIndex) {
  const Sample s = sample(4000, 2, [](auto& x) { return (x[0] - 0.5) * (x[1] - 0.5); });
  const ImportanceResult r = importance(s.x, s.y);
  EXPECT_LT(r.of[0].first_order.value + r.of[1].first_order.value, 0.1);
}

TEST(Importance, ItsIntervalCoversNothingWhereThereIsNothing) {
  int covers = 0;
  double mean = 0;
  constexpr int kTimes = 100;
  for (int k = 0; k < kTimes; ++k) {
    const Sample s = sample(
        300, 2, [](auto& x) { return x[1]; }, static_cast<std::uint64_t>(k + 1));
    const Estimate e = importance(s.x, s.y, static_cast<std::uint64_t>(k)).of[0].first_order;
    covers += e.low <= 0 && 0 <= e.high;
    mean += e.value / kTimes;
  }
  EXPECT_GE(covers, 88);
  EXPECT_NEAR(mean, 0, 0.01) << "what bins explain by chance is taken out";
}

TEST(Importance, NeedsFlightsThatDiffer) {
  EXPECT_TRUE(
      importance(sample(10, 1, [](auto& x) { return x[0]; }).x, std::vector<double>(10, 1)).of.empty());
  const Sample s = sample(100, 1, [](auto&) { return 3.0; });
  EXPECT_TRUE(importance(s.x, s.y).of.empty());
}

}  // namespace
}  // namespace omniflight::campaign
