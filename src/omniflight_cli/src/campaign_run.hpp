// The ways in which a campaign is flown.
#pragma once

#include "campaign.hpp"
#include "omniflight_jobs/executor.hpp"
#include "verbs.hpp"

namespace omniflight::cli {

struct CampaignOptions {
  std::string file, keys;
  jobs::ExecutorOptions executor;
  bool in_process = false, resume = false, force = false;
  int flights_per_job = 0;  ///< in process; 0: so that every processor has some
  // of a job of the campaign
  std::string only;   ///< name of the one flight
  std::string part;   ///< "GROUP:FIRST:COUNT"
  std::string plans;  ///< folder of what the flights of each group share
};

/// Over the bus, a job a flight: OUT/FLIGHT. Then investigations, campaign.json and report.html.
Result<int> run_over_bus(const CampaignOptions& options, const Common& common);
/// One of its jobs.
Result<int> fly_one(const CampaignOptions& options, const Common& common);

/// Without a bus, a job some flights: OUT/parts/PART. Then campaign.json and report.html.
Result<int> run_in_process(const CampaignOptions& options, const Common& common);
/// One of its jobs.
Result<int> fly_part(const CampaignOptions& options, const Common& common);

/// The work of a verb for the executor: this program, its task runner, Ctrl-C and progress.
/// `progress` is not touched after the run.
jobs::Work work_of(const std::string& out, std::vector<jobs::Job> list, const Common& common,
                   std::function<void(std::size_t)> progress);
/// The full path of this program, which runs the jobs.
std::string this_program();
/// Flies a job's flight into options.out. An interrupted one leaves nothing: half a flight is no result, and
/// nobody may take it for one.
Result<FlightResult> fly_as_job(const FlightOptions& options, const std::string& name);
/// Moves what is at `folder` out of the way of a new result and removes it; nothing there is fine.
Status clear_away(const std::string& folder);
/// What went on beside the flights: arrays, requeued tasks, remarks of the executor.
void say_executor(const Common& common, const jobs::Ran& ran);
nlohmann::json to_json(const jobs::Ran& ran, const jobs::ExecutorOptions& options);

}  // namespace omniflight::cli
