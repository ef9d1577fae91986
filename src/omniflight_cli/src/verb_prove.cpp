// `prove`: the concealed-effect proof. The work is done by programs of omniflight_proof, which this one does
// not link: the proof's plant and the project's dynamics never meet in one process.
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <csignal>
#include <thread>

#include "folder.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_jobs/executor_cli.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

struct ProveOptions {
  jobs::ExecutorOptions executor;
  std::string seal, reveal, vehicle, level, salt, real;
  int cases = 240, nulls = 300, jobs = 0, ablations = -1, proposals = 0;
  double limit_s = 600;
  long seed = -1;
  bool families = false, tuning = false, allow_unsealed = false, no_baselines = false, no_second = false;
};

/// Runs a program with this terminal; Ctrl-C and SIGTERM reach it, and it keeps what is complete.
Result<int> run(std::vector<std::string> arguments, const std::string& out) {
  std::vector<char*> argv;
  for (auto& a : arguments) argv.push_back(a.data());
  argv.push_back(nullptr);
  const pid_t parent = getpid(), pid = fork();
  if (pid < 0) return fail(ErrorCode::internal, "no process could be started", arguments[0]);
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);  // SIGKILL of the command must not leave the proof running
    if (getppid() != parent) _exit(1);
    execv(argv[0], argv.data());
    _exit(127);
  }
  int status = 0;
  for (bool told = false; waitpid(pid, &status, WNOHANG) == 0;) {
    if (interrupted() && !told) told = kill(pid, SIGTERM) == 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  return fail(ErrorCode::internal, "was ended by signal " + std::to_string(WTERMSIG(status)), arguments[0],
              "The same command with --out " + out + " resumes");
}

}  // namespace

Action add_prove(CLI::App& verb, Common& common) {
  auto o = std::make_shared<ProveOptions>();
  verb.add_option("--cases", o->cases, "Cases with hidden effects")->check(CLI::Range(0, 100000));
  verb.add_option("--nulls", o->nulls, "Cases without: nulls and decoys")->check(CLI::Range(0, 100000));
  verb.add_option("--level", o->level, "Only this level of concealment")
      ->check(CLI::IsMember({"L1", "L2", "L3", "L4", "L5", "L6"}));
  verb.add_option("--seal", o->seal,
                  "Folder for the truth; given alone, it stays closed. Default: beside --out");
  verb.add_option("--reveal", o->reveal, "Open this seal and score the frozen answers in --out");
  verb.add_option("--vehicle", o->vehicle, "Nominal vehicle; default omnimorph");
  verb.add_option("--jobs", o->jobs, "At once; default: processors")->check(CLI::Range(1, 64));
  jobs::add_executor(verb, o->executor);
  verb.add_option("--limit-s", o->limit_s, "Time of one diagnosis [s]")->check(not_negative(false));
  verb.add_option("--salt", o->salt, "For tests only; a proof draws its own");
  verb.add_option("--ablations", o->ablations,
                  "Cases that are diagnosed again with every ablation; default: a tenth of all")
      ->check(CLI::Range(0, 100000));
  verb.add_option("--proposals", o->proposals,
                  "Proposed flights that are analysed, the first by the numbers of their cases; default: all")
      ->check(CLI::Range(1, 100000));
  verb.add_flag(
      "--families", o->families,
      "Worlds that differ in vehicle, controller, start, manoeuvre, signals, noise and calibration");
  verb.add_option("--real", o->real, "Inject effects into the real flights of this folder; needs --vehicle");
  verb.add_option("--seed", o->seed, "Of --families --tuning")->check(CLI::Range(0L, 1000000000L));
  verb.add_flag("--no-second", o->no_second, "Do not fly what is proposed for ambiguous cases");
  verb.add_flag("--tuning", o->tuning, "Other parameter boxes and magnitudes, for developing");
  verb.add_flag("--no-baselines", o->no_baselines, "Leave the textbook methods out");
  verb.add_flag("--allow-unsealed", o->allow_unsealed, "Go on where the analysis cannot be confined");
  return [o, &common]() -> Result<int> {
    if (!o->reveal.empty() && common.out.empty())
      return bad_input("needs the folder of the answers that it is to be held against", "--reveal",
                       "Give --out, the folder of the sealed run");
    auto program = find_program("omniflight_proof_campaign");
    if (!program) return Failure(program.error());
    const std::string out = common.out.empty() ? fresh_folder("proof") : common.out;
    const auto folder = FolderLock::take(out);
    if (!folder) return Failure(folder.error());
    say(common, "proof: " + out);
    std::vector<std::string> a{*program,
                               "--cases",
                               std::to_string(o->cases),
                               "--nulls",
                               std::to_string(o->nulls),
                               "--limit-s",
                               std::to_string(o->limit_s)};
    const auto add = [&](const char* option, const std::string& value) {
      if (!value.empty()) a.insert(a.end(), {option, value});
    };
    add("--out", out);
    if (o->executor.name != "local")
      for (const std::string& argument : arguments_of(o->executor)) a.push_back(argument);
    add("--level", o->level);
    add("--seal", o->seal);
    add("--reveal", o->reveal);
    add("--vehicle", o->vehicle);
    add("--salt", o->salt);
    add("--real", o->real);
    if (o->seed >= 0) add("--seed", std::to_string(o->seed));
    if (o->families) a.emplace_back("--families");
    if (o->ablations >= 0) add("--ablations", std::to_string(o->ablations));
    if (o->proposals > 0) add("--proposals", std::to_string(o->proposals));
    if (o->jobs > 0) add("--jobs", std::to_string(o->jobs));
    if (o->tuning) a.emplace_back("--tuning");
    if (o->no_second) a.emplace_back("--no-second");
    if (o->no_baselines) a.emplace_back("--no-baselines");
    if (o->allow_unsealed) a.emplace_back("--allow-unsealed");
    if (common.quiet) a.emplace_back("--quiet");
    if (common.json) a.emplace_back("--json");
    return run(a, out);
  };
}

}  // namespace omniflight::cli
