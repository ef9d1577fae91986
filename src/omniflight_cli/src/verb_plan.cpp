#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>

#include "folder.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/plan.hpp"
#include "omniflight_planning/planner.hpp"
#include "plan_page.hpp"
#include "verbs.hpp"

namespace omniflight::cli {

namespace {

/// The state of a plan in flight, from FOLDER@TIME.
Result<planning::FlightState> state_in_plan(const std::string& from) {
  const std::size_t at = from.rfind('@');
  double time = 0.0;
  const char *begin = from.data() + std::min(at, from.size() - 1) + 1, *end = from.data() + from.size();
  const auto [rest, error] = std::from_chars(begin, end, time);
  if (at == std::string::npos || at == 0 || error != std::errc{} || rest != end || !std::isfinite(time))
    return bad_input(files::shown(from) + " is no FOLDER@TIME", "--from",
                     "Write for instance plan-tour@3.2 (s)");
  const auto plan = planning::read_plan(from.substr(0, at));
  if (!plan) return Failure(plan.error());
  auto state = planning::state_at(plan->trajectory, time);
  if (state) return state;
  Error wrong = state.error();
  wrong.where = "--from";
  return Failure(wrong);
}

}  // namespace

Action add_plan(CLI::App& verb, Common& common) {
  struct PlanOptions {
    std::vector<std::string> words;
    std::optional<std::uint64_t> seed;
    std::optional<double> budget_ms;
    std::string vehicle, tube, planner, from;
    int threads = 1;
    bool force = false;
    std::vector<std::string> set;
  };
  auto o = std::make_shared<PlanOptions>();
  verb.add_option(
          "mission", o->words,
          "MISSION | verify FOLDER | explain MISSION; a mission's test_bed names a map: .bt, .ot or a mesh")
      ->required()
      ->expected(1, 2);
  verb.add_option("--seed", o->seed, "Instead of the mission's seed");
  verb.add_option("--budget-ms", o->budget_ms, "Time for the whole plan [ms], instead of the mission's")
      ->check(not_negative(false));
  verb.add_flag("--force", o->force, "Overwrite a plan that is in --out");
  verb.add_option("--planner", o->planner, "Look for paths with one of OMPL's planners alone")
      ->check(CLI::IsMember(planning::planner_names()));
  verb.add_option("--tube", o->tube,
                  "flight.json or compare.json: its largest tracking errors are kept beyond the clearance");
  verb.add_option("--threads", o->threads,
                  "Searches side by side; a seed and a number of threads give the same plan")
      ->check(CLI::Range(1, planning::kMostPlannerThreads));
  verb.add_option(
      "--from", o->from,
      "FOLDER@TIME: begin in flight, with the state of that plan at that time [s], come to rest and go on "
      "to the mission's waypoints; that plan is left as it is");
  verb.add_option("--vehicle", o->vehicle, "Instead of the mission's vehicle");
  verb.add_option("--set", o->set, "Override a vehicle field, for instance mass=1.4 (kg)");
  return [o, &common]() -> Result<int> {
    const std::string& first = o->words.front();
    if (first == "verify") {
      if (o->words.size() != 2) return bad_input("needs a plan folder", "plan verify");
      auto report = planning::verify(o->words[1]);
      if (!report) return Failure(report.error());
      print_json(common, {{"verdict", "verified"},
                          {"min_clearance_m", report->min_clearance},
                          {"at_s", report->min_clearance_at},
                          {"poses", report->poses},
                          {"duration_s", report->duration}});
      say(common, fmt::format("verified: {} poses, least clearance {:.3f} m at {:.2f} s", report->poses,
                              report->min_clearance, report->min_clearance_at));
      return 0;
    }
    const bool explain = first == "explain";
    if (!explain && o->words.size() > 1) {
      const std::string near = files::nearest_word(first, std::vector<std::string>{"verify", "explain"});
      return bad_input(
          "plans one mission, and " + files::shown(o->words[1]) + " is another word", "plan",
          near.empty() ? "Plan them one after another" : "Did you mean 'plan " + near + " ...'?");
    }
    if (explain && o->words.size() != 2) return bad_input("needs a mission", "plan explain");
    auto mission = planning::load_mission(explain ? o->words[1] : first);
    if (!mission) return Failure(mission.error());
    if (!explain && !common.out.empty())
      if (auto ok = refuse_overwriting(std::filesystem::path(common.out) / "certificate.json", o->force); !ok)
        return Failure(ok.error());
    planning::PlanOptions options;
    options.stop = interrupted;
    options.vehicle = o->vehicle;
    options.tube_file = o->tube;
    options.planner = o->planner;
    options.set = o->set;
    options.figures = !explain;
    options.seed = o->seed;
    options.threads = o->threads;
    if (!o->from.empty()) {
      auto state = state_in_plan(o->from);
      if (!state) return Failure(state.error());
      options.from = *state;
    }
    if (o->budget_ms && !(*o->budget_ms >= 0.0 && *o->budget_ms <= 600e3))
      return bad_input("is no time between 0 and 600,000 ms", "--budget-ms", "Give milliseconds");
    if (o->budget_ms) options.budget_s = 1e-3 * *o->budget_ms;
    auto plan = planning::plan_mission(*mission, options);
    if (explain) {
      say(common, planning::explain(plan));
      print_json(common, {{"explanation", planning::explain(plan)}});
      return plan ? 0 : static_cast<int>(plan.error().code);
    }
    if (!plan) return Failure(plan.error());
    const std::string out =
        common.out.empty() ? fresh_folder("plan-" + plain_name(mission->name)) : common.out;
    const auto lock = FolderLock::take(out);
    if (!lock) return Failure(lock.error());
    if (auto ok = planning::write_plan(*plan, out); !ok) return Failure(ok.error());
    const auto vehicle = vehicle::load_vehicle(o->vehicle.empty() ? mission->vehicle : o->vehicle, o->set);
    if (!vehicle) return Failure(vehicle.error());
    if (auto ok = write_plan_page(*plan, *mission, *vehicle, out + "/report.html"); !ok)
      return Failure(ok.error());
    say(common, planning::explain(plan));
    say(common, "plan: " + out);
    print_json(common, {{"verdict", plan->certificate.verdict},
                        {"duration_s", plan->certificate.duration},
                        {"min_clearance_m", plan->certificate.min_clearance},
                        {"seed", plan->certificate.seed},
                        {"out", out}});
    return 0;
  };
}

}  // namespace omniflight::cli
