// What recordings could tell, before anything is fitted.
#include "conditioning/analysis_scope.hpp"
#include "conditioning/input_validation.hpp"
#include "conditioning/repair.hpp"
#include "experiment_design/detectability.hpp"
#include "numerics/text.hpp"
#include "report/intake.hpp"
#include "report/other_stages.hpp"
#include "search/offered_effects.hpp"
#include "sensor_checks/findings.hpp"
#include "sensor_checks/merge_recordings.hpp"
#include "sensors_alone.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;

Diagnosis check_motors(const Recording& r, const vehicle::Vehicle& vehicle, const Options& o) {
  Diagnosis d = judge_sensors_of(r, vehicle, o);
  d.verdict = Verdict::checked;
  d.summary =
      "No attitude or no force: only the balance of the motors in steady flight can be judged, that is a "
      "weak or damaged rotor and an offset centre of mass.";
  for (const Finding& x : d.findings) d.summary += " " + x.sentence;
  return d;
}

Result<Diagnosis> check_one(const Recording& recorded, const vehicle::Vehicle& vehicle, const Options& o) {
  const AnalysisScope scope = scope_of(recorded);
  const Repaired known = in_order(recorded, o);
  const Recording& r = known.recording;
  auto against = validate_input(r, vehicle, o);
  if (!against) return tl::unexpected(against.error());
  if (!against->empty()) return unusable(r, *against);
  if (scope == AnalysisScope::sensors)
    return diagnose_sensors(std::span(&r, 1), vehicle, o, missing_reason(r));
  if (scope == AnalysisScope::motors) return check_motors(r, vehicle, o);
  Diagnosis d;
  auto flight = prepare_repaired(known, vehicle, o);
  if (!flight) return tl::unexpected(flight.error());
  const Flight& f = *flight;
  d.verdict = Verdict::checked;
  d.inputs.push_back({f.file, f.sha256, f.duration_s, f.signals, f.excluded});
  const std::vector<const Flight*> used{&f};
  d.intake = describe(r, f);
  const auto candidates = offered_effects(used, vehicle, o);
  describe_candidates(used, vehicle, candidates, o, d.intake);
  add_faults(f.faults, f.excluded, d);
  judge_sizes(vehicle, o, d.findings);
  d.summary = format("%.1f s of %.1f s can be used (%zu windows cut out). ", f.usable() / f.rate_hz,
                     f.duration_s, f.excluded.size());
  for (const Finding& x : d.findings) d.summary += x.sentence + " ";
  std::string blind;
  for (const Detectability& x : d.intake.detectability)
    if (x.sigma < 3) blind += (blind.empty() ? "" : ", ") + x.effect;
  if (!blind.empty()) d.summary += "Of ordinary size, this flight cannot show: " + blind + ". ";
  for (const auto& group : d.intake.alias_groups) {
    d.summary += "Look alike: ";
    for (std::size_t k = 0; k < group.size(); ++k) d.summary += (k > 0 ? ", " : "") + group[k];
    d.summary += ". ";
  }
  for (const std::string& note : f.notes) d.summary += note + " ";
  d.summary += "Nothing was fitted.";
  return d;
}

}  // namespace

Result<Diagnosis> check(std::span<const Recording> recordings, const vehicle::Vehicle& vehicle,
                        const Options& o) {
  if (recordings.empty()) return bad_input("no recording to look at", "", "Name at least one recording");
  if (auto valid = vehicle::validate(vehicle); !valid) return tl::unexpected(valid.error());
  if (recordings.size() == 1) return check_one(recordings[0], vehicle, o);
  Diagnosis d;
  d.verdict = Verdict::checked;
  std::optional<Error> refused;
  int good = 0;
  for (const Recording& r : recordings) {
    auto one = check_one(r, vehicle, o);
    if (!one) {  // says nothing of the others
      refused = one.error();
      one = unusable(r, {one.error().message});
    }
    good += one->verdict != Verdict::unusable || !one->intake.signals.empty();
    merge_recording(*one, r.file, d);
    d.inputs.insert(d.inputs.end(), one->inputs.begin(), one->inputs.end());
    d.summary += (d.summary.empty() ? "" : " ") + r.file + ": " + one->summary;
    if (one->verdict == Verdict::unusable) d.verdict = Verdict::unusable;
    if (d.inputs.size() == 1)
      d.intake = std::move(one->intake);
    else
      d.further.push_back(std::move(one->intake));
  }
  if (good == 0 && refused) return Failure(*refused);
  return d;
}

}  // namespace omniflight::diagnosis
