#include <fmt/format.h>

#include <chrono>

#include "diagnosis_page.hpp"
#include "flight.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

struct Options {
  std::vector<std::string> recordings, held_out, set;
  std::string vehicle, refly, plan;
  double budget_s = 0;
};

Result<std::vector<recording::Recording>> load_all(const std::vector<std::string>& paths) {
  std::vector<recording::Recording> out;
  for (const std::string& path : paths) {
    auto r = recording::load(path, {});
    if (!r) return Failure(r.error());
    out.push_back(std::move(*r));
  }
  return out;
}

/// Flies the mission again without and with the model, with the recording's seed, and compares all three.
Result<Refit> refly(const Options& o, const std::string& out, const recording::Recording& real, bool quiet,
                    diagnosis::Diagnosis& d) {
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
  f.quiet = quiet;
  f.out = out + "/nominal";
  auto before = fly(f);
  if (!before) return Failure(before.error());
  f.effects = out + "/model.yaml";
  f.out = out + "/with_model";
  auto after = fly(f);
  if (!after) return Failure(after.error());
  Refit refit{true, compare(before->metrics, *recorded), compare(after->metrics, *recorded)};
  const char* const names[] = {"px", "py", "pz", "roll", "pitch", "yaw"};
  for (std::size_t k = 0; k < 6; ++k)
    d.fit.closed_loop.push_back({names[k], refit.before[k].unit, refit.before[k].real,
                                 refit.before[k].simulated, refit.after[k].simulated});
  d.fit.power = {recorded->mean_power, before->metrics.mean_power, after->metrics.mean_power};
  return refit;
}

}  // namespace

Action add_diagnose(CLI::App& verb, Common& common) {
  auto o = std::make_shared<Options>();
  verb.add_option("recordings", o->recordings, "Recordings to fit")->required();
  verb.add_option("--vehicle", o->vehicle, "Name or path of the nominal vehicle")->required();
  verb.add_option("--held-out", o->held_out, "Recordings that are only predicted");
  verb.add_option("--set", o->set, "Override a vehicle field, for instance mass=0.0397 (kg)");
  verb.add_option("--refly", o->refly,
                  "Mission to fly again in the simulator, without and with the model found");
  verb.add_option("--plan", o->plan, "Plan folder for --refly");
  verb.add_option("--budget-s", o->budget_s, "Time to stay within [s]")->check(not_negative(false));
  return [o, &common]() -> Result<int> {
    const auto begin = std::chrono::steady_clock::now();
    auto vehicle = vehicle::load_vehicle(o->vehicle, o->set);
    if (!vehicle) return Failure(vehicle.error());
    auto fit = load_all(o->recordings);
    if (!fit) return Failure(fit.error());
    auto held_out = load_all(o->held_out);
    if (!held_out) return Failure(held_out.error());
    auto d = diagnosis::diagnose(*fit, *held_out, *vehicle, {});
    if (!d) return Failure(d.error());
    d->runtime_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const std::string out = common.out.empty() ? "runs/diagnosis" : common.out;
    if (auto ok = make_folder(out); !ok) return Failure(ok.error());
    if (auto ok = files::write_file_atomic(out + "/model.yaml", diagnosis::model_yaml(*d)); !ok)
      return Failure(ok.error());
    Refit refit;
    if (!o->refly.empty()) {
      auto flown = refly(*o, out, fit->front(), common.quiet, *d);
      if (!flown) return Failure(flown.error());
      refit = std::move(*flown);
    }
    const std::string json = diagnosis::to_json(*d);
    if (auto ok = files::write_file_atomic(out + "/diagnosis.json", json); !ok) return Failure(ok.error());
    if (auto ok = write_page(*d, refit, "Diagnosis of " + vehicle->name, out + "/report.html"); !ok)
      return Failure(ok.error());
    if (common.json) print_json(common, nlohmann::json::parse(json));
    say(common, "verdict: " + to_string(d->verdict) + "\n" + d->summary);
    for (const auto& m : d->mismatch)
      say(common,
          fmt::format("  differs: {} {} ({} frame): {:.4g} {} RMS, noise {:.4g}; {}",
                      physics::to_string(m.stage), m.channel, m.frame, m.rms, m.unit, m.noise_rms, m.where));
    for (const auto& f : d->findings) {
      say(common, fmt::format("  {} (probability {:.2f})", f.effect, f.probability));
      for (const auto& p : f.parameters)
        say(common,
            fmt::format("    {:16} {:.5g} [{:.5g}, {:.5g}] {}", p.name, p.value, p.low, p.high, p.unit));
      std::string aliases;
      for (const auto& a : f.cannot_be_told_apart_from) aliases += " " + a;
      if (!aliases.empty()) say(common, "    cannot be told apart on this flight from:" + aliases);
    }
    for (const auto& c : d->fit.held_out)
      say(common, fmt::format("  held out: {} {}: {:.4g} -> {:.4g} {}", c.recording, c.channel, c.rms_before,
                              c.rms_after, c.unit));
    if (refit.flown) {
      say(common, "nominal simulation against the recording:\n" + to_text(refit.before));
      say(common, "simulation with the model found against the recording:\n" + to_text(refit.after));
    }
    say(common, fmt::format("diagnosed in {:.1f} s; report: {}/report.html", d->runtime_s, out));
    return d->verdict == diagnosis::Verdict::unexplained || d->verdict == diagnosis::Verdict::unusable
               ? static_cast<int>(ErrorCode::incomplete)
               : 0;
  };
}

}  // namespace omniflight::cli
