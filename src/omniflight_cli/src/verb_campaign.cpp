// Many flights: the product of missions, vehicles, effects, gains and seeds, several at once, resumable.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <thread>

#include "compare.hpp"
#include "flight.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

struct Case {
  std::string name;
  FlightOptions options;
};

struct Campaign {
  std::string name;
  std::vector<Case> cases;
};

/// "controller.ki" and so on; values stay YAML text.
std::map<std::string, std::string> read_parameters(files::YamlReader yaml) {
  std::map<std::string, std::string> out;
  for (const std::string& key : yaml.keys()) out[key] = yaml.string(key);
  return out;
}

Result<Campaign> load(const std::string& path) {
  auto yaml = files::YamlReader::load(path);
  if (!yaml) return Failure(yaml.error());
  if (yaml->string("schema") != "omniflight.campaign/1")
    yaml->error_at("schema", "is not omniflight.campaign/1");
  Campaign c;
  c.name = yaml->string("name");
  yaml->ignore("notes");
  FlightOptions base;
  base.plant = yaml->string("plant", "simulator");
  base.sensors = yaml->string("sensors", "laboratory");
  base.realtime = base.plant != "simulator";
  base.in_process = base.plant == "simulator" && yaml->boolean("in_process", true);
  const auto missions = yaml->strings("missions");
  std::vector<std::string> effects = yaml->strings("effects", false),
                           vehicles = yaml->strings("vehicles", false);
  if (effects.empty()) effects = {"none"};
  if (vehicles.empty()) vehicles = {""};
  const auto seeds = yaml->numbers("seeds", 0, files::between(0, 1e9));
  struct Variant {
    std::string name;
    std::map<std::string, std::string> parameters;
    std::string weights, tilt;
  };
  std::vector<Variant> variants;
  for (auto v : yaml->children("variants", 0, 100)) {
    Variant variant{v.string("name"), {}, v.string("weights", "case_a"), v.string("tilt", "fixed")};
    if (auto p = v.optional_child("parameters")) variant.parameters = read_parameters(*p);
    variants.push_back(variant);
  }
  if (variants.empty()) variants.push_back({"standard", {}, "case_a", "fixed"});
  if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  for (const auto& mission : missions)
    for (const auto& vehicle : vehicles)
      for (const auto& effect : effects)
        for (const auto& variant : variants)
          for (const double seed : seeds) {
            Case one;
            one.options = base;
            one.options.mission = mission;
            one.options.vehicle = vehicle;
            one.options.effects = effect == "none" ? "" : effect;
            one.options.parameters = variant.parameters;
            one.options.weights = variant.weights;
            one.options.tilt_mode = variant.tilt;
            one.options.seed = static_cast<std::uint64_t>(seed);
            one.name = fs::path(mission).stem().string() + (vehicle.empty() ? "" : "-" + vehicle) + "-" +
                       fs::path(effect).stem().string() + "-" + variant.name + "-seed" +
                       std::to_string(one.options.seed);
            c.cases.push_back(std::move(one));
          }
  if (c.cases.empty()) return bad_input("gives no flight", path, "Give missions and seeds");
  if (c.cases.size() > 10000) return bad_input("gives more than 10000 flights", path);
  return c;
}

struct Row {
  std::string name, verdict, reason;
  nlohmann::json json;
};

double number(const nlohmann::json& j, const char* pointer) {
  const auto p = nlohmann::json::json_pointer(pointer);
  return j.contains(p) && j[p].is_number() ? j[p].get<double>() : std::nan("");
}

double position_rmse(const nlohmann::json& j) {
  double sum = 0;
  const std::string root =
      j.contains(nlohmann::json::json_pointer("/metrics/true")) ? "/metrics/true" : "/metrics/measured";
  for (const char* axis : {"x", "y", "z"}) {
    const double e = number(j, (root + "/position_rmse_m/" + axis).c_str());
    sum += e * e;
  }
  return std::sqrt(sum);
}

