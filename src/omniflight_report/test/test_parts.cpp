#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <sstream>

#include "omniflight_report/decimate.hpp"
#include "omniflight_report/escape.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::report {
namespace {

namespace fs = std::filesystem;

std::vector<std::size_t> kept(std::span<const double> y, std::size_t samples) {
  return kept_samples(std::vector{y}, samples);
}

TEST(Decimate, KeepsASingleSpikeAndTheEnds) {
  std::vector<double> y(100'000, 0.0);
  y[54'321] = 7.0;
  y[54'400] = -3.0;
  const auto indices = kept(y, 3000);
  EXPECT_LE(indices.size(), 3000u);
  EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
  EXPECT_EQ(std::adjacent_find(indices.begin(), indices.end()), indices.end());
  EXPECT_EQ(indices.front(), 0u);
  EXPECT_EQ(indices.back(), y.size() - 1);
  for (const std::size_t spike : {54'321u, 54'400u})
    EXPECT_TRUE(std::binary_search(indices.begin(), indices.end(), spike));
}

TEST(Decimate, KeepsAGapOfOneSample) {
  std::vector<double> y(50'000);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = std::sin(0.01 * static_cast<double>(i));
  y[777] = std::nan("");
  const auto indices = kept(y, 3000);
  EXPECT_LE(indices.size(), 3000u);
  EXPECT_TRUE(std::binary_search(indices.begin(), indices.end(), std::size_t{777}));
}

TEST(Decimate, KeepsTheExtremesOfEveryChannel) {
  std::vector<double> y(20'000, 0.0), low(20'000, -1.0), high(20'000, 1.0);
  low[9'999] = -5.0;
  high[10'001] = 5.0;
  const auto indices = kept_samples(std::vector<std::span<const double>>{y, low, high}, 800);
  EXPECT_LE(indices.size(), 800u);
  for (const std::size_t i : {9'999u, 10'001u})
    EXPECT_TRUE(std::binary_search(indices.begin(), indices.end(), i));
}

TEST(Decimate, LeavesAShortSeriesAlone) { EXPECT_EQ(kept(std::vector<double>(12, 1.0), 12).size(), 12u); }

TEST(Escape, RefusesMalformedUtf8AndKeepsTheRest) {
  EXPECT_EQ(escape_html("\u03BB<\"'&>"), "\u03BB&lt;&quot;&#39;&amp;&gt;");
  EXPECT_EQ(escape_html("\xC0\xAF\xE2\x28\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD(\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(json_string("a</script>\"\\\n"), "\"a\\u003c/script\\u003e\\\"\\\\\\n\"");
}

TEST(Escape, NumbersKeepTheResolutionOfTheirRange) {
  EXPECT_EQ(json_array(std::vector<double>{0.0, 0.5, INFINITY}), "[0,0.5,null]");
  EXPECT_EQ(json_array(std::vector<double>{1.7e9, 1.7e9 + 0.001, 1.7e9 + 10.0}),
            "[1700000000,1700000000.001,1700000010]");
  EXPECT_EQ(number_html(0.0123456, 3), "0.0123");
  EXPECT_EQ(number_html(-9.9999, 3), "-10.0");
  EXPECT_EQ(number_html(1.7e-5, 2), "1.7\u00D710<sup>-5</sup>");
  EXPECT_EQ(number_html(std::nan("")).find("nan"), std::string::npos);
}

class WriteFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("omniflight_report_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string content(const fs::path& path) {
    std::stringstream out;
    out << std::ifstream(path).rdbuf();
    return out.str();
  }
  std::size_t files() { return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {})); }
  fs::path folder_;
};

TEST_F(WriteFile, ReplacesTheOldPageWithTheWholeNewOne) {
  const fs::path path = folder_ / "report.html";
  std::ofstream(path) << "old";
  ASSERT_TRUE(Page("New", "page").write(path));
  EXPECT_NE(content(path).find("</html>"), std::string::npos);
  EXPECT_EQ(files(), 1u);
}

TEST_F(WriteFile, AFullDeviceIsAnErrorAndStaysADevice) {
  const auto status = Page("Full", "").write("/dev/full");
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().text().find("/dev/full"), std::string::npos);
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

// A limit on the size of files stands in for a disk that fills up in the middle of the page.
TEST_F(WriteFile, AnInterruptedWriteLeavesTheOldPageAndNothingElse) {
  const fs::path path = folder_ / "report.html";
  std::ofstream(path) << "old";
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto status = Page("Too long", std::string(100'000, 'x')).write(path);
  ::setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().text().find("cannot be written"), std::string::npos);
  EXPECT_EQ(content(path), "old");
  EXPECT_EQ(files(), 1u);
}

TEST_F(WriteFile, TakesARelativePath) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  const auto status = Page("Relative", "").write("report.html");
  fs::current_path(before);
  EXPECT_TRUE(status) << status.error().text();
  EXPECT_NE(content(folder_ / "report.html").find("</html>"), std::string::npos);
}

TEST_F(WriteFile, AMissingFolderIsNamed) {
  const auto status = Page("Nowhere", "").write(folder_ / "no" / "report.html");
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().text().find((folder_ / "no" / "report.html").string()), std::string::npos);
  EXPECT_NE(status.error().text().find("Check that the folder exists"), std::string::npos);
}

}  // namespace
}  // namespace omniflight::report
