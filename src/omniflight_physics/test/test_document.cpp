#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "omniflight_physics/document.hpp"
#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {
namespace {

TEST(Document, TheCommittedPageIsWhatTheLibrarySays) {
  std::ifstream file(OMNIFLIGHT_SOURCE_ROOT "/docs/reference/effects.md");
  ASSERT_TRUE(file) << "docs/reference/effects.md is missing";
  std::stringstream committed;
  committed << file.rdbuf();
  std::istringstream is(committed.str()), should(effects_markdown());
  std::string a, b;
  for (int line = 1; std::getline(should, b); ++line) {
    ASSERT_TRUE(std::getline(is, a))
        << "docs/reference/effects.md ends at line " << line
        << "; write it again: omniflight effects --write-docs docs/reference/effects.md";
    ASSERT_EQ(a, b) << "docs/reference/effects.md line " << line
                    << "; write it again: omniflight effects --write-docs docs/reference/effects.md";
  }
  EXPECT_FALSE(std::getline(is, a)) << "docs/reference/effects.md goes on with '" << a << "'";
}

TEST(Document, EveryEffectHasItsSectionAndItsEquation) {
  const std::string text = effects_markdown();
  for (const Effect* e : builtin_effects()) {
    EXPECT_NE(text.find("\n## " + e->info().id + "\n"), std::string::npos);
    EXPECT_NE(text.find(e->info().latex), std::string::npos) << e->info().id;
  }
}

TEST(Document, DerivationsNameEveryEffectThatActsOnTheWrench) {
  std::ifstream file(OMNIFLIGHT_SOURCE_ROOT "/docs/explanation/physics.md");
  std::stringstream text;
  text << file.rdbuf();
  for (const Effect* e : builtin_effects())
    EXPECT_NE(text.str().find("`" + e->info().id + "`"), std::string::npos)
        << "docs/explanation/physics.md says nothing about " << e->info().id;
}

}  // namespace
}  // namespace omniflight::physics
