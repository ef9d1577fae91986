// What Slurm 22.05 prints, as it was printed by a real cluster of two nodes.
#include <gtest/gtest.h>

#include "slurm_text.hpp"

namespace omniflight::jobs {
namespace {

TEST(SlurmText, ReadsTheQueue) {
  const auto tasks = read_queue(
      "1                   |PENDING             |JobArrayTaskLimit   |                    |0                 "
      "  |\n"
      "2|PENDING|BeginTime||1|\n"
      "0|RUNNING|None|node1|0|\n"
      "slurm_load_jobs error: something else\nN/A|PENDING|None||0|\n");
  ASSERT_EQ(tasks.size(), 3u);
  EXPECT_EQ(tasks[0].number, 1u);
  EXPECT_EQ(tasks[0].reason, "JobArrayTaskLimit");
  EXPECT_EQ(tasks[1].restarts, 1);
  EXPECT_EQ(tasks[2].state, "RUNNING");
  EXPECT_EQ(tasks[2].nodes, "node1");
}

TEST(SlurmText, ReadsHowTasksEnded) {
  const Endings accounted = read_accounting(
      "17_0|COMPLETED|0:0|node1\n17_1|NODE_FAIL|0:0|node2\n17_2|TIMEOUT|0:15|node1\n17_[3-9]|PENDING|0:0|"
      "None assigned\n");
  EXPECT_EQ(accounted.size(), 3u);
  EXPECT_EQ(accounted.at(1), "NODE_FAIL on node2");
  EXPECT_EQ(accounted.at(2), "TIMEOUT on node1 (exit code:signal 0:15)");
  const Endings told = read_jobs(
      "JobId=1 ArrayJobId=1 ArrayTaskId=3 JobName=t.sh\n   JobState=FAILED Reason=NonZeroExitCode "
      "Dependency=(null)\n"
      "   Requeue=1 Restarts=0 BatchFlag=1 Reboot=0 ExitCode=2:0\n   NodeList=node2\n\n"
      "JobId=6 ArrayJobId=1 ArrayTaskId=2 JobName=t.sh\n   JobState=COMPLETED Reason=None\n   ExitCode=0:0\n "
      "  NodeList=node1\n");
  EXPECT_EQ(told.at(3), "FAILED on node2 (exit code:signal 2:0)");
  EXPECT_EQ(told.at(2), "COMPLETED on node1");
  EXPECT_TRUE(read_jobs("slurm_load_jobs error: Invalid job id specified\n").empty());
}

TEST(SlurmText, ReadsTheLargestArray) {
  EXPECT_EQ(largest_array("MaxArraySize            = 1001\nMaxDBDMsgs              = 20008\n"), 1001u);
  EXPECT_EQ(largest_array("SlurmctldHost[0] = localhost\n"), 0u);
}

TEST(SlurmText, NamesTheOptionThatIsRefused) {
  const auto says = [](const char* words, const char* field) {
    const Error e = refusal(words);
    EXPECT_EQ(e.where, field) << words;
    EXPECT_EQ(e.code, ErrorCode::bad_input);
    EXPECT_FALSE(e.next_step.empty());
    EXPECT_NE(e.message.find("the cluster refuses: "), std::string::npos);
    EXPECT_EQ(e.message.find("sbatch: error"), std::string::npos);
  };
  says(
      "sbatch: error: invalid partition specified: nope\n"
      "sbatch: error: Batch job submission failed: Invalid partition name specified\n",
      "--partition");
  says(
      "sbatch: error: Batch job submission failed: Invalid account or account/partition combination "
      "specified\n",
      "--account");
  says(
      "sbatch: error: Batch job submission failed: Requested time limit is invalid (missing or exceeds some "
      "limit)\n",
      "--time");
  says("sbatch: error: Batch job submission failed: Invalid job array specification\n", "--jobs-per-task");
  says("sbatch: error: Batch job submission failed: Requested node configuration is not available\n",
       "--cpus");
  says("sbatch: error: Batch job submission failed: Unable to contact slurm controller (connect failure)\n",
       "--executor slurm");
  says("", "--executor slurm");
}

TEST(SlurmText, KnowsWhatWillNeverStart) {
  EXPECT_EQ(blocked("PartitionTimeLimit").error.where, "--time");
  EXPECT_GT(blocked("PartitionConfig").patience_s, blocked("PartitionTimeLimit").patience_s);
  for (const char* reason :
       {"None", "Resources", "Priority", "BeginTime", "ReqNodeNotAvail, UnavailableNodes:node2"})
    EXPECT_TRUE(blocked(reason).error.message.empty()) << reason;
  EXPECT_TRUE(is_held("JobHeldAdmin") && is_held("launch failed requeued held"));
  EXPECT_FALSE(is_held("Resources"));
}

TEST(SlurmText, QuotesForTheShell) {
  EXPECT_EQ(shell_word("a b"), "'a b'");
  EXPECT_EQ(shell_word("it's $HOME"), "'it'\\''s $HOME'");
}

}  // namespace
}  // namespace omniflight::jobs
