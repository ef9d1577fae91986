// Many flights, several at once; what is complete is kept when the campaign is started again.
#include <fmt/format.h>

#include <atomic>
#include <mutex>
#include <thread>

#include "bus_access.hpp"
#include "campaign.hpp"
#include "folder.hpp"
#include "investigation.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

nlohmann::json to_json(const Campaign& campaign, const std::vector<Outcome>& outcomes,
                       const std::vector<std::optional<Investigation>>& investigations,
                       const std::vector<Judgement>& judgements, std::size_t kept) {
  nlohmann::json j{{"schema", "omniflight.campaign_result/1"}, {"name", campaign.name},
                   {"planned", campaign.cases.size()},         {"kept", kept},
                   {"verdict", verdict_in_words(judgements)},  {"flights", nlohmann::json::array()},
                   {"expectations", nlohmann::json::array()}};
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
  for (const Judgement& e : judgements)
    j["expectations"].push_back({{"variant", e.expected.variant},
                                 {"effect", e.expected.effect},
                                 {"verdict", e.expected.verdict},
                                 {"flights", e.flights},
                                 {"as_expected", e.as_expected}});
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

struct Options {
  std::string file, executor = "local", keys;
  int jobs = 0;
  bool resume = false, force = false;
};

Result<int> run(const Options& o, const Common& common) {
  auto campaign = load_campaign(o.file);
  if (!campaign) return Failure(campaign.error());
  const std::string out = common.out.empty() ? fresh_folder("campaign-" + campaign->name) : common.out;
  for (Case& one : campaign->cases) {
    one.options.out = out + "/" + one.name;
    one.options.force = o.force || o.resume;
    if (o.resume) continue;
    if (auto ok = refuse_overwriting(one.options.out + "/flight.mcap", o.force); !ok) {
      ok.error().next_step =
          "Give --resume to keep what is complete, --force to fly all again, or another --out";
      return Failure(ok.error());
    }
  }
  for (Case& one : campaign->cases) {
    one.options.quiet = true;
    one.options.keys = o.keys;
  }
  // an unknown mission, effect, sensor or vehicle is told now, not after an hour
  for (const Case& one : campaign->cases)
    if (const auto print = fingerprint(one.options); !print) return Failure(print.error());
  const auto folder = FolderLock::take(out);
  if (!folder) return Failure(folder.error());
  std::vector<Outcome> outcomes(campaign->cases.size());
  std::atomic<std::size_t> next{0}, done{0}, kept{0};
  std::mutex mutex;
  Progress progress("campaign", static_cast<double>(outcomes.size()), "flights", common.quiet);
  const auto work = [&] {
    for (std::size_t k = next++; k < outcomes.size() && !interrupted(); k = next++) {
      Outcome& outcome = outcomes[k];
      outcome.flight = campaign->cases[k];
      if (auto before = o.resume ? flown_before(outcome.flight.options) : std::nullopt) {
        outcome.json = std::move(*before);
        ++kept;
      } else if (auto result = fly(outcome.flight.options)) {
        outcome.json = std::move(result->json);
      } else {
        outcome.json = {{"verdict", kNotFlown}, {"reason", result.error().text()}};
      }
      outcome.verdict = outcome.json.value("verdict", "");
      outcome.reason = outcome.json.value("reason", "");
      const std::lock_guard lock(mutex);
      progress.update(static_cast<double>(++done));
    }
  };
  const int jobs = o.jobs > 0 ? o.jobs : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::thread> threads;
  for (int i = 0; i < jobs; ++i) threads.emplace_back(work);
  for (auto& t : threads) t.join();
  progress.finish();
  std::erase_if(outcomes, [](const Outcome& r) {  // after Ctrl-C: what is complete
    return r.verdict.empty() || r.reason == "interrupted";
  });
  const auto judgements = judge(*campaign, outcomes);
  const auto investigations = investigate_all(*campaign, outcomes, o.resume, common);
  if (!investigations) return Failure(investigations.error());
  for (std::size_t k = 0; k < outcomes.size(); ++k)
    if (const auto& found = (*investigations)[k]) {
      outcomes[k].investigation = in_words(*found);
      outcomes[k].cause = found->cause();
      outcomes[k].flights = found->rounds.size();
    }
  const nlohmann::json j = to_json(*campaign, outcomes, *investigations, judgements, kept.load());
  if (auto ok = files::write_file_atomic(out + "/campaign.json", j.dump(2) + "\n"); !ok)
    return Failure(ok.error());
  if (auto ok = write_campaign_page(*campaign, outcomes, judgements, out); !ok) return Failure(ok.error());
  print_json(common, j);
  const auto flown = std::count_if(outcomes.begin(), outcomes.end(), [](auto& r) { return r.flown(); });
  say(common, fmt::format("campaign {}: {} of {} flights flown ({} kept from before); report: {}/report.html",
                          campaign->name, flown, campaign->cases.size(), kept.load(), out));
  for (const Judgement& e : judgements) say(common, "  " + e.words());
  for (const Outcome& r : outcomes)
    if (!r.investigation.empty()) say(common, "  " + r.flight.name + ": " + r.investigation);
  const bool met =
      std::all_of(judgements.begin(), judgements.end(), [](const Judgement& e) { return e.met(); });
  return outcomes.size() == campaign->cases.size() && met ? 0 : static_cast<int>(ErrorCode::incomplete);
}

}  // namespace

Action add_campaign(CLI::App& verb, Common& common) {
  auto o = std::make_shared<Options>();
  verb.add_option("file", o->file, "Campaign YAML")->required();
  verb.add_option("--jobs", o->jobs, "Flights at once; default: processors")->check(CLI::Range(1, 64));
  verb.add_option("--executor", o->executor, "local")->check(CLI::IsMember({"local"}));
  add_secure(verb, o->keys);
  verb.add_flag("--resume", o->resume,
                "Keep flights that are complete in --out and were made of the same inputs");
  verb.add_flag("--force", o->force, "Fly all again over the recordings that are in --out")
      ->excludes("--resume");
  return [o, &common]() -> Result<int> { return run(*o, common); };
}

}  // namespace omniflight::cli
