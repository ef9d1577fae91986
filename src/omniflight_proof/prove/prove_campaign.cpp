// omniflight_proof_campaign: the whole proof. Hide, commit, analyse where the truth cannot be read, freeze,
// open, score. Behind `omniflight prove`.
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_jobs/executor_cli.hpp"
#include "omniflight_jobs/task.hpp"
#include "prove_analyse.hpp"
#include "seal.hpp"

namespace omniflight::proof {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Of `omniflight diagnose --ablation`.
constexpr const char* kAblations[] = {"no-tolerance", "no-law-error",  "no-temperature",
                                      "late-pose",    "wrong-inertia", "commands-only"};

/// Without a safeguard many names enter, and a search among many takes long: no answer is one, too.
constexpr double kAblationLimit_s = 240;

struct Options {
  std::string out = "runs/proof", seal, reveal, vehicle = "omnimorph", level, salt, command;
  int cases = 240, nulls = 300, jobs = 0, ablations = -1, proposals = 0;
  double limit_s = 600;
  bool families = false;  ///< worlds of the families instead of the levels
  std::string real;       ///< recordings of real flights to inject into instead
  long seed = -1;
  bool tuning = false, allow_unsealed = false, baselines = true, second = true, quiet = false,
       as_json = false;
  jobs::ExecutorOptions executor;
  // of a job: one case, and where its answer goes
  std::string analyse, into, ablation;
  bool of_second = false;
  // --probe
  std::string probe_seal, probe_secret, probe_readable, probe_writable;
  int probe_parent = 0;
};

fs::path this_program() {
  std::error_code ec;
  return fs::read_symlink("/proc/self/exe", ec);
}

fs::path own_folder() { return this_program().parent_path(); }

Result<std::string> program(const std::string& name, const std::vector<fs::path>& more = {}) {
  std::vector<fs::path> folders{own_folder()};
  folders.insert(folders.end(), more.begin(), more.end());
  std::error_code ec;
  for (const auto& f : folders)
    if (fs::is_regular_file(f / name, ec)) return (f / name).string();
  return bad_input("the program " + name + " is not there", own_folder().string(), "Build the workspace");
}

/// A program of our own, with the terminal; SIGINT and SIGTERM reach it, too.
Result<int> run(std::vector<std::string> arguments, bool silent) {
  std::vector<char*> argv;
  for (auto& a : arguments) argv.push_back(a.data());
  argv.push_back(nullptr);
  const pid_t parent = getpid(), pid = fork();
  if (pid < 0) return fail(ErrorCode::internal, "no process", arguments[0]);
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(1);  // it died before it could be heard
    if (silent && !freopen("/dev/null", "w", stdout)) _exit(125);
    execv(argv[0], argv.data());
    _exit(127);
  }
  using clock = std::chrono::steady_clock;
  constexpr auto kToEnd = std::chrono::seconds(3);  // then it is killed: what is not complete is made anew
  int status = 0;
  std::optional<clock::time_point> told;
  while (waitpid(pid, &status, WNOHANG) == 0) {
    if (interrupted() && !told) {
      kill(pid, SIGTERM);
      told = clock::now();
    }
    if (told && clock::now() - *told > kToEnd) kill(pid, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void say(const Options& o, const std::string& line) {
  if (!o.quiet) std::cerr << line << std::endl;
}

Status ended(Result<int> code, const std::string& what) {
  if (!code) return Failure(code.error());
  if (*code == 0) return {};
  const auto kind = *code >= 1 && *code <= 4 ? static_cast<ErrorCode>(*code) : ErrorCode::internal;
  return fail(kind, fmt::format("{} ended with {}", what, *code), "", "See the line above");
}

/// Families and injections have a vehicle for every case, and scores of their own.
bool by_family(const Options& o) { return o.families || !o.real.empty(); }

Result<std::vector<std::string>> family_arguments(const Options& o, const Places& places) {
  auto generator = program(o.real.empty() ? "omniflight_proof_families" : "omniflight_proof_inject");
  if (!generator) return Failure(generator.error());
  std::vector<std::string> a{*generator,
                             "--out",
                             o.out,
                             "--seal",
                             places.seal.string(),
                             "--cases",
                             std::to_string(o.cases),
                             "--nulls",
                             std::to_string(o.nulls)};
  if (!o.real.empty()) a.insert(a.end(), {"--real", o.real, "--vehicle", o.vehicle});
  if (!o.salt.empty()) a.insert(a.end(), {"--salt", o.salt});
  if (o.jobs > 0 && o.real.empty()) a.insert(a.end(), {"--jobs", std::to_string(o.jobs)});
  if (o.tuning) a.insert(a.end(), {"--tuning", "--seed", std::to_string(o.seed)});
  if (o.quiet) a.emplace_back("--quiet");
  return a;
}

Result<std::vector<std::string>> generator_arguments(const Options& o, const Places& places) {
  auto generator = program("omniflight_proof_generate");
  if (!generator) return Failure(generator.error());
  std::vector<std::string> a{*generator,
                             "--out",
                             o.out,
                             "--seal",
                             places.seal.string(),
                             "--cases",
                             std::to_string(o.cases),
                             "--nulls",
                             std::to_string(o.nulls),
                             "--vehicle",
                             o.vehicle};
  if (!o.level.empty()) a.insert(a.end(), {"--level", o.level});
  if (!o.salt.empty()) a.insert(a.end(), {"--salt", o.salt});
  if (o.jobs > 0) a.insert(a.end(), {"--jobs", std::to_string(o.jobs)});
  if (o.tuning) a.emplace_back("--tuning");
  if (o.quiet) a.emplace_back("--quiet");
  return a;
}

Status hide(const Options& o, const Places& places) {
  auto arguments = by_family(o) ? family_arguments(o, places) : generator_arguments(o, places);
  if (!arguments) return Failure(arguments.error());
  return ended(run(*arguments, true), "hiding the effects");
}

/// What is proposed for cases that could not be told apart is flown in the same world, which the generator
/// alone knows, and analysed together with the first flight. The first answers are frozen by then.
Status second_round(const Options& o, const Places& places, AnalyseOptions a) {
  if (!fs::exists(places.frozen_next())) {
    auto arguments = generator_arguments(o, places);
    if (!arguments) return Failure(arguments.error());
    arguments->emplace_back("--next");
    if (auto ok = ended(run(*arguments, true), "flying what was proposed"); !ok) return ok;
    std::error_code ec;
    if (fs::is_empty(places.next(), ec) || ec) return {};  // nothing was proposed
    a.second = true;
    a.most = static_cast<std::size_t>(o.proposals);
    if (auto ok = analyse(a); !ok) return ok;
  }
  auto frozen = freeze(places.answers_next(), places.frozen_next());
  if (!frozen) return Failure(frozen.error());
  say(o, "answers with the proposed flights frozen: SHA-256 " + *frozen);
  return {};
}

/// The textbook fit that is told what is hidden: how well sizes can be known at all. Only after the answers
/// are frozen.
Status ask_oracle(const Options& o, const Places& places) {
  if (!o.baselines || fs::exists(places.oracle())) return {};
  auto baselines = program("omniflight_proof_baselines");
  if (!baselines) return Failure(baselines.error());
  const std::string vehicle =
      (places.out / "vehicle" / (fs::path(o.vehicle).stem().string() + ".yaml")).string();
  return ended(run({*baselines, places.cases().string(), "--vehicle", vehicle, "--oracle",
                    places.truth().string(), "--out", places.oracle().string()},
                   true),
               "the oracle");
}

/// The rules under which a sealed run by families proves something; printed with every one.
constexpr const char* kRules =
    "rules: nothing is tuned on a sealed run; what is marked unseen was never drawn for tuning; all cases "
    "are published, "
    "also those that failed; whoever opens a seal draws the next.";

Status open_and_score_families(const Options& o, const Places& places) {
  auto scorer = program("omniflight_proof_families_score");
  if (!scorer) return Failure(scorer.error());
  std::vector<std::string> a{*scorer,  "--answers",          places.answers().string(),
                             "--seal", places.seal.string(), "--out",
                             o.out,    "--commitment",       places.commitment().string()};
  if (o.quiet) a.emplace_back("--quiet");
  if (auto ok = ended(run(a, o.as_json), "scoring"); !ok) return ok;
  say(o, kRules);
  if (!o.as_json) return {};
  auto text = files::read_file(places.out / "family_scores.json", 256 * files::kMegabyte);
  if (!text) return Failure(text.error());
  std::cout << *text << std::flush;
  return {};
}

Status open_and_score(const Options& o, const Places& places) {
  if (by_family(o)) return open_and_score_families(o, places);
  if (auto ok = ask_oracle(o, places); !ok) return ok;
  auto scorer = program("omniflight_proof_score");
  if (!scorer) return Failure(scorer.error());
  std::vector<std::string> a{*scorer, "--out", o.out, "--seal", places.seal.string()};
  if (o.quiet) a.emplace_back("--quiet");
  if (auto ok = ended(run(a, o.as_json), "scoring"); !ok) return ok;
  if (!o.as_json) return {};
  auto text = files::read_file(places.out / "proof.json", 256 * files::kMegabyte);
  if (!text) return Failure(text.error());
  std::cout << *text << std::flush;
  return {};
}

/// The first cases by their shuffled number once more with every ablation, behind the same wall.
Status ablate(const Options& o, const Places& places, AnalyseOptions a) {
  const int asked = o.ablations < 0 ? (o.cases + o.nulls) / 10 : o.ablations;
  if (asked > 0 && !fs::exists(places.frozen_ablations())) {
    a.most = static_cast<std::size_t>(asked);
    a.limit_s = std::min(a.limit_s, kAblationLimit_s);
    for (const char* id : kAblations) {
      a.ablation = id;
      if (auto ok = analyse(a); !ok) return ok;
    }
  }
  if (asked == 0 && !fs::exists(places.ablations())) return {};
  auto frozen = freeze(places.ablations(), places.frozen_ablations());
  if (!frozen) return Failure(frozen.error());
  say(o, "answers of the ablations frozen: SHA-256 " + *frozen);
  return {};
}

Result<int> prove(Options o) {
  prctl(PR_SET_DUMPABLE, 0);  // nobody of the same user looks into this process
  std::error_code ec;
  Places places{fs::absolute(o.out, ec).lexically_normal(), {}};
  const bool only_open = !o.reveal.empty() && o.seal.empty();
  places.seal = fs::absolute(!o.seal.empty() ? o.seal
                             : only_open     ? o.reveal
                                             : places.out.string() + ".seal",
                             ec)
                    .lexically_normal();
  if (only_open) {  // cases of families and injections bring their own vehicle
    for (const auto& entry : fs::directory_iterator(places.cases(), ec))
      o.families = o.families || fs::exists(entry.path() / "vehicle.yaml");
  }
  const auto inside = places.seal.lexically_relative(places.out);
  if (!inside.empty() && *inside.begin() != "..")
    return bad_input("lies inside --out, which the analysis sees", places.seal.string(),
                     "Choose a --seal elsewhere");
  AnalyseOptions a;
  if (!only_open) {
    if (by_family(o)) say(o, kRules);
    if (auto ok = hide(o, places); !ok) return Failure(ok.error());
    auto commitment = files::read_file(places.commitment(), files::kMegabyte);
    if (!commitment) return Failure(commitment.error());
    const json c = json::parse(*commitment, nullptr, false);
    if (c.is_discarded() || !c.contains("truth_sha256"))
      return bad_input("is damaged", places.commitment().string(), "Begin a new campaign in another --out");
    say(o, "truth sealed:   SHA-256 " + c["truth_sha256"].get<std::string>());

    a.places = places;
    auto command =
        o.command.empty()
            ? program("omniflight", {own_folder().parent_path().parent_path() / "omniflight_cli" / "bin"})
            : Result<std::string>(fs::absolute(o.command, ec).string());
    if (!command) return Failure(command.error());
    a.command = *command;
    a.self = this_program().string();
    if (!by_family(o))
      a.vehicle = (places.out / "vehicle" / (fs::path(o.vehicle).stem().string() + ".yaml")).string();
    a.jobs = o.jobs > 0 ? o.jobs : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    a.limit_s = o.limit_s;
    a.quiet = o.quiet;
    a.executor = o.executor;
    a.allow_unsealed = o.allow_unsealed;
    auto confinement = choose_confinement(places.seal, o.allow_unsealed);
    if (!confinement) return Failure(confinement.error());
    a.confinement = *confinement;
    if (auto ok = check_confinement(a); !ok) return Failure(ok.error());
    say(o, "analysis runs:  " + to_string(a.confinement));
    if (auto ok = analyse(a); !ok) return Failure(ok.error());
    if (o.baselines && !by_family(o)) {
      auto baselines = program("omniflight_proof_baselines");
      if (!baselines) return Failure(baselines.error());
      a.baselines = *baselines;
      say(o, "baselines ...");
      if (auto ok = run_baselines(a); !ok) return Failure(ok.error());
    }
  }
  auto frozen = freeze(places.answers(), places.frozen());
  if (!frozen) return Failure(frozen.error());
  say(o, "answers frozen: SHA-256 " + *frozen);
  if (!only_open && o.second && !by_family(o))
    if (auto ok = second_round(o, places, a); !ok) return Failure(ok.error());
  if (!only_open && !by_family(o))
    if (auto ok = ablate(o, places, a); !ok) return Failure(ok.error());
  if (!o.seal.empty() && o.reveal.empty()) {
    say(o, "the seal stays closed; open it with: omniflight prove --out " + o.out + " --reveal " + o.seal);
    return 0;
  }
  if (auto ok = open_and_score(o, places); !ok) return Failure(ok.error());
  say(o, "report: " + (places.out / "report.html").string());
  return 0;
}

/// A job of the executor, on whichever machine.
Result<int> analyse_one(const Options& o) {
  prctl(PR_SET_DUMPABLE, 0);
  AnalyseOptions a;
  a.places = {o.out, o.seal};
  a.command = o.command;
  a.self = this_program().string();
  a.vehicle = o.vehicle;
  a.limit_s = o.limit_s;
  a.second = o.of_second;
  a.ablation = o.ablation;
  a.allow_unsealed = o.allow_unsealed;
  if (auto ok = analyse_case(a, o.analyse, o.into); !ok) return Failure(ok.error());
  return 0;
}

int run_probe(const Options& o) {
  const ProbeResult r =
      probe(o.probe_seal, o.probe_secret, o.probe_readable, o.probe_writable, o.probe_parent);
  std::cout << json{{"leaks", r.leaks}, {"refused", r.refusals}, {"hindered", r.hindered}}.dump(1)
            << std::endl;
  return 0;
}

}  // namespace
}  // namespace omniflight::proof

int main(int argc, char** argv) {
  using namespace omniflight;
  // how the task of a job array calls this program
  if (argc == 4 && std::string(argv[1]) == "run-task") return jobs::run_task_main(argv[2], argv[3]);
  CLI::App app("The concealed-effect proof: hide effects on an independent plant, diagnose, open, score");
  proof::Options o;
  app.add_option("--cases", o.cases, "Cases with hidden effects")->check(CLI::Range(0, 100000));
  app.add_option("--nulls", o.nulls, "Cases without")->check(CLI::Range(0, 100000));
  app.add_option("--level", o.level, "Only this level of concealment, L1 to L6")
      ->check(CLI::IsMember({"L1", "L2", "L3", "L4", "L5", "L6"}));
  app.add_option("--out", o.out, "Folder for recordings, answers, proof.json and report.html");
  app.add_option("--seal", o.seal,
                 "Folder for the truth; given alone, it stays closed. Default: beside --out, opened");
  app.add_option("--reveal", o.reveal, "Open this seal and score the frozen answers in --out");
  const auto* const vehicle_given = app.add_option("--vehicle", o.vehicle, "Nominal vehicle");
  app.add_option("--jobs", o.jobs, "At once; default: processors")->check(CLI::Range(1, 64));
  app.add_option("--limit-s", o.limit_s, "Time of one diagnosis [s]")->check(CLI::Range(1.0, 86400.0));
  app.add_option("--salt", o.salt, "For tests only; a proof draws its own");
  app.add_option("--command", o.command, "The omniflight to prove; default: of this workspace");
  app.add_option("--ablations", o.ablations,
                 "Cases that are diagnosed again with every ablation; default: a tenth of all")
      ->check(CLI::Range(0, 100000));
  app.add_option("--proposals", o.proposals,
                 "Proposed flights that are analysed, the first by the numbers of their cases; default: all")
      ->check(CLI::Range(1, 100000));
  app.add_flag("--tuning", o.tuning, "Draw from the tuning box, not the sealed one");
  app.add_flag("--families", o.families,
               "Worlds that differ in vehicle, controller, start, manoeuvre, signals, noise and calibration");
  app.add_option("--real", o.real, "Inject effects into the real flights of this folder (with --vehicle)");
  app.add_option("--seed", o.seed, "Of --families --tuning")->check(CLI::Range(0L, 1000000000L));
  app.add_flag("--allow-unsealed", o.allow_unsealed,
               "Go on where the analysis cannot be confined; the result says so");
  app.add_flag("--baselines,!--no-baselines", o.baselines, "Textbook methods on the same cases");
  app.add_flag("--second,!--no-second", o.second,
               "Fly what is proposed for cases that could not be told apart, and diagnose both flights");
  app.add_flag("--quiet", o.quiet, "No progress");
  app.add_flag("--json", o.as_json, "proof.json on stdout");
  jobs::add_executor(app, o.executor);
  app.add_option("--analyse", o.analyse)->group("");
  app.add_option("--into", o.into)->group("");
  app.add_option("--ablation", o.ablation)->group("");
  app.add_flag("--of-second", o.of_second)->group("");
  app.add_option("--probe", o.probe_seal, "What may be done to this seal? (run inside the confinement)")
      ->group("");
  app.add_option("--probe-secret", o.probe_secret)->group("");
  app.add_option("--probe-readable", o.probe_readable)->group("");
  app.add_option("--probe-writable", o.probe_writable)->group("");
  app.add_option("--probe-parent", o.probe_parent)->group("");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : static_cast<int>(ErrorCode::bad_input);
  }
  if (!o.probe_seal.empty()) return proof::run_probe(o);
  install_interrupt_handler();
  if (!o.analyse.empty() && !vehicle_given->count()) o.vehicle.clear();  // the case has its own
  const auto result = o.analyse.empty() ? proof::prove(o) : proof::analyse_one(o);
  if (result) return *result;
  std::cerr << "omniflight prove: " << result.error().text() << "\n";
  if (o.as_json) std::cout << nlohmann::json{{"error", result.error().text()}}.dump() << "\n";
  return static_cast<int>(result.error().code);
}