Status write_report(const Campaign& c, std::vector<Row> rows, const std::string& out) {
  // not flown first, then by position error
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
    const double ea = position_rmse(a.json), eb = position_rmse(b.json);
    return (std::isfinite(ea) ? ea : 1e9) > (std::isfinite(eb) ? eb : 1e9);
  });
  const auto flown =
      std::count_if(rows.begin(), rows.end(), [](const Row& r) { return r.verdict == "flown"; });
  report::Page page("Campaign " + c.name, fmt::format("{} flights, {} flown to the end", rows.size(), flown));
  report::Table t;
  t.caption = "Ranked by position error, largest first";
  t.columns = {{.name = "flight"},
               {.name = "verdict"},
               {.name = "position RMSE", .unit = "m"},
               {.name = "z RMSE", .unit = "m"},
               {.name = "mean power", .unit = "W"},
               {.name = "integral action z", .unit = "m/s2"},
               {.name = "wall time", .unit = "s"}};
  report::Bars bars{.title = "Position RMSE", .unit = "m"}, power{.title = "Mean power", .unit = "W"};
  for (const Row& r : rows) {
    const std::string root = r.json.contains(nlohmann::json::json_pointer("/metrics/true"))
                                 ? "/metrics/true"
                                 : "/metrics/measured";
    const double e = position_rmse(r.json), z = number(r.json, (root + "/position_rmse_m/z").c_str());
    const double p = number(r.json, "/metrics/power_W"),
                 i = number(r.json, "/metrics/mean_integral_action/2");
    t.rows.push_back({report::Cell(r.name),
                      report::Cell(r.verdict == "flown" ? r.verdict : r.verdict + ": " + r.reason),
                      report::Cell(e), report::Cell(z), report::Cell(p), report::Cell(i),
                      report::Cell(number(r.json, "/wall_s"))});
    if (std::isfinite(e) && bars.bars.size() < 60) bars.bars.push_back({.name = r.name, .value = e});
    if (std::isfinite(p) && power.bars.size() < 60) power.bars.push_back({.name = r.name, .value = p});
  }
  page.section("Flights").table(t);
  page.section("Compared").bars(bars).bars(power);
  return page.write(out + "/report.html");
}

}  // namespace

Action add_campaign(CLI::App& verb, Common& common) {
  struct Options {
    std::string file, executor = "local";
    int jobs = 0;
    bool resume = false;
  };
  auto o = std::make_shared<Options>();
  verb.add_option("file", o->file, "Campaign YAML")->required();
  verb.add_option("--jobs", o->jobs, "Flights at once; default: processors")->check(CLI::Range(1, 64));
  verb.add_option("--executor", o->executor, "local")->check(CLI::IsMember({"local"}));
  verb.add_flag("--resume", o->resume, "Keep flights that are complete in --out");
  return [o, &common]() -> Result<int> {
    auto campaign = load(o->file);
    if (!campaign) return Failure(campaign.error());
    const std::string out = common.out.empty() ? "runs/campaign-" + campaign->name : common.out;
    if (auto ok = make_folder(out); !ok) return Failure(ok.error());
    std::vector<Row> rows(campaign->cases.size());
    std::atomic<std::size_t> next{0}, done{0}, kept{0};
    std::mutex mutex;
    Progress progress("campaign", static_cast<double>(rows.size()), "flights", common.quiet);
    const auto work = [&] {
      for (std::size_t k = next++; k < rows.size() && !interrupted(); k = next++) {
        Case& one = campaign->cases[k];
        one.options.out = out + "/" + one.name;
        one.options.quiet = true;
        rows[k].name = one.name;
        const std::string file = one.options.out + "/flight.json";
        if (o->resume) {
          auto text = files::read_file(file, files::kMegabyte);
          auto j = text ? nlohmann::json::parse(*text, nullptr, false) : nlohmann::json();
          if (j.is_object() && j.value("schema", "") == "omniflight.flight/1" &&
              j.value("seed", std::uint64_t{0}) == one.options.seed) {
            rows[k].json = j;
            rows[k].verdict = j.value("verdict", "");
            rows[k].reason = j.value("reason", "");
            ++done, ++kept;
            continue;
          }
        }
        auto result = fly(one.options);
        if (result) {
          rows[k].json = result->json;
          rows[k].verdict = result->json.value("verdict", "");
          rows[k].reason = result->reason;
        } else {
          rows[k].verdict = "not flown to the end";
          rows[k].reason = result.error().text();
        }
        const std::lock_guard lock(mutex);
        progress.update(static_cast<double>(++done));
      }
    };
    const int jobs =
        o->jobs > 0 ? o->jobs : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    std::vector<std::thread> threads;
    for (int i = 0; i < jobs; ++i) threads.emplace_back(work);
    for (auto& t : threads) t.join();
    progress.finish();
    std::erase_if(rows, [](const Row& r) { return r.verdict.empty(); });  // after Ctrl-C: what is complete
    nlohmann::json j{{"schema", "omniflight.campaign_result/1"},
                     {"name", campaign->name},
                     {"planned", campaign->cases.size()},
                     {"kept", kept.load()}};
    j["flights"] = nlohmann::json::array();
    std::size_t flown = 0;
    for (const Row& r : rows) {
      flown += r.verdict == "flown";
      j["flights"].push_back(
          {{"name", r.name}, {"verdict", r.verdict}, {"reason", r.reason}, {"flight", r.json}});
    }
    if (auto ok = files::write_file_atomic(out + "/campaign.json", j.dump(2) + "\n"); !ok)
      return Failure(ok.error());
    if (auto ok = write_report(*campaign, rows, out); !ok) return Failure(ok.error());
    print_json(common, j);
    say(common,
        fmt::format(
            "campaign {}: {} of {} flights flown to the end ({} kept from before); report: {}/report.html",
            campaign->name, flown, campaign->cases.size(), kept.load(), out));
    return rows.size() == campaign->cases.size() ? 0 : static_cast<int>(ErrorCode::incomplete);
  };
}

}  // namespace omniflight::cli
