#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <thread>

#include "ablation.hpp"
#include "bounded_diagnosis.hpp"
#include "diagnosis_page.hpp"
#include "flight.hpp"
#include "folder.hpp"
#include "intake_lines.hpp"
#include "load_all.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_diagnosis/neighbour_file.hpp"
#include "omniflight_diagnosis/prior_knowledge.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/plan.hpp"
#include "omniflight_recording/formats.hpp"
#include "pilot_words.hpp"
#include "questions.hpp"
#include "refly_recorded.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

struct DiagnoseOptions {
  std::vector<std::string> recordings, held_out, set, baseline;
  Questions questions;
  std::string vehicle, refly, plan, told, map, axes = "enu", ablation, test_bed = "pyramid";
  std::string out;  ///< folder of the answer
  double budget_s = 0;
  int jobs = 0;
  bool check = false, refly_recorded = false;
};

constexpr const char* kStopped = "stopped";

/// What was wanted after the search, and Ctrl-C ended.
Failure stopped() { return fail(ErrorCode::incomplete, kStopped, "diagnose", "What was found is kept"); }

/// Flies the mission again without and with the model, with the recording's seed, and compares all three.
/// What hangs on more than the model (a neighbour's wash) cannot be flown again: this is said, and nothing
/// compared.
Result<Refit> refly(const DiagnoseOptions& o, const recording::Recording& real, const Common& common,
                    diagnosis::Diagnosis& d) {
  if (interrupted()) return stopped();
  auto vehicle = vehicle::load_vehicle(o.vehicle, o.set);
  if (!vehicle) return Failure(vehicle.error());
  auto recorded = assess(real, *vehicle);
  if (!recorded) return Failure(recorded.error());
  FlightOptions f;
  f.mission = o.refly;
  f.plan = o.plan;
  f.vehicle = o.vehicle;
  f.set = o.set;
  f.sensors = "laboratory";
  f.in_process = true;
  if (const auto seed = real.metadata.find("omniflight.seed"); seed != real.metadata.end())
    f.seed = std::strtoull(seed->second.c_str(), nullptr, 10);
  f.quiet = common.quiet;
  f.force = true;  // in the folder of this diagnosis
  f.out = o.out + "/nominal";
  auto before = fly(f);
  if (interrupted()) return stopped();
  if (!before) return Failure(before.error());
  f.effects = o.out + "/model.yaml";
  f.out = o.out + "/with_model";
  auto after = fly(f);
  if (interrupted()) return stopped();
  if (!after) {  // a model that the simulator refuses alone is still a diagnosis
    say(common, "  not flown again with the model: " + after.error().text());
    return Refit{};
  }
  Refit refit{true, compare(before->metrics, *recorded), compare(after->metrics, *recorded)};
  const char* const names[] = {"px", "py", "pz", "roll", "pitch", "yaw"};
  const auto integral = [](const FlightMetrics& m, std::size_t axis) {
    return m.has_integral ? m.rms_integral[static_cast<Eigen::Index>(axis)] : std::nan("");
  };
  for (std::size_t k = 0; k < 6; ++k)
    d.fit.closed_loop.push_back(
        {names[k],
         refit.before[k].unit,
         refit.before[k].real,
         refit.before[k].simulated,
         refit.after[k].simulated,
         {integral(*recorded, k), integral(before->metrics, k), integral(after->metrics, k)}});
  d.fit.power = {recorded->mean_power, before->metrics.mean_power, after->metrics.mean_power};
  return refit;
}

/// What told.yaml says, and the tracks of the neighbours it names.
Status take_told(const DiagnoseOptions& o, const recording::Recording& first, diagnosis::Options& options,
                 Common& common) {
  const std::string file = o.told.empty() ? diagnosis::prior_knowledge_beside(o.recordings.front()) : o.told;
  if (file.empty()) return {};
  const auto told = diagnosis::load_prior_knowledge(file);
  if (!told) return Failure(told.error());
  diagnosis::apply(*told, options);
  for (const std::string& place : told->ignored)
    say(common, "  told, but not used: " + place + " (" + file + ")");
  for (const std::string& path : told->neighbours) {
    auto track = diagnosis::load_neighbour(path, o.map, first.start_s);
    if (!track) return Failure(track.error());
    options.neighbours.push_back(std::move(*track));
  }
  return {};
}

