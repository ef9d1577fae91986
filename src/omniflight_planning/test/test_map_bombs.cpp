// Small .bt and .ot files that unfold to much: refused within 100 MB and 0.5 s, measured in a process of
// their own.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <iostream>

#include "omniflight_planning/map.hpp"

namespace omniflight::planning {
namespace {

double cpu_s(const rusage& u) {
  return static_cast<double>(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

struct Cost {
  double seconds = 0;       // of CPU, which a busy machine does not stretch
  double wall_seconds = 0;  // bounds what waits instead of computing
  double megabytes = 0;
  bool loaded = false;
};

Cost load_in_a_child(const std::filesystem::path& path) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    const auto begin = std::chrono::steady_clock::now();
    Cost cost;
    {
      const auto map = DistanceMap::load(path);
      cost.loaded = map.has_value();
      if (!map && map.error().next_step.empty())
        cost.loaded = true;  // an error without a way out does not count
    }
    getrusage(RUSAGE_SELF, &after);
    cost.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    cost.seconds = cpu_s(after) - cpu_s(before);
    cost.megabytes = static_cast<double>(after.ru_maxrss - before.ru_maxrss) / 1024.0;
    _exit(write(ends[1], &cost, sizeof cost) == sizeof cost ? 0 : 1);
  }
  close(ends[1]);
  Cost cost;
  EXPECT_EQ(read(ends[0], &cost, sizeof cost), static_cast<ssize_t>(sizeof cost));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  return cost;
}

std::string header(std::uint64_t size) {
  return "# Octomap OcTree binary file\nid OcTree\nsize " + std::to_string(size) + "\nres 0.05\ndata\n";
}

/// Every child of every node down to `depth` is there; the last level is occupied.
void full(int depth, std::string& out) {
  const std::string word(2, depth == 1 ? '\xaa' : '\xff');
  out += word;
  for (int child = 0; depth > 1 && child < 8; ++child) full(depth - 1, out);
}

std::string full_header(std::uint64_t size) {
  return "# Octomap OcTree file\nid OcTree\nsize " + std::to_string(size) + "\nres 0.05\ndata\n";
}
/// The same with log-odds, an .ot file's nodes of `depth` levels below the first.
void full_nodes(int depth, std::string& out) {
  out += std::string("\x00\x00\x80\x3f", 4) + (depth == 0 ? '\0' : '\xff');
  for (int child = 0; depth > 0 && child < 8; ++child) full_nodes(depth - 1, out);
}

std::uint64_t nodes_of(int depth) { return depth == 0 ? 1 : 1 + 8 * nodes_of(depth - 1); }

/// Two occupied voxels in opposite corners of the tree: 65536 voxels apart along every axis.
std::string two_corners() {
  std::string out = header(33);
  for (const char* chain : {"low", "high"}) {
    const bool low = chain[0] == 'l';
    for (int level = low ? 0 : 1; level < 16; ++level) {
      const bool root = level == 0, last = level == 15;
      const unsigned kind = last ? 2u : 3u, child = low ? 0u : 7u;
      unsigned word = kind << (2 * child);
      if (root) word |= 3u << 14;
      out += static_cast<char>(word & 255u);
      out += static_cast<char>(word >> 8);
    }
  }
  return out;
}

TEST(MapBombs, AreRefusedWithin100MegabytesAndHalfASecond) {
  std::string million = header(nodes_of(7)), millions = header(nodes_of(8)), chain = header(5'000'001);
  full(7, million);
  full(8, millions);
  for (int k = 0; k < 2'500'000; ++k) chain += std::string("\xff\xff", 2);
  std::string full_million = full_header(nodes_of(7)), endless = full_header(1'000'000);
  full_nodes(7, full_million);
  while (endless.size() < 15'000'000) endless += std::string("\x00\x00\x80\x3f\xff", 5);
  const struct {
    const char* what;
    std::string bytes;
  } bombs[] = {{"2.4 million nodes with log-odds", full_million},
               {"inner nodes with log-odds without an end", endless},
               {"2.4 million nodes in 0.6 MB", million},
               {"19 million nodes in 4.8 MB", millions},
               {"inner nodes without an end, 5 MB", chain},
               {"two voxels 3.3 km apart in 130 bytes", two_corners()},
               {"a header line of 15 MB", "# Octomap OcTree binary file\n" + std::string(15'000'000, 'x')},
               {"100 MB of nothing", header(10) + std::string(100'000'000, '\0')}};
  for (const auto& bomb : bombs) {
    const auto path = std::filesystem::path(testing::TempDir()) / "bomb.bt";
    std::ofstream(path, std::ios::binary) << bomb.bytes;
    const Cost cost = load_in_a_child(path);
    std::cout << bomb.what << ": " << cost.megabytes << " MB, " << cost.seconds << " s\n";
    EXPECT_FALSE(cost.loaded) << bomb.what;
    EXPECT_LT(cost.megabytes, 100) << bomb.what;
    EXPECT_LT(cost.seconds, 0.5) << bomb.what;
    EXPECT_LT(cost.wall_seconds, 5) << bomb.what;
    std::filesystem::remove(path);
  }
}

/// The largest map that is accepted stays within the same memory.
TEST(MapBombs, WhatIsAcceptedStaysWithinTheSameMemory) {
  std::string bytes = header(nodes_of(6));  // 0.3 million nodes, 64 voxels an axis
  full(6, bytes);
  // moved to the finest level: the path from the root down to level 10 has one child a node
  std::string whole = header(nodes_of(6) + 10);
  for (int level = 0; level < 10; ++level) whole += std::string("\x03\x00", 2);
  whole += bytes.substr(header(nodes_of(6)).size());
  const auto path = std::filesystem::path(testing::TempDir()) / "large.bt";
  std::ofstream(path, std::ios::binary) << whole;
  const Cost cost = load_in_a_child(path);
  std::cout << "0.3 million nodes: " << cost.megabytes << " MB, " << cost.seconds << " s\n";
  EXPECT_TRUE(cost.loaded);
  EXPECT_LT(cost.megabytes, 100);

  std::string full_bytes = full_header(nodes_of(6) + 10);
  for (int level = 0; level < 10; ++level) full_bytes += std::string("\x00\x00\x80\x3f\x01", 5);
  full_nodes(6, full_bytes);
  std::ofstream(path, std::ios::binary) << full_bytes;
  const Cost with_log_odds = load_in_a_child(path);
  std::cout << "the same with log-odds: " << with_log_odds.megabytes << " MB, " << with_log_odds.seconds
            << " s\n";
  EXPECT_TRUE(with_log_odds.loaded);
  EXPECT_LT(with_log_odds.megabytes, 100);
}

}  // namespace
}  // namespace omniflight::planning
