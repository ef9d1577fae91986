// Our files as the reference implementation of MCAP and of the ROS 2 wire format sees them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

#include "sample_bag.hpp"

namespace fs = std::filesystem;

TEST(McapInterop, TheReferenceReaderAcceptsOurFileWithAllChecksums) {
  if (std::system("node --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "node is not installed";
  const char* modules = std::getenv("OMNIFLIGHT_NODE_MODULES");
  if (!modules || !fs::exists(fs::path(modules) / "@mcap/core"))
    GTEST_SKIP() << "OMNIFLIGHT_NODE_MODULES names no folder with @mcap/core, @foxglove/rosmsg, "
                    "@foxglove/rosmsg2-serialization and fzstd";
  const fs::path file =
      fs::temp_directory_path() / ("omniflight_node_" + std::to_string(::getpid()) + ".mcap");
  sample::write_flight(file, 1000, 40000);
  const fs::path script = fs::path(OMNIFLIGHT_SOURCE_ROOT) / "src/omniflight_recording/test/check_mcap.mjs";
  const auto check = [&] {
    return std::system(("node '" + script.string() + "' '" + file.string() + "'").c_str());
  };
  EXPECT_EQ(check(), 0);
  std::string bytes = sample::slurp(file);  // and the check itself can fail
  bytes[bytes.find("zstd") + 60] = static_cast<char>(bytes[bytes.find("zstd") + 60] ^ 4);
  std::ofstream(file, std::ios::binary) << bytes;
  EXPECT_NE(check(), 0);
  fs::remove(file);
}
