// Who may say what on a secured bus: commands, ticks and wishes have one kind of author each.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "omniflight_components/components.hpp"
#include "omniflight_components/rights.hpp"
#include "omniflight_components/topics.hpp"

namespace omniflight::components {
namespace {

std::set<std::string> who_says(const std::string& topic) {
  std::set<std::string> out;
  for (const auto& [role, rights] : rights_of_roles())
    if (std::count(rights.publish.begin(), rights.publish.end(), topic) > 0) out.insert(role);
  return out;
}

TEST(Rights, EveryComponentHasARole) {
  for (const std::string& name : component_names()) EXPECT_TRUE(rights_of_roles().contains(name)) << name;
}

TEST(Rights, OneKindOfAuthorATopic) {
  using Roles = std::set<std::string>;
  EXPECT_EQ(who_says(topics::command), (Roles{"allocator", "container"}));
  EXPECT_EQ(who_says(topics::lost_rotors), (Roles{"allocator", "container"}));
  EXPECT_EQ(who_says(topics::wish), (Roles{"operator"}));
  EXPECT_EQ(who_says(topics::mission), (Roles{"operator"}));
  EXPECT_EQ(who_says(topics::gate), (Roles{"gateway", "container"}));
  EXPECT_EQ(who_says(topics::failsafe), (Roles{"controller", "container"}));
  EXPECT_EQ(who_says(topics::transforms), (Roles{"controller", "container"}));
  EXPECT_EQ(who_says(topics::joints), (Roles{"allocator", "container"}));
  EXPECT_EQ(who_says(topics::robot_description), (Roles{"allocator", "container"}));
  EXPECT_EQ(who_says(topics::tick), (Roles{"gateway", "simulator", "mujoco_plant", "container"}));
  EXPECT_EQ(who_says(topics::mocap), (Roles{"emulator", "natnet", "simulator", "mujoco_plant", "container"}));
}

TEST(Rights, NobodySaysEverything) {
  for (const auto& [role, rights] : rights_of_roles())
    EXPECT_EQ(std::count(rights.publish.begin(), rights.publish.end(), "*"), 0) << role;
}

TEST(Rights, WhatIsRecordedHasAnAuthor) {
  for (const auto& entry : topics::recorded) EXPECT_FALSE(who_says(entry.topic).empty()) << entry.topic;
}

}  // namespace
}  // namespace omniflight::components
