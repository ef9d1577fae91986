// `reproduce`: the figures of the OmniMorph thesis, computed anew, on one page.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <thread>

#include "folder.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_jobs/executor_cli.hpp"
#include "omniflight_reproduction/page.hpp"
#include "reproduction_flights.hpp"
#include "verbs.hpp"
#include "version.hpp"

namespace omniflight::cli {
namespace {

using reproduction::Computed;
using reproduction::Figure;
using reproduction::Finding;
using reproduction::Inputs;

constexpr const char* kFigureSchema = "omniflight.reproduced_figure/1";
constexpr std::size_t kLargestFigure = 64 * files::kMegabyte;  // of a figure's file
constexpr double kDiagnosis = 300;                             // s that the diagnosis may take

struct ReproduceOptions {
  std::vector<std::string> figures;
  bool list = false, fast = false, force = false;
  std::string fly;  ///< a job of this verb: the name of its flight
  jobs::ExecutorOptions executor;
  double budget_s = 0;
};

Result<std::vector<const Figure*>> chosen(const ReproduceOptions& o) {
  std::vector<const Figure*> out;
  if (o.figures.empty()) {
    for (const Figure& f : reproduction::figures())
      if (!o.fast || f.fast) out.push_back(&f);
    return out;
  }
  std::set<const Figure*> wanted;
  for (const std::string& id : o.figures) {
    const Figure* found = reproduction::find_figure(id);
    if (!found) {
      std::vector<std::string> ids;
      for (const Figure& f : reproduction::figures()) ids.emplace_back(f.id);
      const std::string near = files::nearest_word(id, ids);
      return bad_input("there is no figure " + files::shown(id), "FIGURE",
                       near.empty() ? "reproduce --list names them all" : "Did you mean '" + near + "'?");
    }
    wanted.insert(found);
  }
  for (const Figure& f : reproduction::figures())
    if (wanted.count(&f) > 0) out.push_back(&f);
  return out;
}

void list(const Common& common) {
  auto all = nlohmann::json::array();
  for (const Figure& f : reproduction::figures()) {
    all.push_back({{"id", f.id},
                   {"title", f.title},
                   {"fast", f.fast},
                   {"subject_assigned", f.assigned},
                   {"flights", f.flights}});
    say(common, fmt::format("  {:10} {}{}", f.id, f.title,
                            f.fast ? "" : fmt::format(" ({} flights)", f.flights.size())));
  }
  print_json(common, all);
}

/// One run over a folder.
class Run {
 public:
  Run(const ReproduceOptions& o, const Common& common, std::string out, std::vector<const Figure*> figures)
      : o_(o), common_(common), out_(std::move(out)), time_(o.budget_s) {
    for (const Figure* f : figures) all_.push_back({.figure = f, .finding = {}, .why_not = {}});
    jobs_ = o.executor.at_once();
  }

  Result<int> go() {
    for (const auto& [place, name] :
         {std::pair{&in_.omnimorph, "omnimorph"}, {&in_.omnicopter, "omnicopter"}}) {
      auto v = vehicle::load_vehicle(name);
      if (!v) return Failure(v.error());
      *place = std::move(*v);
    }
    if (auto ok = make_folder(out_ + "/figures"); !ok) return Failure(ok.error());
    for (Computed& one : all_) {
      const auto key = key_of(*one.figure);
      if (!key) return Failure(key.error());
      keys_.push_back(*key);
      if (!o_.force) keep(one, *key);
    }
    compute(true);  // first what takes no flight: an interrupted run has it
    if (auto ok = fly_and_diagnose(); !ok) return Failure(ok.error());
    compute(false);
    return conclude();
  }

 private:
  std::string file_of(const Figure& f) const { return out_ + "/figures/" + plain_name(f.id) + ".json"; }

  /// Of everything that decides what comes out.
  Result<std::string> key_of(const Figure& f) const {
    std::string all = std::string(kVersion) + f.id + in_.omnimorph.sha256 + in_.omnicopter.sha256;
    for (const std::string& name : f.flights) {
      const auto* flight = reproduction::find_flight(name);
      if (!flight) return fail(ErrorCode::internal, "needs a flight that there is not: " + name, f.id);
      const auto options = options_of(*flight, out_ + "/flights");
      if (!options) return Failure(options.error());
      const auto print = fingerprint(*options);
      all += print ? *print : print.error().text();  // a plant that is not installed
    }
    return files::sha256_hex(all);
  }

  void keep(Computed& one, const std::string& key) {
    const auto text = files::read_file(file_of(*one.figure), kLargestFigure);
    if (!text) return;
    const auto j = nlohmann::json::parse(*text, nullptr, false);
    if (!j.is_object() || !j.contains("finding") || j.value("schema", nlohmann::json()) != kFigureSchema ||
        j.value("key", nlohmann::json()) != key)
      return;
    auto finding = reproduction::finding_from_json(j["finding"]);
    if (!finding) return;
    one.finding = std::move(*finding);
    one.kept = true;
    if (j.contains("seconds") && j["seconds"].is_number()) one.seconds = j["seconds"].get<double>();
  }

