// A campaign without a bus: plans once a group, lets the executor fly the parts, and tells what they say.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <thread>

#include "campaign_many.hpp"
#include "flight_setup.hpp"
#include "folder.hpp"
#include "omniflight_components/tilt_schedule_file.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "version.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kUsual = 32, kMost = 1024;  // flights of a job

/// Everything that decides the flights of a group but their seeds.
std::string inputs_of(const Campaign& c, const Setup& s) {
  nlohmann::json j{{"flight", s.fingerprint}, {"version", kVersion}, {"vary", nlohmann::json::array()}};
  for (const campaign::Varied& v : c.varied)
    j["vary"].push_back({static_cast<int>(v.of), v.name, v.effect, v.parameter,
                         static_cast<int>(v.distribution.kind), v.distribution.a, v.distribution.b,
                         v.distribution.least, v.distribution.most});
  return files::sha256_hex(j.dump());
}

/// That every effect of the group's model can act in flights without sensors.
Status check_effects(const Setup& s) {
  if (s.effects.empty()) return {};
  const auto model = physics::load_model(s.effects);
  if (!model) return Failure(model.error());
  for (const auto& e : model->effects)
    if (!campaign::acts_without_sensors(*e.effect))
      return bad_input(
          "the effect " + e.effect->info().id + " acts on sensors, which flights in process have not",
          s.effects, "Leave --in-process out, or take another model");
  return {};
}

/// The plan of a group and the parameters of its components, for all its flights. The hash of its inputs.
Result<std::string> share_plan(const Campaign& c, const Case& group, const std::string& plans) {
  FlightOptions o = group.options;
  o.out = plans + "/" + group.name;
  std::error_code ec;
  const std::string key_file = o.out + "/inputs.sha256";
  if (const auto before = files::read_file(key_file, 1000)) {  // the plan of an earlier start
    FlightOptions again = o;
    again.plan = o.out;
    if (const auto s = plan_flight(again); s && inputs_of(c, *s) == *before) return *before;
  }
  const auto s = plan_flight(o);
  if (!s) return Failure(s.error());
  fs::remove(key_file, ec);
  if (auto ok = make_folder(o.out); !ok) return Failure(ok.error());
  if (auto ok = write_inputs(*s); !ok) return Failure(ok.error());
  if (auto ok = check_effects(*s); !ok) return Failure(ok.error());
  if (auto ok = planning::write_plan(s->plan, o.out); !ok) return Failure(ok.error());
  if (auto ok = files::write_file_atomic(o.out + "/params.yaml", parameters(o, *s)); !ok)
    return Failure(ok.error());
  const std::string key = inputs_of(c, *s);
  if (auto ok = files::write_file_atomic(key_file, key); !ok) return Failure(ok.error());
  return key;
}

std::vector<Part> parts_of(const CampaignOptions& o, const Campaign& c) {
  std::size_t each = static_cast<std::size_t>(o.flights_per_job);
  if (each == 0) {
    each = kUsual;
    if (o.executor.name == "local") {  // four jobs a processor, so that none waits long for the last
      const std::size_t quarter =
          c.groups.size() * c.seeds.size() / (4 * static_cast<std::size_t>(o.executor.at_once()));
      each = std::clamp(quarter / kUsual * kUsual, kUsual, kMost);
    }
  }
  std::vector<Part> parts;
  for (std::size_t g = 0; g < c.groups.size(); ++g)
    for (std::size_t first = 0; first < c.seeds.size(); first += each)
      parts.push_back({g, first, std::min(each, c.seeds.size() - first)});
  return parts;
}

/// Its result, when it is one of these inputs and has the flights that it shall have.
Result<PartResult> result_of(const Campaign& c, const Part& part, const std::string& inputs,
                             const std::string& folder) {
  auto read = read_part(folder + "/part.json");
  if (!read) return read;
  bool same = read->inputs == inputs && read->flights.size() == part.count;
  for (std::size_t k = 0; same && k < part.count; ++k)
    same = read->flights[k].group == part.group && read->flights[k].seed == c.seeds[part.first + k] &&
           read->flights[k].drawn.size() == c.varied.size();
  if (!same) return bad_input("was made of other inputs", folder, "Give --force, or another --out");
  return read;
}

