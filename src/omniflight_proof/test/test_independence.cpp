// The plant shares no dynamics code with the simulator: neither by targets, nor by headers, nor in the
// binaries. Each check is shown to fail where there is something to find.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

// What the scan of binaries must find in this very program.
namespace omniflight::physics {
int planted_for_the_scan() { return 1; }
}  // namespace omniflight::physics

namespace {

namespace fs = std::filesystem;
const std::vector<std::string> kForbidden{"physics", "simulation", "components", "diagnosis"};

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

/// Lines "target: everything it links, directly or through others" that name a forbidden package.
std::vector<std::string> forbidden_edges(const std::string& graph) {
  std::vector<std::string> out;
  std::istringstream lines(graph);
  for (std::string line; std::getline(lines, line);)
    for (const std::string& package : kForbidden)
      if (line.find("omniflight_" + package, line.find(':')) != std::string::npos) out.push_back(line);
  return out;
}

std::vector<std::string> forbidden_includes(const std::string& source) {
  std::vector<std::string> out;
  static const std::regex include(R"(#\s*include\s*[<"]omniflight_(\w+)/)");
  for (std::sregex_iterator it(source.begin(), source.end(), include), end; it != end; ++it)
    if (std::find(kForbidden.begin(), kForbidden.end(), (*it)[1]) != kForbidden.end())
      out.push_back(it->str());
  return out;
}

/// Mangled names of the rooms whose code a binary holds.
std::vector<std::string> forbidden_symbols(const std::string& binary) {
  std::vector<std::string> out;
  for (const std::string& name : kForbidden) {
    const std::string mangled = "N10omniflight" + std::to_string(name.size()) + name;
    if (binary.find(mangled) != std::string::npos) out.push_back(mangled);
  }
  return out;
}

TEST(Independence, NoTargetLinksTheSimulatorDirectlyOrThroughOthers) {
  const std::string graph = content(OMNIFLIGHT_TARGET_GRAPH);
  for (const char* target : {"omniflight_proof:", "omniflight_mujoco_plant:"})
    EXPECT_NE(graph.find(target), std::string::npos) << target << " is missing from\n" << graph;
  EXPECT_NE(graph.find("omniflight_vehicle::omniflight_vehicle"), std::string::npos);
  const auto bad = forbidden_edges(graph);
  EXPECT_TRUE(bad.empty()) << bad.front();
}

TEST(Independence, TheWalkFindsWhatIsLinkedThroughOthers) {
  // CMake walked a made-up target that reaches omniflight_physics through two others
  const std::string poisoned = content(OMNIFLIGHT_POISONED_GRAPH);
  ASSERT_EQ(forbidden_edges(poisoned).size(), 1u) << poisoned;
}

TEST(Independence, NoSourceIncludesTheirHeaders) {
  int files = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(OMNIFLIGHT_SOURCE_ROOT) / "src/omniflight_proof")) {
    const auto extension = entry.path().extension();
    if (extension != ".cpp" && extension != ".hpp") continue;
    ++files;
    const auto bad = forbidden_includes(content(entry.path()));
    EXPECT_TRUE(bad.empty()) << entry.path() << ": " << bad.front();
  }
  EXPECT_GT(files, 20);
  EXPECT_EQ(forbidden_includes("  #  include \"omniflight_physics/effect.hpp\"\n").size(), 1u);
}

TEST(Independence, NoBinaryHoldsTheirCode) {
  std::istringstream binaries(OMNIFLIGHT_BINARIES);
  for (std::string file; std::getline(binaries, file, ':');) {
    const std::string bytes = content(file);
    ASSERT_GT(bytes.size(), 10000u) << file;
    const auto bad = forbidden_symbols(bytes);
    EXPECT_TRUE(bad.empty()) << file << " holds " << bad.front();
  }
  EXPECT_EQ(omniflight::physics::planted_for_the_scan(), 1);
  EXPECT_EQ(forbidden_symbols(content("/proc/self/exe")).size(), 1u)
      << "the scan must find what is planted here";
}

TEST(Independence, TopicsAreThoseOfTheOtherComponents) {
  const auto topics = [](const fs::path& file) {
    std::set<std::string> out;
    const std::string text = content(file);
    static const std::regex line(R"((\w+)\s*=\s*\"(/[\w/]+)\")");
    for (std::sregex_iterator it(text.begin(), text.end(), line), end; it != end; ++it)
      out.insert((*it)[1].str() + " " + (*it)[2].str());
    return out;
  };
  const fs::path src = fs::path(OMNIFLIGHT_SOURCE_ROOT) / "src";
  const auto theirs = topics(src / "omniflight_components/include/omniflight_components/topics.hpp");
  const auto ours = topics(src / "omniflight_proof/component/topics.hpp");
  EXPECT_GE(ours.size(), 8u);
  for (const std::string& topic : ours) EXPECT_TRUE(theirs.count(topic)) << topic;
}

}  // namespace
