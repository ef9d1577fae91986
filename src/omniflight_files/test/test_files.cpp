#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>
#include <zlib.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "omniflight_files/files.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::files;

namespace {

class Files : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("omniflight_files_" + std::to_string(::getpid()));
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }
  fs::path folder;
};

std::string gzip(const std::string& text) {
  std::string out(text.size() + 200, '\0');
  z_stream s{};
  deflateInit2(&s, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  s.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  s.avail_in = static_cast<uInt>(text.size());
  s.next_out = reinterpret_cast<Bytef*>(out.data());
  s.avail_out = static_cast<uInt>(out.size());
  deflate(&s, Z_FINISH);
  out.resize(s.total_out);
  deflateEnd(&s);
  return out;
}

TEST_F(Files, AWrittenFileIsReadBackAndHashed) {
  ASSERT_TRUE(write_file_atomic(folder / "a", "abc"));
  ASSERT_TRUE(write_file_atomic(folder / "a", "abc"));
  EXPECT_EQ(read_file(folder / "a", 3).value(), "abc");
  const std::string known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";  // FIPS 180-4
  EXPECT_EQ(sha256_hex("abc"), known);
  EXPECT_EQ(sha256_file(folder / "a").value(), known);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator{}),
            1);  // no temporaries left
}

TEST_F(Files, TooLargeMissingAndSpecialFilesAreNamed) {
  ASSERT_TRUE(write_file_atomic(folder / "a", "abcd"));
  EXPECT_NE(read_file(folder / "a", 3).error().text().find("has 4 bytes, the limit is 3"), std::string::npos);
  EXPECT_NE(read_file(folder / "none", 3).error().text().find((folder / "none").string()), std::string::npos);
  EXPECT_NE(read_file("/dev/zero", 3).error().message.find("regular file"), std::string::npos);
  EXPECT_FALSE(write_file_atomic("/dev/full", "x"));
  EXPECT_FALSE(write_file_atomic(folder / "no" / "where", "x"));
  EXPECT_TRUE(fs::exists("/dev/full"));
}

TEST_F(Files, GzipIsInflatedCappedAndChecked) {
  const std::string text(100000, 'x');
  const std::string packed = gzip(text);
  EXPECT_EQ(gunzip(packed, text.size(), "a").value(), text);
  EXPECT_EQ(gunzip(packed + packed, 2 * text.size(), "a").value(), text + text);
  EXPECT_NE(gunzip(packed, 1000, "bomb").error().text().find("bomb"), std::string::npos);
  for (std::size_t cut = 0; cut < packed.size(); ++cut)
    EXPECT_FALSE(gunzip(std::string_view(packed).substr(0, cut), text.size(), "a")) << cut;
  std::string damaged = packed;
  damaged[damaged.size() - 6] = static_cast<char>(damaged[damaged.size() - 6] ^ 1);  // CRC32 of the trailer
  EXPECT_NE(gunzip(damaged, text.size(), "a").error().message.find("corrupt"), std::string::npos);
}

TEST_F(Files, AGzipBombIsRefusedWhileItUnpacks) {
  // 4 GB of zeros in 4 MB: deflate's largest ratio. Made of one member of 64 MB, repeated.
  const std::string member = gzip(std::string(64u << 20, '\0'));
  std::string bomb;
  for (int k = 0; k < 64; ++k) bomb += member;
  const auto cpu_s = [](const rusage& u) {
    return static_cast<double>(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
  };
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  const auto begin = std::chrono::steady_clock::now();
  const auto refused = gunzip(bomb, std::size_t{8} << 30, "bomb.gz");
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  getrusage(RUSAGE_SELF, &after);
  const double seconds = cpu_s(after) - cpu_s(before);  // what a busy machine does not stretch
  const double megabytes = static_cast<double>(after.ru_maxrss - before.ru_maxrss) / 1024;
  std::cout << bomb.size() << " bytes: refused after " << seconds << " s of CPU, " << megabytes
            << " MB: " << refused.error().text() << "\n";
  ASSERT_FALSE(refused);
  for (const char* word : {"bomb.gz", "MB", "100 times", "gunzip"})
    EXPECT_NE(refused.error().text().find(word), std::string::npos) << word;
  EXPECT_LT(seconds, 0.5);
  EXPECT_LT(wall, 5) << "seconds, on a machine however busy";
  EXPECT_LT(megabytes, 100);
  // a log that packs well is no bomb: 70 MB at about 40 times
  std::string log;
  for (int k = 0; log.size() < (70u << 20); ++k)
    log += std::to_string(k) + ",0.000000,1.000000,0.000000,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,\n";
  EXPECT_EQ(gunzip(gzip(log), std::size_t{1} << 30, "log").value().size(), log.size());
}

TEST_F(Files, TheEnvironmentVariableMustNameAFolder) {
  ::setenv("OMNIFLIGHT_CONFIGS", folder.c_str(), 1);
  EXPECT_EQ(config_dir().value(), folder);
  ::setenv("OMNIFLIGHT_CONFIGS", "/nowhere", 1);
  EXPECT_NE(config_dir().error().text().find("/nowhere"), std::string::npos);
  ::unsetenv("OMNIFLIGHT_CONFIGS");
}

TEST(Words, TheNearestKnownWordIsFound) {
  const std::vector<std::string> known{"mass", "inertia", "rotors"};
  EXPECT_EQ(nearest_word("mas", known), "mass");
  EXPECT_EQ(nearest_word("intertia", known), "inertia");
  EXPECT_EQ(nearest_word("zzzzzz", known), "");
}

}  // namespace