/// Several recordings: each flew beside neighbours of its own, named in the told.yaml that is its own
/// (<recording>.told.yaml, or told.yaml in a folder of its own). The first one's are already loaded.
Status take_neighbours(const DiagnoseOptions& o, std::vector<recording::Recording>& fit,
                       std::vector<recording::Recording>& held_out, diagnosis::Options& options) {
  if (fit.size() + held_out.size() < 2) return {};
  const auto give = [](recording::Recording& to, const physics::NeighbourTrack& track) {
    recording::Signal s;
    int number = 1;
    do s.name = fmt::format("neighbour{}_position", number++);
    while (to.signals.count(s.name) > 0);
    s.unit = "m";
    s.t_s = track.t_s;
    s.values.resize(static_cast<Eigen::Index>(track.p_WN.size()), 3);
    for (std::size_t i = 0; i < track.p_WN.size(); ++i)
      s.values.row(static_cast<Eigen::Index>(i)) = track.p_WN[i].transpose();
    to.signals[s.name] = std::move(s);
  };
  for (const physics::NeighbourTrack& track : options.neighbours) give(fit.front(), track);
  options.neighbours.clear();
  const auto folder = [](const std::string& path) { return std::filesystem::path(path).parent_path(); };
  for (auto* list : {&fit, &held_out})
    for (std::size_t k = list == &fit ? 1 : 0; k < list->size(); ++k) {
      const std::string& path = (list == &fit ? o.recordings : o.held_out)[k];
      const std::string file = diagnosis::prior_knowledge_beside(path);
      if (file.empty() || (file != path + ".told.yaml" && folder(path) == folder(o.recordings.front())))
        continue;
      const auto told = diagnosis::load_prior_knowledge(file);
      if (!told) return Failure(told.error());
      for (const std::string& neighbour : told->neighbours) {
        auto track = diagnosis::load_neighbour(neighbour, o.map, (*list)[k].start_s);
        if (!track) return Failure(track.error());
        give((*list)[k], *track);
      }
    }
  return {};
}

std::string mission_yaml(const diagnosis::ProposedFlight& f, const std::string& vehicle,
                         const std::string& bed, const Vec3& start) {
  std::string y = fmt::format(
      "# Proposed by a diagnosis: {}.\n# Predicted separation of the explanations: {:.1f} sigma.\n"
      "schema: omniflight.mission/1\nname: {}\nvehicle: {}\ntest_bed: {}\nalpha_deg: {:.1f}\nclearance_m: "
      "0.08\n"
      "seed: 1\nbudget_ms: 5000\nlimits: {{speed_mps: {:.3g}, acceleration_mps2: {:.3g}, rate_dps: {:.3g}, "
      "angular_acceleration_dps2: {:.3g}, rotor_headroom: 0.1}}\n"
      "start: {{position: [{:.3f}, {:.3f}, {:.3f}], attitude: {{rpy_deg: [0, 0, 0]}}, hold_s: "
      "3}}\nwaypoints:\n",
      f.words, f.separation_sigma, f.name, vehicle, bed, to_degrees(f.alpha), f.speed, f.acceleration,
      to_degrees(f.rate), to_degrees(f.angular_acceleration), start.x(), start.y(), start.z());
  for (const auto& w : f.waypoints) {
    if (w.by.norm() == 0 && w.rpy_deg.norm() == 0 && !w.alpha && &w == &f.waypoints.front()) continue;
    y += fmt::format(
        "  - {{by: [{:.3f}, {:.3f}, {:.3f}], attitude: {{rpy_deg: [{:.1f}, {:.1f}, {:.1f}]}}, {}hold_s: "
        "{:.1f}}}\n",
        w.by.x(), w.by.y(), w.by.z(), w.rpy_deg.x(), w.rpy_deg.y(), w.rpy_deg.z(),
        w.alpha ? fmt::format("alpha_deg: {:.1f}, ", to_degrees(*w.alpha)) : "", w.hold_s);
  }
  return y;
}

