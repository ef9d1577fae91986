// A job's folder appears once and whole, however often it is done and however it ends.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "omniflight_files/files.hpp"
#include "omniflight_jobs/executor.hpp"
#include "omniflight_jobs/task.hpp"

namespace omniflight::jobs {
namespace {

namespace fs = std::filesystem;

class Jobs : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "omniflight_jobs_XXXXXX").string();
    dir_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(dir_); }

  /// A job of /bin/sh; $1 is the folder to write into.
  Job job(const std::string& name, const std::string& script) const {
    return {name, dir_ / name, {"-c", script, "sh", kOut}, {0}};
  }
  std::string text(const fs::path& file) const { return files::read_file(file, 1000).value_or("nothing"); }
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(dir_), fs::directory_iterator()));
  }

  fs::path dir_;
  const std::string sh_ = "/bin/sh";
};

TEST_F(Jobs, LeaveAWholeFolder) {
  const Job one = job("one", "echo 42 > $1/answer; echo said");
  EXPECT_EQ(perform(one, sh_, nullptr).ending, Ending::done);
  EXPECT_EQ(text(dir_ / "one/answer"), "42\n");
  EXPECT_EQ(text(dir_ / "one/job.log"), "said\n");
  const auto told = nlohmann::json::parse(text(dir_ / "one/job.json"));
  EXPECT_EQ(told["exit_code"], 0);
  EXPECT_FALSE(told["host"].get<std::string>().empty());
  EXPECT_EQ(perform(job("one", "echo 43 > $1/answer"), sh_, nullptr).ending, Ending::done_before);
  EXPECT_EQ(text(dir_ / "one/answer"), "42\n");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(Jobs, OfTwoAtOnceOneIsKept) {
  // eight attempts at each of twenty jobs, all begun before any has ended
  for (int round = 0; round < 20; ++round) {
    const Job one = job("twin" + std::to_string(round), "sleep 0.05; echo $$ > $1/who");
    std::atomic<int> made{0}, before{0};
    std::vector<std::thread> threads;
    for (int k = 0; k < 8; ++k)
      threads.emplace_back([&] {
        const Performed p = perform(one, sh_, nullptr);
        made += p.ending == Ending::done;
        before += p.ending == Ending::done_before;
      });
    for (auto& t : threads) t.join();
    EXPECT_EQ(made, 1);
    EXPECT_EQ(before, 7);
  }
  EXPECT_EQ(entries(), 20u) << "what the seven others wrote is gone";
}

TEST_F(Jobs, ThatFailLeaveNothingButTheReason) {
  const Performed p = perform(job("bad", "echo half > $1/answer; echo no disk >&2; exit 3"), sh_, nullptr);
  EXPECT_EQ(p.ending, Ending::failed);
  EXPECT_EQ(p.reason, "ended with 3: no disk");
  EXPECT_EQ(entries(), 0u);
  EXPECT_EQ(perform(job("killed", "kill -9 $$"), sh_, nullptr).ending, Ending::killed);
  EXPECT_EQ(perform(job("nobody", ""), "/nonexistent", nullptr).reason, "could not be started");
  Job other = job("other", "exit 2");
  other.results = {0, 2};
  EXPECT_EQ(perform(other, sh_, nullptr).ending, Ending::done);
}

TEST_F(Jobs, StopWhenTheyAreAsked) {
  const auto begin = std::chrono::steady_clock::now();
  static std::atomic<int> asked;
  asked = 0;
  EXPECT_EQ(perform(job("long", "sleep 60"), sh_, [] { return ++asked > 5; }).ending, Ending::stopped);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(9));
  EXPECT_EQ(entries(), 0u);
}

