// `campaign`: many flights, on this machine or on a cluster.
#include <CLI/CLI.hpp>

#include "bus_access.hpp"
#include "campaign_run.hpp"
#include "omniflight_jobs/executor_cli.hpp"

namespace omniflight::cli {

Action add_campaign(CLI::App& verb, Common& common) {
  auto o = std::make_shared<CampaignOptions>();
  verb.add_option("file", o->file, "Campaign YAML")->required();
  verb.add_flag("--in-process", o->in_process,
                "Many flights at once without bus, sensors, estimator and failsafe: no recordings, but "
                "statistics and what they depend on");
  verb.add_option("--jobs", o->executor.jobs, "Jobs at once on this machine; default: processors")
      ->check(CLI::Range(1, 64));
  verb.add_option("--flights-per-job", o->flights_per_job,
                  "With --in-process: flights of a job; default: 32, more where all run on this machine")
      ->check(CLI::Range(1, 100000));
  jobs::add_executor(verb, o->executor);
  add_secure(verb, o->keys);
  verb.add_flag("--resume", o->resume,
                "Keep flights that are complete in --out and were made of the same inputs");
  verb.add_flag("--force", o->force, "Fly all again over the recordings that are in --out")
      ->excludes("--resume");
  // of a job of the campaign
  verb.add_option("--only", o->only)->group("");
  verb.add_option("--part", o->part)->group("");
  verb.add_option("--plans", o->plans)->group("");
  return [o, &common]() -> Result<int> {
    if (!o->only.empty()) return fly_one(*o, common);
    if (!o->part.empty()) return fly_part(*o, common);
    return o->in_process ? run_in_process(*o, common) : run_over_bus(*o, common);
  };
}

}  // namespace omniflight::cli
