// Each flight of a campaign over the bus, as a job of its own; what is complete is kept when the campaign is
// started again.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "bus_access.hpp"
#include "campaign_run.hpp"
#include "folder.hpp"
#include "investigation.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

nlohmann::json to_json(const Campaign& campaign, const std::vector<Outcome>& outcomes,
                       const std::vector<std::optional<Investigation>>& investigations,
                       const std::vector<Judgement>& judgements, std::size_t kept,
                       const nlohmann::json& executor) {
  nlohmann::json j{{"schema", "omniflight.campaign_result/1"},
                   {"name", campaign.name},
                   {"planned", campaign.cases.size()},
                   {"kept", kept},
                   {"verdict", verdict_in_words(judgements)},
                   {"flights", nlohmann::json::array()},
                   {"executor", executor},
                   {"expectations", to_json(judgements)}};
  for (const Outcome& o : outcomes)
    j["flights"].push_back({{"name", o.flight.name},
                            {"mission", o.flight.mission},
                            {"effect", o.flight.effect},
                            {"variant", o.flight.variant},
                            {"verdict", o.verdict},
                            {"reason", o.reason},
                            {"flight", o.json}});
  for (std::size_t k = 0; k < investigations.size(); ++k)
    if (investigations[k]) j["flights"][k]["investigation"] = to_json(*investigations[k]);
  return j;
}

/// Of every flown case, one after another: each uses all processors.
Result<std::vector<std::optional<Investigation>>> investigate_all(const Campaign& campaign,
                                                                  const std::vector<Outcome>& outcomes,
                                                                  bool keep, const Common& common) {
  std::vector<std::optional<Investigation>> out(outcomes.size());
  if (campaign.more_flights < 0) return out;
  Progress progress("diagnosing and flying on", static_cast<double>(outcomes.size()), "cases", common.quiet);
  for (std::size_t k = 0; k < outcomes.size() && !interrupted(); ++k) {
    if (outcomes[k].survived()) {
      auto found = investigate(outcomes[k].flight, campaign.more_flights, keep);
      if (!found) return Failure(found.error());
      out[k] = std::move(*found);
    }
    progress.update(static_cast<double>(k + 1));
  }
  return out;
}

/// Refuses what is there without being asked for, and an input that nobody has; told now, not after an hour.
Status check_flights(const CampaignOptions& o, Campaign& campaign, const std::string& out) {
  for (Case& one : campaign.cases) {
    one.options.out = out + "/" + one.name;
    one.options.force = true;
    one.options.keys = o.keys;
    if (o.resume) continue;
    if (auto ok = refuse_overwriting(one.options.out + "/flight.mcap", o.force); !ok) {
      ok.error().next_step =
          "Give --resume to keep what is complete, --force to fly all again, or another --out";
      return ok;
    }
  }
  for (const Case& one : campaign.cases)
    if (const auto print = fingerprint(one.options); !print) return Failure(print.error());
  return {};
}

std::vector<jobs::Job> jobs_of(const CampaignOptions& o, const Campaign& campaign) {
  std::vector<jobs::Job> list;
  const std::string file = fs::absolute(o.file).string();
  for (const Case& one : campaign.cases) {
    jobs::Job job;
    job.name = one.name;
    job.folder = fs::absolute(one.options.out).lexically_normal();
    job.command = {"campaign", file, "--only", one.name, "--out", jobs::kOut, "--quiet"};
    if (!o.keys.empty()) job.command.insert(job.command.end(), {"--secure", fs::absolute(o.keys).string()});
    list.push_back(std::move(job));
  }
  return list;
}

/// Of a flight that left a folder: flight.json.
nlohmann::json result_of(const Case& one) {
  const auto text = files::read_file(one.options.out + "/flight.json", files::kMegabyte);
  const auto j = text ? nlohmann::json::parse(*text, nullptr, false) : nlohmann::json();
  if (j.is_object()) return j;
  return {{"verdict", kNotFlown}, {"reason", text ? "flight.json is damaged" : text.error().text()}};
}

struct FlownCampaign {
  std::vector<Outcome> outcomes;
  std::size_t kept = 0;
  jobs::Ran ran;
};

