// Small files that unpack, or claim to unpack, into very much: what each costs in memory and processor time.
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zstd.h>

#include "../src/mcap_records.hpp"
#include "sample_bag.hpp"
#include "sample_genom3.hpp"
#include "sample_microsd.hpp"
#include "sample_ulog.hpp"

using namespace omniflight;
using namespace omniflight::recording;

namespace {

constexpr std::size_t kMillion = 1'000'000;

struct Cost {
  double seconds = 0;    // of the processor, which a busy machine does not stretch
  double megabytes = 0;  // beyond what the process had
  bool answered = false, lossless = false;
};

double processor_s(const rusage& u) {
  return static_cast<double>(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

/// Reads the bytes in a process of its own.
Cost read_in_a_child(const char* format, const std::string& bytes) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    Cost cost;
    {
      const auto r = sample::read_as(format, bytes);
      cost.lossless = r && !r->lost_anything();
      cost.answered = r || !r.error().text().empty();
    }
    getrusage(RUSAGE_SELF, &after);
    cost.seconds = processor_s(after) - processor_s(before);
    cost.megabytes = static_cast<double>(after.ru_maxrss - before.ru_maxrss) / 1024;
    _exit(write(ends[1], &cost, sizeof cost) == sizeof cost ? 0 : 1);
  }
  close(ends[1]);
  Cost cost;
  if (read(ends[0], &cost, sizeof cost) != static_cast<ssize_t>(sizeof cost)) cost = {};
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "the reader died";
  return cost;
}

std::string packed(const std::string& records, const std::string& compression) {
  if (compression.empty()) return records;
  const bool lz4 = compression == "lz4";
  std::string out(lz4 ? LZ4F_compressFrameBound(records.size(), nullptr) : ZSTD_compressBound(records.size()),
                  '\0');
  out.resize(lz4 ? LZ4F_compressFrame(out.data(), out.size(), records.data(), records.size(), nullptr)
                 : ZSTD_compress(out.data(), out.size(), records.data(), records.size(), 3));
  return out;
}

/// An MCAP file with the IMU's topic and `count` chunks of these records, which claim to be `claimed` bytes.
std::string mcap_of(const std::string& records, const std::string& compression, int count,
                    std::uint64_t claimed) {
  using mcap::Bytes;
  const auto topic = sample::imu_topic();
  std::string out = std::string(mcap::kMagic) +
                    mcap::record(mcap::kHeader, Bytes().string("ros2").string("other").text()) +
                    mcap::record(mcap::kSchema, Bytes()
                                                    .put(std::uint16_t{3})
                                                    .string(topic.type)
                                                    .string("ros2msg")
                                                    .string(topic.schema_text)
                                                    .text()) +
                    mcap::record(mcap::kChannel, Bytes()
                                                     .put(std::uint16_t{7})
                                                     .put(std::uint16_t{3})
                                                     .string(topic.topic)
                                                     .string("cdr")
                                                     .strings({})
                                                     .text());
  const std::string body = packed(records, compression);
  const std::string chunk = mcap::record(mcap::kChunk, Bytes()
                                                           .put(std::uint64_t{0})
                                                           .put(std::uint64_t{9'000'000})
                                                           .put(claimed)
                                                           .put(std::uint32_t{0})
                                                           .string(compression)
                                                           .put(static_cast<std::uint64_t>(body.size()))
                                                           .raw(body)
                                                           .text());
  for (int k = 0; k < count; ++k) out += chunk;
  return out + mcap::record(mcap::kDataEnd, Bytes().put(std::uint32_t{0}).text()) +
         mcap::record(mcap::kFooter,
                      Bytes().put(std::uint64_t{0}).put(std::uint64_t{0}).put(std::uint32_t{0}).text()) +
         std::string(mcap::kMagic);
}

/// One message again and again, which packs to nearly nothing.
std::string same_message(std::size_t times) {
  const std::string one = mcap::record(mcap::kMessage, mcap::Bytes()
                                                           .put(std::uint16_t{7})
                                                           .put(std::uint32_t{0})
                                                           .put(std::uint64_t{1000})
                                                           .put(std::uint64_t{0})
                                                           .raw(sample::imu_message(1000))
                                                           .text());
  std::string out;
  for (std::size_t k = 0; k < times; ++k) out += one;
  return out;
}

std::string repeated(const std::string& text, std::size_t times) {
  std::string out;
  out.reserve(text.size() * times);
  for (std::size_t k = 0; k < times; ++k) out += text;
  return out;
}

struct Bomb {
  const char* what;
  const char* format;
  std::string (*bytes)();
  bool sound = false;  ///< nothing of it is damaged
};
const Bomb kBombs[] = {
    {"MCAP: 4 GB of empty records in zstd", "mcap",
     [] { return mcap_of(std::string(250 * kMillion, '\0'), "zstd", 17, 250 * kMillion); }},
    {"MCAP: the same in lz4", "mcap",
     [] { return mcap_of(std::string(8 * kMillion, '\0'), "lz4", 60, 8 * kMillion); }},
    {"MCAP: a chunk that claims 200 MB and has 8", "mcap",
     [] { return mcap_of(std::string(8 * kMillion, '\0'), "zstd", 10, 200 * kMillion); }},
    {"MCAP: one IMU message, two million times", "mcap",
     [] {
       const std::string records = same_message(250'000);
       return mcap_of(records, "zstd", 8, records.size());
     },
     true},
    {"CSV: a header of 10 MB", "csv", [] { return "t_s," + repeated("px_m,", 2 * kMillion) + "\n0,1\n"; }},
    {"CSV: a row of 10 MB", "csv", [] { return "t_s,px_m\n0,1\n1," + repeated("0", 10 * kMillion) + "\n"; }},
    {"CSV: two million empty rows", "csv", [] { return "t_s,px_m\n" + repeated("\n", 2 * kMillion); }},
    {"genom3: a row of five million cells", "genom3",
     [] { return sample::genom3_log(3) + repeated("0 ", 5 * kMillion) + "\n"; }},
    {"genom3: two million skipped samples", "genom3",
     [] { return sample::genom3_log(3) + repeated("\n", 2 * kMillion); }},
    {"micro-SD: five million bytes of zeros behind the records", "crazyflie_microsd",
     [] { return sample::microsd_log(5) + std::string(5 * kMillion, '\0'); }},
    {"ULog: five million bytes of empty records", "ulog",
     [] { return sample::flight_log(5).bytes() + std::string(5 * kMillion, '\0'); }},
};

TEST(Bombs, CostLittleAndAreToldOrRefused) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  for (const Bomb& bomb : kBombs) {
    const std::string bytes = bomb.bytes();
    const Cost cost = read_in_a_child(bomb.format, bytes);
    std::cout << bomb.what << ", " << bytes.size() << " bytes: " << cost.seconds << " s, " << cost.megabytes
              << " MB\n";
    EXPECT_TRUE(cost.answered) << bomb.what;
    EXPECT_EQ(cost.lossless, bomb.sound) << bomb.what;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which keep shadows of all memory
    EXPECT_LT(cost.megabytes, 300) << bomb.what;                     // one chunk may have 256 MB
    EXPECT_LT(cost.seconds, 10) << bomb.what;
#endif
  }
}

}  // namespace
