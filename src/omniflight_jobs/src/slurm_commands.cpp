#include "slurm_commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "command.hpp"

namespace omniflight::jobs {
namespace {

constexpr double kDeadline = 60;      // s that a command may take; Slurm's own MessageTimeout is 10 s
constexpr std::size_t kUsual = 1001;  // MaxArraySize where the configuration does not tell it

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

Result<SlurmCommands> SlurmCommands::find() {
  SlurmCommands out;
  for (const auto& [name, place] : {std::pair{"sbatch", &out.sbatch_},
                                    {"squeue", &out.squeue_},
                                    {"scancel", &out.scancel_},
                                    {"scontrol", &out.scontrol_}}) {
    *place = in_path(name);
    if (place->empty())
      return bad_input(std::string("the command ") + name + " of Slurm is not in PATH", "--executor slurm",
                       "Start on a login node of the cluster, or install slurm-client (Debian)");
  }
  out.sacct_ = in_path("sacct");
  const auto config = run_command({out.scontrol_, "show", "config"}, kDeadline);
  if (!config) return Failure(config.error());
  if (config->code != 0)
    return bad_input("the cluster's controller does not answer: " + first_line(config->err),
                     "--executor slurm",
                     "See whether 'sinfo' answers, and whether SLURM_CONF names the cluster's slurm.conf");
  const std::size_t told = jobs::largest_array(config->out);
  out.largest_array_ = told > 0 ? told : kUsual;
  return out;
}

Result<std::string> SlurmCommands::submit(const ExecutorOptions& o, std::size_t tasks,
                                          const std::filesystem::path& script,
                                          const std::filesystem::path& log) const {
  std::vector<std::string> c{
      sbatch_,
      "--parsable",
      "--requeue",
      "--open-mode=append",
      "--signal=B:TERM@15",  // before the time is over: what is unfinished is tidied up
      "--nodes=1",
      "--ntasks=1",
      "--job-name=omniflight",
      fmt::format("--cpus-per-task={}", o.cpus),
      "--output=" + log.string()};
  c.push_back(fmt::format("--array=0-{}{}", tasks - 1,
                          o.tasks_at_once > 0 ? fmt::format("%{}", o.tasks_at_once) : ""));
  if (!o.partition.empty()) c.push_back("--partition=" + o.partition);
  if (!o.account.empty()) c.push_back("--account=" + o.account);
  if (o.time_min > 0) {
    const long s = std::lround(std::ceil(60 * o.time_min));
    c.push_back(fmt::format("--time={}:{:02}", s / 60, s % 60));
  }
  c.push_back(script.string());
  const auto said = run_command(c, kDeadline);
  if (!said) return Failure(said.error());
  const std::string id = first_line(said->out).substr(0, first_line(said->out).find(';'));
  if (said->code != 0) return Failure(refusal(said->err));
  if (id.empty() ||
      !std::all_of(id.begin(), id.end(), [](unsigned char ch) { return std::isdigit(ch) != 0; }))
    return bad_input("sbatch printed no number of a job: " + first_line(said->out), "--executor slurm");
  return id;
}

Result<std::vector<QueuedTask>> SlurmCommands::queue(const std::string& id) const {
  const auto said = run_command(
      {squeue_, "--noheader", "--array", "--jobs=" + id, std::string("--Format=") + kQueueFormat}, kDeadline);
  if (!said) return Failure(said.error());
  if (said->code == 0) return read_queue(said->out);
  if (said->err.find("Invalid job id") != std::string::npos) return std::vector<QueuedTask>{};
  return fail(ErrorCode::incomplete, "squeue: " + first_line(said->err), "--executor slurm",
              "The array goes on by itself; the same command with --resume waits for it");
}

Endings SlurmCommands::endings(const std::string& id, std::string& remark) const {
  if (!sacct_.empty()) {
    const auto said = run_command({sacct_, "--jobs=" + id, "--parsable2", "--noheader", "--allocations",
                                   "--format=JobID,State,ExitCode,NodeList"},
                                  kDeadline);
    if (said && said->code == 0)
      if (auto read = read_accounting(said->out); !read.empty()) return read;
    remark = "this cluster keeps no accounting (sacct: " +
             (said ? first_line(said->err.empty() ? "nothing known" : said->err) : said.error().text()) +
             "); how tasks ended is from scontrol, which forgets after a few minutes";
  } else {
    remark = "sacct is not there; how tasks ended is from scontrol, which forgets after a few minutes";
  }
  const auto said = run_command({scontrol_, "show", "job", id}, kDeadline);
  return said && said->code == 0 ? read_jobs(said->out) : Endings{};
}

void SlurmCommands::cancel(const std::string& id) const { (void)run_command({scancel_, id}, kDeadline); }

}  // namespace omniflight::jobs