  Status fly_and_diagnose() {
    std::vector<std::string> names;
    std::set<std::string> seen;
    bool diagnosis = false;
    for (const Computed& one : all_) {
      if (one.finding) continue;
      diagnosis = diagnosis || one.figure->diagnosis;
      for (const std::string& name : one.figure->flights)
        if (seen.insert(name).second) names.push_back(name);
    }
    if (names.empty()) return {};
    Progress progress("flights", static_cast<double>(names.size()), "flights", common_.quiet);
    const auto executor = jobs::make_executor(o_.executor);
    if (!executor) return Failure(executor.error());
    auto flown = fly_all(names, out_ + "/flights", **executor, time_, common_,
                         [&](std::size_t done) { progress.update(static_cast<double>(done)); });
    progress.finish();
    if (!flown) return Failure(flown.error());
    in_.flights = std::move(flown->recordings);
    missing_ = std::move(flown->missing);
    remarks_ = std::move(flown->remarks);
    if (!diagnosis || time_.over()) return {};
    std::vector<std::string> through_boards;
    for (const auto& [name, recording] : in_.flights)
      if (reproduction::find_flight(name)->plant == "emulator") through_boards.push_back(name);
    if (through_boards.empty()) return {};
    say(common_, "diagnosing the flights through the boards ...");
    auto text =
        diagnose_flights(through_boards, out_ + "/flights", std::min(kDiagnosis, time_.left_s() - 60));
    if (text)
      in_.diagnosis = std::move(*text);
    else
      remarks_.push_back("Not diagnosed: " + text.error().text());
    return {};
  }

  void compute(bool fast) {
    std::atomic<std::size_t> next{0}, done{0};
    std::mutex mutex;
    Progress progress(fast ? "figures without flights" : "figures", static_cast<double>(all_.size()),
                      "figures", common_.quiet);
    const auto work = [&] {
      for (std::size_t k = next++; k < all_.size(); k = next++) {
        if (!all_[k].finding && all_[k].figure->fast == fast) compute_one(all_[k], keys_[k]);
        const std::lock_guard lock(mutex);
        progress.update(static_cast<double>(++done));
      }
    };
    std::vector<std::thread> threads;
    for (int i = 0; i < jobs_; ++i) threads.emplace_back(work);
    for (auto& t : threads) t.join();
    progress.finish();
  }

  void compute_one(Computed& one, const std::string& key) {
    if (time_.over()) {
      one.why_not = interrupted() ? "interrupted; the same command goes on"
                                  : "the time was over; the same command goes on";
      return;
    }
    const auto begin = std::chrono::steady_clock::now();
    auto finding = one.figure->compute(in_);
    one.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (!finding) {
      one.why_not = finding.error().text();
      return;
    }
    one.finding = std::move(*finding);
    for (const std::string& name : one.figure->flights)
      if (missing_.count(name) > 0) return;  // with the flight it would be another finding
    const nlohmann::json j{{"schema", kFigureSchema},
                           {"key", key},
                           {"id", one.figure->id},
                           {"seconds", one.seconds},
                           {"finding", to_json(*one.finding)}};
    (void)files::write_file_atomic(file_of(*one.figure), j.dump() + "\n");  // without it: computed again
  }

  Result<int> conclude() {
    const nlohmann::json j = to_json(all_, kVersion);
    if (auto ok = files::write_file_atomic(out_ + "/reproduce.json", j.dump(2) + "\n"); !ok)
      return Failure(ok.error());
    std::vector<std::string> remarks;
    for (const auto& [name, why] : missing_) remarks.push_back("Not flown: " + name + ": " + why);
    for (const std::string& r : remarks_) remarks.push_back(r);
    if (auto ok = write_page(all_, kVersion, remarks, out_ + "/report.html"); !ok) return Failure(ok.error());
    print_json(common_, j);
    std::size_t left = 0, kept = 0;
    for (const Computed& one : all_) {
      left += !one.finding;
      kept += one.kept;
      say(common_, fmt::format("  {:10} {:18} {}", one.figure->id,
                               one.finding ? word(one.finding->verdict()) : "not computed",
                               one.finding ? one.figure->title : one.why_not));
    }
    for (const std::string& r : remarks) say(common_, "  " + r);
    say(common_,
        fmt::format("{} ({} kept from before); report: {}/report.html", conclusion(all_), kept, out_));
    return left == 0 ? 0 : static_cast<int>(ErrorCode::incomplete);
  }

  const ReproduceOptions& o_;
  const Common& common_;
  std::string out_;
  WorkTime time_;
  int jobs_ = 1;
  Inputs in_;
  std::vector<Computed> all_;
  std::vector<std::string> keys_;
  std::map<std::string, std::string> missing_;
  std::vector<std::string> remarks_;
};

}  // namespace

Action add_reproduce(CLI::App& verb, Common& common) {
  auto o = std::make_shared<ReproduceOptions>();
  verb.add_option("figures", o->figures,
                  "Figures and tables, for instance 5.3 A.8 'table 7.1'; default: all");
  verb.add_flag("--list", o->list, "Only name them");
  verb.add_flag("--fast", o->fast, "Only those that need no flight")->excludes("figures");
  verb.add_flag("--force", o->force, "Compute again what is there; flights of the same inputs are kept");
  verb.add_option("--jobs", o->executor.jobs, "At once on this machine; default: processors")
      ->check(CLI::Range(1, 64));
  jobs::add_executor(verb, o->executor);
  verb.add_option("--fly", o->fly)->group("");
  verb.add_option("--budget-s", o->budget_s, "Time after which nothing more is begun [s]")
      ->check(not_negative(false));
  return [o, &common]() -> Result<int> {
    if (o->list) {
      list(common);
      return 0;
    }
    if (!o->fly.empty()) return fly_reproduction(o->fly, common.out);
    auto figures = chosen(*o);
    if (!figures) return Failure(figures.error());
    const std::string out = common.out.empty() ? "runs/reproduction" : common.out;
    const auto folder = FolderLock::take(out);
    if (!folder) return Failure(folder.error());
    return Run(*o, common, out, std::move(*figures)).go();
  };
}

}  // namespace omniflight::cli