/// Writes the best proposed flight that the planner certifies in the test bed; says why when there is none.
Status write_next_flight(const DiagnoseOptions& o, diagnosis::Diagnosis& d, Common& common) {
  std::string why;
  for (const auto& f : d.next_flight.proposed) {
    if (interrupted()) break;
    // where it was flown, or over the middle of the test bed when that place is not free there
    for (const Vec3& start : {f.start, Vec3(0, 0, 0.9), Vec3(0, 0, 1.0), Vec3(0, 0, 1.15), Vec3(0, 0, 1.3)}) {
      const std::string path = o.out + "/next_flight.yaml";
      if (auto ok = files::write_file_atomic(path, mission_yaml(f, o.vehicle, o.test_bed, start)); !ok)
        return ok;
      const auto mission = planning::load_mission(path);
      if (!mission) {  // no such test bed, say: what was found stays found
        why = mission.error().text();
        break;
      }
      planning::PlanOptions until;
      until.stop = interrupted;
      const auto plan = planning::plan_mission(*mission, until);
      if (interrupted()) break;
      if (plan) {
        d.next_flight.mission = "next_flight.yaml";
        d.next_flight.predicted_separation_sigma = f.separation_sigma;
        d.next_flight.separations_sigma = f.separations_sigma;
        d.next_flight.manoeuvres.insert(d.next_flight.manoeuvres.begin(), f.words);
        return {};
      }
      why = plan.error().text();
    }
  }
  std::error_code ec;
  std::filesystem::remove(o.out + "/next_flight.yaml", ec);
  if (interrupted() && !d.next_flight.proposed.empty()) {
    say(common, "  no flight is proposed: stopped");
    d.left_out.push_back(std::string("a proposed flight that fits the test bed (") + kStopped + ")");
  } else if (!why.empty()) {
    say(common, "  no proposed flight fits the test bed: " + why);
    d.left_out.push_back("a proposed flight that fits the test bed (" + why + ")");
  }
  return {};
}

/// The answer on the console.
void tell(const DiagnoseOptions& o, const Common& common, const vehicle::Vehicle& vehicle,
          const std::vector<recording::Recording>& recordings, const diagnosis::Diagnosis& d,
          const Refit& refit) {
  say(common, "verdict: " + to_string(d.verdict) + "\n" + d.summary);
  for (const auto& m : d.mismatch)
    say(common,
        fmt::format("  differs: {} {} ({} frame): {}{}", physics::to_string(m.stage), m.channel, m.frame,
                    m.rms > 0 ? fmt::format("{:.4g} {} RMS, noise {:.4g}; ", m.rms, m.unit, m.noise_rms) : "",
                    m.where));
  for (const auto& f : d.findings) {
    say(common,
        "  " + f.effect +
            (std::isfinite(f.probability) ? fmt::format(" (probability {:.2f})", f.probability) : ""));
    for (const auto& p : f.parameters)
      say(common, identifiable(f.effect, p) ? fmt::format("    {:16} {:.5g} [{:.5g}, {:.5g}] {}", p.name,
                                                          p.value, p.low, p.high, p.unit)
                                            : fmt::format("    {:16} not identifiable", p.name));
    std::string aliases;
    for (const auto& a : f.cannot_be_told_apart_from) aliases += " " + a;
    if (!aliases.empty()) say(common, "    cannot be told apart on this flight from:" + aliases);
  }
  for (const auto& c : d.fit.held_out)
    say(common, fmt::format("  held out: {} {}: {:.4g} -> {:.4g} {}, R2 {:.3f} -> {:.3f}", c.recording,
                            c.channel, c.rms_before, c.rms_after, c.unit, c.r2_before, c.r2_after));
  for (const auto& c : d.fit.closed_loop)
    if (std::isfinite(c.integral.real))
      say(common,
          fmt::format("  integral action {:5}: {:.4g} recorded, {:.4g} -> {:.4g} simulated, RMS", c.channel,
                      c.integral.real, c.integral.simulated_before, c.integral.simulated_after));
  if (refit.flown) {
    say(common, "nominal simulation against the recording:\n" + to_text(refit.before));
    say(common, "simulation with the model found against the recording:\n" + to_text(refit.after));
  }
  if (!o.questions.why.empty()) {
    say(common, "  why " + o.questions.why + ":");
    for (const std::string& line : why(o.questions.why, d)) say(common, "    " + line);
  }
  if (o.check) {
    say_intake(common, d.intake, vehicle, recordings);
    for (const auto& in : d.further) say_intake(common, in, vehicle, recordings);
    for (const auto& in : d.inputs)
      for (const auto& w : in.excluded)
        say(common, fmt::format("  cut: {:.2f} s to {:.2f} s, {}", w.from_s, w.to_s, w.why));
  }
  if (!d.next_flight.mission.empty())
    say(common, fmt::format("  next flight: {}/{}, predicted separation {:.1f} sigma", o.out,
                            d.next_flight.mission, d.next_flight.predicted_separation_sigma));
  if (const std::string left = diagnosis::stay_together(d.next_flight); !left.empty())
    say(common, "  it would hardly tell apart: " + left);
  say(common, fmt::format("diagnosed in {:.1f} s; report: {}/report.html", d.runtime_s, o.out));
}

