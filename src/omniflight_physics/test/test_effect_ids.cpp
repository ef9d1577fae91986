// The names that other packages have for effects.
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>

#include "omniflight_physics/effect.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::physics {
namespace {

TEST(EffectIds, EachIsTheIdOfAnEffectAndOfThatName) {
  std::ifstream header(OMNIFLIGHT_SOURCE_ROOT
                       "/src/omniflight_physics/include/omniflight_physics/effect_ids.hpp");
  ASSERT_TRUE(header);
  const std::regex constant(R"re(inline constexpr const char\* (\w+) = "(\w+)";)re");
  std::set<std::string> seen;
  int declared = 0;
  for (std::string line; std::getline(header, line);) {
    declared += line.starts_with("inline constexpr");
    std::smatch match;
    if (!std::regex_match(line, match, constant)) continue;
    EXPECT_EQ(match[1], match[2]);
    EXPECT_NE(find_effect(match[2]), nullptr) << match[2] << " is no effect of the library";
    EXPECT_TRUE(seen.insert(match[2]).second) << match[2] << " is there twice";
  }
  EXPECT_EQ(static_cast<int>(seen.size()), declared) << "a line that this test does not read";
  EXPECT_TRUE(seen.contains(effect_id::payload_mass));
}

}  // namespace
}  // namespace omniflight::physics
