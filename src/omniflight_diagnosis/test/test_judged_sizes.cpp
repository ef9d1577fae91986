// What the stages beside the wrench find is as probable as its size or its count makes it.
#include <gtest/gtest.h>

#include <cmath>

#include "../src/numerics/log_factor.hpp"
#include "../src/report/other_stages.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

Finding repeated(int samples, int rivals) {
  Finding f;
  f.effect = "stale_samples";
  f.log_factor = log_factor_of_repeats(samples);
  f.rivals = rivals;
  return f;
}

TEST(Judged, CountsMakeAFaultWithoutASizeProbable) {
  std::vector<Finding> f{repeated(0, 0), repeated(8, 0), repeated(200, 0)};
  judge_sizes(test::omnimorph(), {}, f);
  EXPECT_LT(f[0].probability, 0.1) << "nothing counted: its prior";
  // every sample doubles the odds
  const auto odds = [](double p) { return p / (1 - p); };
  EXPECT_NEAR(odds(f[1].probability) / odds(f[0].probability), 256, 1e-6);
  EXPECT_GT(f[2].probability, 0.999);
}

TEST(Judged, RivalsThatShowAlikeShareWhatIsThere) {
  std::vector<Finding> f{repeated(200, 0), repeated(200, 1), repeated(200, 2)};
  judge_sizes(test::omnimorph(), {}, f);
  EXPECT_NEAR(f[1].probability, f[0].probability / 2, 1e-12);
  EXPECT_NEAR(f[2].probability, f[0].probability / 3, 1e-12);
  // one of two is said, with half of the probability
  Diagnosis others, d;
  others.findings = {f[1]};
  add_judged(others, test::omnimorph(), {}, d);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_NEAR(d.findings[0].probability, 0.5, 1e-3);
}

TEST(Judged, ASizeWithinItsErrorIsRefused) {
  Finding f;
  f.effect = "clock_offset";
  f.parameters = {{"offset", "t_d", "s", 0.001, 0.001 - 1.96 * 0.002, 0.001 + 1.96 * 0.002}};
  Diagnosis others, d;
  others.findings = {f};
  add_judged(others, test::omnimorph(), {}, d);
  EXPECT_TRUE(d.findings.empty());
  ASSERT_EQ(d.decisions.size(), 1u);
  EXPECT_EQ(d.decisions[0].outcome, "refused");
}

}  // namespace
}  // namespace omniflight::diagnosis