/// Flies what is not kept, and reads what there is; flights that were interrupted are left out.
Result<FlownCampaign> fly_all(const CampaignOptions& o, const Campaign& campaign, const std::string& out,
                              jobs::Executor& executor, const Common& common) {
  FlownCampaign flown;
  for (const Case& one : campaign.cases) {
    if (o.resume && flown_before(one.options)) {
      ++flown.kept;
      continue;
    }
    if (auto ok = clear_away(one.options.out); !ok) return Failure(ok.error());
  }
  Progress progress("campaign", static_cast<double>(campaign.cases.size()), "flights", common.quiet);
  auto ran = executor.run(work_of(out, jobs_of(o, campaign), common,
                                  [&](std::size_t done) { progress.update(static_cast<double>(done)); }));
  progress.finish();
  if (!ran) return Failure(ran.error());
  std::vector<std::string> missing(campaign.cases.size());
  for (const auto& m : ran->missing) missing[m.job] = m.reason;
  for (std::size_t k = 0; k < campaign.cases.size(); ++k) {
    Outcome outcome;
    outcome.flight = campaign.cases[k];
    std::error_code ec;
    if (fs::is_directory(outcome.flight.options.out, ec))
      outcome.json = result_of(outcome.flight);
    else if (ran->stopped)
      continue;
    else
      outcome.json = {{"verdict", kNotFlown}, {"reason", missing[k]}};
    outcome.verdict = outcome.json.value("verdict", "");
    outcome.reason = outcome.json.value("reason", "");
    if (!outcome.verdict.empty() && outcome.reason != "interrupted")
      flown.outcomes.push_back(std::move(outcome));
  }
  flown.ran = std::move(*ran);
  return flown;
}

}  // namespace

Result<int> fly_one(const CampaignOptions& o, const Common& common) {
  auto campaign = load_campaign(o.file);
  if (!campaign) return Failure(campaign.error());
  for (Case& one : campaign->cases) {
    if (one.name != o.only) continue;
    one.options.out = common.out;
    one.options.force = true;
    one.options.keys = o.keys;
    const auto result = fly_as_job(one.options, o.only);
    if (!result) return Failure(result.error());
    return 0;
  }
  return bad_input("there is no flight " + files::shown(o.only), o.file);
}

Result<int> run_over_bus(const CampaignOptions& o, const Common& common) {
  auto campaign = load_campaign(o.file);
  if (!campaign) return Failure(campaign.error());
  const std::string out = common.out.empty() ? fresh_folder("campaign-" + campaign->name) : common.out;
  if (auto ok = check_flights(o, *campaign, out); !ok) return Failure(ok.error());
  const auto executor = jobs::make_executor(o.executor);
  if (!executor) return Failure(executor.error());
  const auto folder = FolderLock::take(out);
  if (!folder) return Failure(folder.error());
  auto flown = fly_all(o, *campaign, out, **executor, common);
  if (!flown) return Failure(flown.error());
  std::vector<Outcome>& outcomes = flown->outcomes;
  const auto judgements = judge(*campaign, outcomes);
  const auto investigations = investigate_all(*campaign, outcomes, o.resume, common);
  if (!investigations) return Failure(investigations.error());
  for (std::size_t k = 0; k < outcomes.size(); ++k)
    if (const auto& found = (*investigations)[k]) {
      outcomes[k].investigation = in_words(*found);
      outcomes[k].cause = found->cause();
      outcomes[k].flights = found->rounds.size();
    }
  const nlohmann::json j =
      to_json(*campaign, outcomes, *investigations, judgements, flown->kept, to_json(flown->ran, o.executor));
  if (auto ok = files::write_file_atomic(out + "/campaign.json", j.dump(2) + "\n"); !ok)
    return Failure(ok.error());
  if (auto ok = write_campaign_page(*campaign, outcomes, judgements, out); !ok) return Failure(ok.error());
  print_json(common, j);
  const auto good = std::count_if(outcomes.begin(), outcomes.end(), [](auto& r) { return r.flown(); });
  say(common, fmt::format("campaign {}: {} of {} flights flown ({} kept from before); report: {}/report.html",
                          campaign->name, good, campaign->cases.size(), flown->kept, out));
  say_executor(common, flown->ran);
  for (const Judgement& e : judgements) say(common, "  " + e.words());
  for (const Outcome& r : outcomes)
    if (!r.investigation.empty()) say(common, "  " + r.flight.name + ": " + r.investigation);
  const bool met =
      std::all_of(judgements.begin(), judgements.end(), [](const Judgement& e) { return e.met(); });
  return outcomes.size() == campaign->cases.size() && met ? 0 : static_cast<int>(ErrorCode::incomplete);
}

}  // namespace omniflight::cli