Result<ManyFlights> fly_parts(const CampaignOptions& o, const Campaign& c, const std::string& out,
                              jobs::Executor& executor, const Common& common) {
  ManyFlights all;
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::string> inputs;
  const std::string plans = fs::absolute(out + "/plans").lexically_normal().string();
  for (const Case& group : c.groups) {
    auto key = share_plan(c, group, plans);
    if (!key) return Failure(key.error());
    inputs.push_back(std::move(*key));
  }
  all.plan_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const std::vector<Part> parts = parts_of(o, c);
  std::vector<jobs::Job> list;
  for (const Part& part : parts) {
    jobs::Job job;
    job.name = part.name(c);
    job.folder = fs::absolute(out + "/parts/" + job.name).lexically_normal();
    job.command = {"campaign",     fs::absolute(o.file).string(),
                   "--in-process", "--part",
                   part.spec(),    "--plans",
                   plans,          "--out",
                   jobs::kOut,     "--quiet"};
    if (is_done(job)) {
      const auto before = result_of(c, part, inputs[part.group], job.folder.string());
      if (o.resume && before)
        all.kept += part.count;
      else if (!o.resume && !o.force)
        return bad_input(
            "is there already and is not overwritten", job.folder.string(),
            "Give --resume to keep what is complete, --force to fly all again, or another --out");
      else if (auto ok = clear_away(job.folder.string()); !ok)
        return Failure(ok.error());
    }
    list.push_back(std::move(job));
  }
  Progress progress("campaign", static_cast<double>(parts.size()), "jobs", common.quiet);
  auto ran = executor.run(
      work_of(out, list, common, [&](std::size_t done) { progress.update(static_cast<double>(done)); }));
  progress.finish();
  if (!ran) return Failure(ran.error());
  for (const auto& m : ran->missing) all.missing.push_back(list[m.job].name + ": " + m.reason);
  const auto collect = std::chrono::steady_clock::now();
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (!is_done(list[k])) continue;
    auto one = result_of(c, parts[k], inputs[parts[k].group], list[k].folder.string());
    if (!one) return Failure(one.error());
    all.cpu_s += one->cpu_s;
    all.simulated_s = std::max(all.simulated_s, one->simulated_s);
    for (ManyFlight& f : one->flights) all.flights.push_back(std::move(f));
  }
  all.ran = std::move(*ran);
  all.ran.collect_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - collect).count();
  return all;
}

}  // namespace

Result<int> run_in_process(const CampaignOptions& o, const Common& common) {
  const auto c = load_campaign(o.file, Flying::in_process);
  if (!c) return Failure(c.error());
  const auto executor = jobs::make_executor(o.executor);
  if (!executor) return Failure(executor.error());
  const std::string out = common.out.empty() ? fresh_folder("campaign-" + c->name) : common.out;
  const auto folder = FolderLock::take(out);
  if (!folder) return Failure(folder.error());
  const auto all = fly_parts(o, *c, out, **executor, common);
  if (!all) return Failure(all.error());
  const auto report = std::chrono::steady_clock::now();
  std::map<std::pair<std::size_t, std::string>, std::size_t> counts;
  for (const ManyFlight& f : all->flights) ++counts[{f.group, f.verdict}];
  std::vector<Tally> tallies;
  for (const auto& [key, count] : counts) tallies.push_back({&c->groups[key.first], key.second, count});
  // where chance decides, a flight that is not flown is a result: only the file's own expectations are held
  const auto judgements = c->expected.empty() ? std::vector<Judgement>{} : judge(*c, tallies);
  const auto statistics = statistics_of(*c, *all);
  nlohmann::json j = to_json(*c, *all, statistics, judgements, o.executor);
  if (auto ok = write_many_page(*c, *all, statistics, judgements, out); !ok) return Failure(ok.error());
  const double report_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - report).count();
  j["seconds"]["report"] = report_s;
  if (auto ok = files::write_file_atomic(out + "/campaign.json", j.dump() + "\n"); !ok)
    return Failure(ok.error());
  print_json(common, j);
  const std::size_t planned = c->groups.size() * c->seeds.size();
  std::size_t good = 0;
  for (const ManyFlight& f : all->flights) good += f.verdict == kFlown;
  say(common, fmt::format("campaign {}: {} of {} flights flown ({} kept from before); report: {}/report.html",
                          c->name, good, planned, all->kept, out));
  if (all->cpu_s > 0)
    say(common,
        fmt::format(
            "  {:.1f} flights of {:.1f} s a second on one core ({:.1f} s of processor time); planning "
            "{:.2f} s, flying {:.1f} s, collection {:.2f} s, report {:.2f} s",
            static_cast<double>(all->flights.size()) / all->cpu_s, all->simulated_s, all->cpu_s, all->plan_s,
            all->ran.work_s, all->ran.collect_s, report_s));
  say_executor(common, all->ran);
  for (const GroupStatistics& g : statistics)
    say(common, fmt::format("  {}: flown {}, lost {}; position RMSE median {}, 95 % below {}",
                            c->groups[g.group].name, words(g.flown, 100, "%"), words(g.lost, 100, "%"),
                            words(g.median_rmse, 1e3, "mm"), words(g.rmse_95, 1e3, "mm")));
  for (const Judgement& e : judgements) say(common, "  " + e.words());
  for (const std::string& m : all->missing) say(common, "  no result: " + m);
  const bool met =
      std::all_of(judgements.begin(), judgements.end(), [](const Judgement& e) { return e.met(); });
  return all->flights.size() == planned && met ? 0 : static_cast<int>(ErrorCode::incomplete);
}

}  // namespace omniflight::cli
