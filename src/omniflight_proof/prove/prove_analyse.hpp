// The middle of the proof: every recording through the analysis, where it cannot see the truth.
#pragma once

#include <string>
#include <vector>

#include "omniflight_jobs/executor.hpp"
#include "prove_files.hpp"
#include "prove_sandbox.hpp"

namespace omniflight::proof {

struct AnalyseOptions {
  Places places;
  std::string command;    ///< full path of omniflight
  std::string baselines;  ///< full path of omniflight_proof_baselines; empty: none are run
  std::string vehicle;    ///< YAML below OUT/vehicle; empty: every case has its own
  std::string self;       ///< full path of the program that has --probe
  Confinement confinement = Confinement::none;
  int jobs = 1;
  double limit_s = 600;  ///< a case
  bool quiet = false;
  bool second = false;             ///< the flights in OUT/next, each together with the one before
  std::string ablation;            ///< of the diagnosis; empty: whole
  std::size_t most = 0;            ///< cases, the first by name; 0: all
  jobs::ExecutorOptions executor;  ///< of the diagnoses; local: children of this process
  bool allow_unsealed = false;
  std::filesystem::path flights() const { return second ? places.next() : places.cases(); }
  std::filesystem::path answers() const {
    return !ablation.empty() ? places.ablations() / ablation
           : second          ? places.answers_next()
                             : places.answers();
  }
};

/// One case on whichever machine this is, into the folder `into`: confined by what this machine can, and
/// probed here. Errors: as choose_confinement() and check_confinement().
Status analyse_case(AnalyseOptions options, const std::string& name, const std::filesystem::path& into);
/// Runs the probe inside the confinement and writes OUT/probe.json. With a confinement, any leak is an error;
/// so is anything that hinders the analysis.
Status check_confinement(const AnalyseOptions& options);
/// `omniflight diagnose` on every case that has no answer yet; OUT/answers/CASE appears when it is complete.
/// Errors: interrupted (resumable), no processes. A case that fails is an answer, too: run.json has exit code
/// and time.
Status analyse(const AnalyseOptions& options);
/// The textbook methods on the same recordings, in the same confinement: OUT/answers/baselines.json.
Status run_baselines(const AnalyseOptions& options);
/// Writes the hashes of all answers to `frozen` and makes the answers read-only. Returns its SHA-256. When it
/// exists already, the answers must still have those hashes.
Result<std::string> freeze(const std::filesystem::path& answers, const std::filesystem::path& frozen);

}  // namespace omniflight::proof
