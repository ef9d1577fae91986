// The recorder's promises when the process is killed or the disk is full.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <random>
#include <vector>

#include "omniflight_recording/mcap_reader.hpp"
#include "sample_bag.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

std::uint64_t now_ns() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::uint64_t>(t.tv_sec) * 1'000'000'000 + static_cast<std::uint64_t>(t.tv_nsec);
}
void sleep_ns(std::uint64_t ns) {
  timespec t{static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  ::nanosleep(&t, nullptr);
}

/// Shared with a child: when each write() was called, and how many have returned.
struct Progress {
  std::atomic<std::uint32_t> returned;
  std::uint64_t time_ns[4096];
};

/// Writes IMU messages in real time until it is killed.
[[noreturn]] void write_until_killed(const fs::path& file, Progress& progress) {
  auto writer = McapWriter::create(file);
  if (!writer) ::_exit(1);
  const auto imu = (*writer)->add_topic(sample::imu_topic());
  if (!imu) ::_exit(1);
  for (std::uint32_t i = 0; i < 4096; ++i) {
    const std::uint64_t now = now_ns();
    progress.time_ns[i] = now;
    if (!(*writer)->write(*imu, i, now, now, sample::imu_message(now), now)) ::_exit(1);
    progress.returned.store(i + 1);
    sleep_ns(500'000);
  }
  ::_exit(2);
}

/// How long a time of returned writes is not in the file [ms]; the rest must be there without a gap.
double loss_ms(const fs::path& file, const Progress& progress) {
  const std::uint32_t returned = progress.returned;
  std::uint32_t stored = 0;
  const std::string bytes = sample::slurp(file);
  const auto content = scan_mcap(bytes, file, [&](const McapChannel&, const McapMessage& m) {
    EXPECT_EQ(m.sequence, stored);  // no gap
    EXPECT_EQ(m.log_ns, progress.time_ns[stored]);
    ++stored;
  });
  if (returned == 0) return 0;  // killed before its first message
  EXPECT_TRUE(content) << content.error().text();
  EXPECT_TRUE(content && !content->complete && !content->notes.empty());
  return stored >= returned
             ? 0
             : 1e-6 * static_cast<double>(progress.time_ns[returned - 1] - progress.time_ns[stored]);
}

/// 200 in the long tests, see CMakeLists.txt.
int kills() {
  const char* told = std::getenv("OMNIFLIGHT_REPETITIONS");
  return told ? std::max(10, std::atoi(told)) : 50;
}

TEST(McapCrash, AKilledWriterLosesAtMostOneFlushPeriodAndLeavesNoGap) {
  constexpr int kBatch = 10;
  const int batches = kills() / kBatch, total = batches * kBatch;
  const std::size_t size = static_cast<std::size_t>(total) * sizeof(Progress);
  const fs::path folder = fs::temp_directory_path() / ("omniflight_kill_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  void* memory = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  auto* progress = static_cast<Progress*>(memory);
  std::mt19937_64 random(7);
  double worst = 0;
  for (int batch = 0; batch < total; batch += kBatch) {
    std::vector<pid_t> children;
    std::vector<std::uint64_t> deadlines;
    for (int i = batch; i < batch + kBatch; ++i) {
      children.push_back(::fork());
      if (children.back() == 0) write_until_killed(folder / std::to_string(i), progress[i]);
      deadlines.push_back(now_ns() + 20'000'000 + random() % 600'000'000);
    }
    for (int waiting = kBatch; waiting > 0; sleep_ns(200'000))
      for (std::size_t i = 0; i < children.size(); ++i) {
        if (children[i] == 0 || now_ns() < deadlines[i]) continue;
        ::kill(children[i], SIGKILL);
        int status = 0;
        ::waitpid(children[i], &status, 0);
        EXPECT_TRUE(WIFSIGNALED(status));
        children[i] = 0;
        --waiting;
      }
    for (int i = batch; i < batch + kBatch; ++i)
      worst = std::max(worst, loss_ms(folder / std::to_string(i), progress[i]));
  }
  EXPECT_LE(worst, 100.0);
  EXPECT_GT(worst, 0.0);  // otherwise this test killed nobody in mid-work
  std::printf("largest loss of %d kills: %.1f ms\n", total, worst);
  ::munmap(memory, size);
  fs::remove_all(folder);
}

TEST(McapCrash, AFullDiskIsAnError) {
  McapWriterOptions options;
  options.overwrite = true;
  const auto writer = McapWriter::create("/dev/full", options);
  ASSERT_FALSE(writer);
  EXPECT_NE(writer.error().text().find("/dev/full: the recording cannot be continued (write: No space left"),
            std::string::npos)
      << writer.error().text();
}

TEST(McapCrash, AnErrorInTheMiddleKeepsWhatWasWrittenReadable) {
  const fs::path file =
      fs::temp_directory_path() / ("omniflight_limit_" + std::to_string(::getpid()) + ".mcap");
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{20000, 20000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    McapWriterOptions options;
    options.chunk_bytes = 3000;
    auto writer = McapWriter::create(file, options);
    const auto imu = (*writer)->add_topic(sample::imu_topic());
    Status status;
    for (std::uint32_t i = 0; i < 100000 && status; ++i)
      status =
          (*writer)->write(*imu, i, i * 1000000ull, 0, sample::imu_message(i * 1000000ull), i * 1000000ull);
    const bool told = !status && status.error().message.find("cannot be continued") != std::string::npos;
    const bool sticky = !(*writer)->flush() && !(*writer)->close();
    ::_exit(told && sticky ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  const auto r = load(file);
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_GT(r->find("gyro")->size(), 30);
  EXPECT_TRUE(r->lost_anything());
  EXPECT_NE(r->notes.front().text.find(" 0 bytes of a torn record"), std::string::npos)
      << r->notes.front().text;
  fs::remove(file);
}

TEST(McapCrash, AnExistingRecordingIsNotOverwritten) {
  const fs::path file =
      fs::temp_directory_path() / ("omniflight_exists_" + std::to_string(::getpid()) + ".mcap");
  sample::write_flight(file, 10, 1000);
  EXPECT_FALSE(McapWriter::create(file));
  EXPECT_TRUE(load(file));
  fs::remove(file);
}

TEST(McapCrash, DroppedMessagesAreCountedByTopicAndTold) {
  const fs::path file =
      fs::temp_directory_path() / ("omniflight_drop_" + std::to_string(::getpid()) + ".mcap");
  {
    auto writer = McapWriter::create(file).value();
    const auto imu = writer->add_topic(sample::imu_topic()).value();
    for (std::uint32_t i = 0; i < 10; ++i)
      if (i != 4 && i != 5) sample::need(writer->write(imu, i, i, i, sample::imu_message(i * 1000), i));
    writer->count_dropped(imu, 2);
    EXPECT_EQ(writer->statistics().dropped, 2u);
  }  // the destructor closes
  const auto r = load(file).value();
  ASSERT_EQ(r.notes.size(), 2u);
  EXPECT_EQ(r.notes[0].text, "/omniflight/imu: 2 messages are missing in the sequence");
  EXPECT_EQ(r.notes[1].text, "/omniflight/imu: the recorder dropped '2' messages");
  fs::remove(file);
}

}  // namespace