/// Writes and tells the answer: the exit code.
Result<int> conclude(const DiagnoseOptions& o, Common& common, const vehicle::Vehicle& vehicle,
                     const std::vector<recording::Recording>& recordings, const diagnosis::Options& options,
                     std::chrono::steady_clock::time_point begin, diagnosis::Diagnosis& d) {
  const recording::Recording& flown = recordings.front();
  const bool answered =
      d.verdict != diagnosis::Verdict::checked && d.verdict != diagnosis::Verdict::unfinished;
  d.runtime_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (auto ok = files::write_file_atomic(o.out + "/model.yaml", diagnosis::model_yaml(d)); !ok)
    return Failure(ok.error());
  if (auto ok = write_next_flight(o, d, common); !ok) return Failure(ok.error());
  Refit refit;
  Status flown_again;
  if (!o.refly.empty() && answered) {
    auto again = refly(o, flown, common, d);
    if (again) {
      refit = std::move(*again);
    } else {  // what was found stays found
      flown_again = Failure(again.error());
      d.left_out.push_back("the flight again in the simulator: " + again.error().text());
    }
  }
  if (o.refly_recorded && answered) {
    const std::string file =
        o.told.empty() ? diagnosis::prior_knowledge_beside(o.recordings.front()) : o.told;
    const auto told = file.empty() ? Result<diagnosis::PriorKnowledge>(diagnosis::PriorKnowledge{})
                                   : diagnosis::load_prior_knowledge(file);
    if (!told) return Failure(told.error());
    if (auto ok = refly_recorded(flown, vehicle, *told, options, d); !ok) {
      say(common, "  not flown again: " + ok.error().text());
      d.left_out.push_back("the recorded flight again: " + ok.error().message);
    }
  }
  const bool cut_short = interrupted();  // what comes now takes less than was promised, and is written
  if (auto ok = write_page(d, refit, flown, "Diagnosis of " + vehicle.name, o.out + "/report.html"); !ok)
    return Failure(ok.error());
  d.summary = first_sentence(d) + ". " + d.summary;
  const std::string answer = diagnosis::to_json(d);
  if (auto ok = files::write_file_atomic(o.out + "/diagnosis.json", answer); !ok) return Failure(ok.error());
  if (common.json) print_json(common, nlohmann::json::parse(answer));
  tell(o, common, vehicle, recordings, d, refit);
  if (!flown_again) return Failure(flown_again.error());
  if (cut_short) return static_cast<int>(ErrorCode::incomplete);
  switch (d.verdict) {
    case diagnosis::Verdict::unexplained:
    case diagnosis::Verdict::unusable:
    case diagnosis::Verdict::unfinished:
      return static_cast<int>(ErrorCode::incomplete);
    default:
      return 0;
  }
}

/// The folder of the answer, for this run alone until it ends.
Result<FolderLock> take_folder(DiagnoseOptions& o, const Common& common) {
  o.out = common.out.empty() ? fresh_folder("diagnosis") : common.out;
  return FolderLock::take(o.out);
}

struct Read {
  std::vector<recording::Recording> fit, held_out, baseline;
};

Result<Read> read_all(const DiagnoseOptions& o) {
  Read out;
  for (const auto& [paths, into] :
       {std::pair{&o.recordings, &out.fit}, {&o.held_out, &out.held_out}, {&o.baseline, &out.baseline}}) {
    auto read = load_all(*paths, {o.map, o.axes});
    if (!read) return Failure(read.error());
    *into = std::move(*read);
  }
  return out;
}

/// Of recordings that were not read to their end: their names.
std::vector<recording::Recording> named(const std::vector<std::string>& paths) {
  std::vector<recording::Recording> out(paths.size());
  for (std::size_t k = 0; k < paths.size(); ++k) out[k].file = paths[k];
  return out;
}

/// For a process in which a thread still works on what its caller owns.
[[noreturn]] void leave(const Result<int>& code) {
  if (!code) std::fprintf(stderr, "omniflight diagnose: %s\n", code.error().text().c_str());
  std::cout.flush();
  std::fflush(nullptr);
  std::_Exit(code ? *code : static_cast<int>(code.error().code));
}

}  // namespace