TEST_F(Jobs, OfATaskAreReadAndDoneInOrder) {
  JobArray array{sh_, {}, {{0, 1}, {2}}};
  array.jobs = {job("a", "exit 0"), job("b", "echo why >&2; exit 1"), job("c d'e", "exit 0")};
  const fs::path file = dir_ / "array.json";
  ASSERT_TRUE(write_array(array, file));
  const auto read = read_array(file);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->jobs[2].folder, array.jobs[2].folder);
  EXPECT_EQ(read->jobs[1].command, array.jobs[1].command);
  EXPECT_EQ(run_task(file, 0, nullptr).value(), 2) << "one of its jobs left no result";
  EXPECT_TRUE(is_done(array.jobs[0]));
  EXPECT_FALSE(is_done(array.jobs[1]) || is_done(array.jobs[2]));
  EXPECT_EQ(failure_of(array.jobs[1], file)->reason, "ended with 1: why");
  EXPECT_FALSE(failure_of(array.jobs[2], file));
  EXPECT_EQ(run_task(file, 1, nullptr).value(), 0);
  EXPECT_FALSE(run_task(file, 2, nullptr));
}

TEST_F(Jobs, OfADamagedArrayAreRefused) {
  const fs::path file = dir_ / "array.json";
  for (const char* text :
       {"", "[]", R"({"schema":"omniflight.job_array/1"})",
        R"({"schema":"omniflight.job_array/1","program":"p","tasks":[[1]],"jobs":[]})",
        R"({"schema":"omniflight.job_array/1","program":"p","tasks":[[0]],"jobs":[{"name":1}]})",
        R"({"schema":"omniflight.job_array/1","program":"p","tasks":[[0]],
            "jobs":[{"name":"a","folder":"relative","command":[],"results":[0]}]})"}) {
    std::ofstream(file) << text;
    EXPECT_FALSE(read_array(file)) << text;
  }
}

TEST_F(Jobs, AreRunAFewAtOnce) {
  Work work;
  work.program = sh_;
  work.folder = dir_ / ".jobs";
  for (int k = 0; k < 10; ++k)
    work.jobs.push_back(job("j" + std::to_string(k), k == 4 ? "exit 1" : "exit 0"));
  ASSERT_EQ(perform(work.jobs[0], sh_, nullptr).ending, Ending::done);
  fs::create_directories(dir_ / ".partial-left");  // nobody's
  std::size_t last = 0;
  work.progress = [&](std::size_t done) { last = done; };
  const auto ran = make_executor({.name = "local", .jobs = 3}).value()->run(work).value();
  EXPECT_EQ(ran.before, 1u);
  EXPECT_EQ(ran.made, 8u);
  ASSERT_EQ(ran.missing.size(), 1u);
  EXPECT_EQ(ran.missing[0].job, 4u);
  EXPECT_EQ(last, 10u);
  work.may_begin = [] { return false; };
  const auto late = make_executor({.name = "local", .jobs = 3}).value()->run(work).value();
  EXPECT_EQ(late.before, 9u);
  EXPECT_EQ(late.missing.at(0).reason, "the time was over before it began");
  EXPECT_FALSE(make_executor({.name = "cloud"}));
}

TEST_F(Jobs, RemoveWhatOthersLeftOfJobsThatAreDone) {
  const Job one = job("one", "exit 0"), two = job("two", "exit 0");
  // an attempt at each that is killed in the middle, with the process that waits for it
  for (const Job& j : {one, two}) {
    const pid_t pid = fork();
    if (pid == 0) {
      Job slow = j;
      slow.command[1] = "sleep 20";
      (void)perform(slow, sh_, nullptr);
      _exit(0);
    }
    const std::size_t before = entries();
    for (int k = 0; k < 500 && entries() == before; ++k)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    kill(pid, SIGKILL);
    waitpid(pid, nullptr, 0);
  }
  EXPECT_EQ(entries(), 2u);
  ASSERT_EQ(perform(one, sh_, nullptr).ending, Ending::done);
  remove_partials({one, two});
  EXPECT_EQ(entries(), 2u) << "one's folder, and what somebody may still be writing of two";
}

}  // namespace
}  // namespace omniflight::jobs
