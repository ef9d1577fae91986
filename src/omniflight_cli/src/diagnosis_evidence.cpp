#include "diagnosis_evidence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "omniflight_core/frames.hpp"

namespace omniflight::cli {
namespace {

using namespace diagnosis;

constexpr const char* kAlone = "evidence alone against nothing";  // what the inference asks of every effect
constexpr int kStepsPerLeg = 20;

/// The mismatch that stands out furthest above its noise.
const Mismatch* clearest(const Diagnosis& d) {
  const auto ratio = [](const Mismatch& m) { return m.noise_rms > 0 ? m.rms / m.noise_rms : 0.0; };
  const auto found = std::max_element(d.mismatch.begin(), d.mismatch.end(),
                                      [&](const auto& a, const auto& b) { return ratio(a) < ratio(b); });
  return found == d.mismatch.end() ? nullptr : &*found;
}

std::string change(double before, double after, const std::string& unit) {
  return fmt::format("{:.3g} {} RMS before, {:.3g} {} after", before, unit, after, unit);
}

/// Root of the mean square over all stretches that no fit has touched; none without them.
std::optional<Evidence> held_out(const Diagnosis& d, const std::string& channel) {
  double before = 0, after = 0;
  int stretches = 0;
  std::string unit;
  for (const ChannelFit& f : d.fit.held_out) {
    if (f.channel != channel) continue;
    before += f.rms_before * f.rms_before;
    after += f.rms_after * f.rms_after;
    unit = f.unit;
    ++stretches;
  }
  if (stretches == 0 || !(before > 0)) return std::nullopt;
  before = std::sqrt(before / stretches), after = std::sqrt(after / stretches);
  return Evidence{"Does it hold on data that no fit has touched?",
                  fmt::format("{}: {}: {}, over {} stretch{}", after < before ? "Yes" : "No", channel,
                              change(before, after, unit), stretches, stretches == 1 ? "" : "es")};
}

/// Furthest horizon at which the position is predicted in open loop.
std::optional<Evidence> predicted_motion(const Diagnosis& d) {
  const RolloutFit* furthest = nullptr;
  for (const RolloutFit& f : d.fit.rollout)
    if (f.channel == "position" && (!furthest || f.horizon_s > furthest->horizon_s)) furthest = &f;
  if (!furthest) return std::nullopt;
  return Evidence{
      "Does it predict the motion?",
      fmt::format("{}: position {:.3g} s ahead from the rotor speeds alone: {}",
                  furthest->rmse_after < furthest->rmse_before ? "Yes" : "No", furthest->horizon_s,
                  change(furthest->rmse_before, furthest->rmse_after, furthest->unit))};
}

/// How many effects were asked, and why the others are not named.
std::optional<Evidence> what_else(const Diagnosis& d) {
  int kept = 0, refused = 0, not_asked = 0;
  for (const Decision& x : d.decisions) {
    if (x.asked == kAlone) ++(x.outcome.starts_with("kept") ? kept : refused);
    if (x.outcome.starts_with("not asked")) ++not_asked;
  }
  if (kept + refused == 0) return std::nullopt;
  std::string text = fmt::format(
      "{} effects and forms of unknown physics; {} kept, {} refused as "
      "improbable beside what is named",
      kept + refused, kept, refused);
  if (not_asked > 0) text += fmt::format("; {} were not asked, one by one below", not_asked);
  return Evidence{"What else was asked, and why is it not named?", text};
}

/// Blows are no noise, and no effect either.
std::optional<Evidence> what_came_at_once(const Diagnosis& d) {
  constexpr int kByChance = 2;  // in a channel of noise
  std::string text;
  for (const Remaining& x : d.remaining)
    if (x.lone_samples > kByChance)
      text += fmt::format("{}{}: {} lone samples of up to {:.2g} {}, the largest at {:.2f} s",
                          text.empty() ? "" : "; ", x.channel, x.lone_samples, x.largest_lone_sample, x.unit,
                          x.largest_at_s);
  if (text.empty()) return std::nullopt;
  return Evidence{"What came and went at once?", text + ": blows, snatches or faults of a sensor"};
}

}  // namespace

std::vector<Evidence> evidence(const Diagnosis& d) {
  const bool answered =
      d.verdict != Verdict::unfinished && d.verdict != Verdict::checked && d.verdict != Verdict::unusable;
  const Mismatch* first = clearest(d);
  if (!answered || !first) return {};
  std::vector<Evidence> out;
  std::string where = first->where.empty() ? "" : "; " + first->where;
  out.push_back(
      {"What differs most?", fmt::format("{}: {:.3g} {} RMS where {:.2g} {} is noise{}", first->channel,
                                         first->rms, first->unit, first->noise_rms, first->unit, where)});
  if (auto blows = what_came_at_once(d)) out.push_back(std::move(*blows));
  if (d.findings.empty() && d.unexplained.empty()) return out;
  for (const ChannelFit& f : d.fit.in_sample)
    if (f.channel == first->channel)
      out.push_back({"What is left of it with what is named?",
                     f.channel + ": " + change(f.rms_before, f.rms_after, f.unit)});
  for (auto next : {held_out(d, first->channel), predicted_motion(d), what_else(d)})
    if (next) out.push_back(std::move(*next));
  return out;
}

report::Table asked_effects(const Diagnosis& d) {
  std::vector<const Decision*> asked;
  for (const Decision& x : d.decisions)
    if (x.asked == kAlone || x.outcome.starts_with("not asked")) asked.push_back(&x);
  const auto rank = [](const Decision* x) {
    return x->outcome.starts_with("kept") ? 0 : x->outcome.starts_with("not asked") ? 2 : 1;
  };
  std::stable_sort(asked.begin(), asked.end(), [&](const auto* a, const auto* b) {
    return std::make_pair(rank(a), -a->statistic) < std::make_pair(rank(b), -b->statistic);
  });
  report::Table t;
  t.caption = "What was asked, and what became of it";
  t.columns = {{.name = "effect"}, {.name = "outcome"}};
  for (const Decision* x : asked) t.rows.push_back({x->about, x->outcome});
  return t;
}

std::optional<report::PathPlot> next_flight_path(const NextFlight& next) {
  if (next.proposed.empty() || next.proposed.front().waypoints.empty()) return std::nullopt;
  const ProposedFlight* flight = &next.proposed.front();
  for (const ProposedFlight& f : next.proposed)  // the one in the mission's file, where there is one
    if (!next.mission.empty() && f.separations_sigma == next.separations_sigma) {
      flight = &f;
      break;
    }
  report::PathPlot plot{.title = "The next flight: " + flight->name, .value_label = "lean from level [deg]"};
  Vec3 p = flight->start, rpy = Vec3::Zero();
  const auto lean = [](const Vec3& deg) {
    return to_degrees(std::acos(std::clamp(std::cos(deg.x() * kPi / 180) * std::cos(deg.y() * kPi / 180),
                                           -1.0, 1.0)));  // body z against up
  };
  for (const ProposedWaypoint& w : flight->waypoints) {
    for (int k = 0; k <= kStepsPerLeg; ++k) {
      const double s = static_cast<double>(k) / kStepsPerLeg;
      const Vec3 at = p + s * w.by;
      plot.x.push_back(at.x());
      plot.y.push_back(at.y());
      plot.z.push_back(at.z());
      plot.value.push_back(lean(rpy + s * (w.rpy_deg - rpy)));
    }
    p += w.by;
    rpy = w.rpy_deg;
  }
  plot.height_px = 220;
  return plot;
}

void add_next_flight(report::Page& page, const NextFlight& next) {
  if (next.manoeuvres.empty()) return;
  page.section("What to fly next");
  for (const auto& text : next.manoeuvres) page.paragraph(text);
  if (auto path = next_flight_path(next)) page.path_plot(std::move(*path));
  report::Table t;
  t.caption = "Predicted separation of the explanations that this flight leaves";
  t.columns = {{.name = "manoeuvre"}, {.name = "separation", .unit = "sigma"}};
  for (const auto& f : next.proposed) t.rows.push_back({f.words, f.separation_sigma});
  if (!t.rows.empty()) page.table(t);
  if (!next.mission.empty())
    page.paragraph("The mission " + next.mission + " holds the best of them that fits the test bed.");
  if (const std::string left = diagnosis::stay_together(next); !left.empty())
    page.paragraph("It would hardly tell apart: " + left + ".");
}

}  // namespace omniflight::cli