Action add_diagnose(CLI::App& verb, Common& common) {
  auto o = std::make_shared<DiagnoseOptions>();
  verb.add_option("recordings", o->recordings, "Recordings to fit")->required();
  verb.add_option("--vehicle", o->vehicle, "Name or path of the nominal vehicle")->required();
  verb.add_option("--held-out", o->held_out, "Recordings that are only predicted");
  verb.add_option("--set", o->set, "Override a vehicle field, for instance mass=0.0397 (kg)");
  verb.add_option("--refly", o->refly,
                  "Mission to fly again in the simulator, without and with the model found");
  verb.add_option("--plan", o->plan, "Plan folder for --refly");
  verb.add_flag(
      "--refly-recorded", o->refly_recorded,
      "Fly the recorded reference again in the simulator with the told gains, without and with the model");
  verb.add_option("--budget-s", o->budget_s, "Time to stay within [s]")->check(not_negative(false));
  verb.add_option("--jobs", o->jobs,
                  "Threads of the search; the answer is the same (default: processors, up to 4)")
      ->check(CLI::Range(1, 64));
  verb.add_flag("--check", o->check,
                "Only say what these recordings can and cannot tell; takes seconds and fits nothing");
  verb.add_option("--told", o->told, "What is known beside the recording (default: told.yaml beside it)");
  add_map(verb, o->map);
  add_axes(verb, o->axes);
  verb.add_option("--ablation", o->ablation,
                  "Leave a safeguard out, or give something wrong, to see what an answer is worth:\n" +
                      ablations_help())
      ->check(CLI::IsMember(ablations()));
  verb.add_option("--only", o->questions.only,
                  "Effects of the wrench that are asked for, separated by commas")
      ->delimiter(',');
  verb.add_option("--exclude", o->questions.exclude,
                  "Effects of the wrench that are not, separated by commas")
      ->delimiter(',');
  verb.add_option("--why", o->questions.why, "Effect: say what was asked of it, and what came of that");
  verb.add_option(
      "--prior", o->questions.prior,
      "diagnosis.json of earlier flights of this vehicle: its probabilities instead of the library's "
      "rates");
  verb.add_option(
      "--baseline", o->baseline,
      "Three or more good flights of the same vehicle, where only the motors can be judged: say which "
      "rotor gives less than in them");
  verb.add_option("--test-bed", o->test_bed,
                  "Where the proposed next flight has to fit: a name, or a map (.bt, .ot or a mesh)");
  return [o, &common]() -> Result<int> {
    const auto begin = std::chrono::steady_clock::now();
    auto vehicle = vehicle::load_vehicle(o->vehicle, o->set);
    if (!vehicle) return Failure(vehicle.error());
    const auto elapsed = [begin] {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    const auto over = [&] { return interrupted() || (o->budget_s > 0 && elapsed() > 0.95 * o->budget_s); };
    diagnosis::Options options;
    if (auto ok = ask(o->questions, options); !ok) return Failure(ok.error());
    auto read = common.embedded ? std::optional(read_all(*o))
                                : unless_over<Result<Read>>([o] { return read_all(*o); }, over);
    if (!read) {
      const auto folder = take_folder(*o, common);
      if (!folder) leave(Failure(folder.error()));
      const auto recordings = named(o->recordings);
      auto unread = without_a_model(recordings);
      leave(conclude(*o, common, *vehicle, recordings, options, begin, unread));
    }
    if (!*read) return Failure(read->error());
    auto& [fit, held_out, baseline] = **read;
    ablate_input(o->ablation, fit, *vehicle);
    options.baseline = std::move(baseline);
    if (auto ok = take_told(*o, fit.front(), options, common); !ok) return Failure(ok.error());
    if (auto ok = take_neighbours(*o, fit, held_out, options); !ok) return Failure(ok.error());
    ablate_options(o->ablation, options);
    const auto folder = take_folder(*o, common);
    if (!folder) return Failure(folder.error());
    constexpr unsigned kDefaultMost = 4;  // each keeps a copy of the flight, and less and less is won
    options.threads =
        o->jobs > 0 ? o->jobs
                    : static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, kDefaultMost));
    Progress progress("diagnosing", o->budget_s, "s", common.quiet || common.json);
    options.stop = [&] {
      progress.update(elapsed());
      // the answer itself is written within what is left
      return interrupted() || (o->budget_s > 0 && elapsed() > 0.8 * o->budget_s);
    };
    const auto work = [&, fit = &fit, held_out = &held_out] {
      return o->check ? diagnosis::check(*fit, *vehicle, options)
                      : diagnosis::diagnose(*fit, *held_out, *vehicle, options);
    };
    Bounded bounded = common.embedded ? Bounded{work(), true} : within_time(work, fit, over);
    if (bounded.ended && bounded.answer) progress.finish();
    const auto code = bounded.answer ? conclude(*o, common, *vehicle, fit, options, begin, *bounded.answer)
                                     : Result<int>(Failure(bounded.answer.error()));
    if (!bounded.ended) leave(code);
    return code;
  };
}

}  // namespace omniflight::cli
