#include "diagnosis_page.hpp"

#include <fmt/format.h>

#include <cmath>

#include "diagnosis_evidence.hpp"
#include "pilot_words.hpp"

namespace omniflight::cli {
namespace {

using namespace diagnosis;

constexpr double kTinyP = 1e-12;  // below it, how small says nothing more

std::string listed(const std::vector<std::string>& items) {
  std::string out;
  for (const auto& i : items) out += (out.empty() ? "" : ", ") + i;
  return out.empty() ? "-" : out;
}

report::Tone tone(const Diagnosis& d) {
  switch (d.verdict) {
    case Verdict::nothing_missing:
    case Verdict::explained:
      return report::Tone::ok;
    case Verdict::ambiguous:
    case Verdict::unfinished:
      return report::Tone::warn;
    case Verdict::unexplained:
    case Verdict::checked:
      return report::Tone::unknown;
    case Verdict::unusable:
      return report::Tone::bad;
  }
  return report::Tone::unknown;
}

/// Whether a model was asked at all.
bool asked(const Diagnosis& d) { return d.verdict != Verdict::unusable && d.verdict != Verdict::checked; }

void mismatches(report::Page& page, const Diagnosis& d) {
  report::Table t;
  t.caption = "Stages whose replay on recorded input leaves a significant residual";
  t.columns = {{.name = "stage"},     {.name = "channel"}, {.name = "frame"}, {.name = "RMS"},
               {.name = "noise RMS"}, {.name = "unit"},    {.name = "p"},     {.name = "where"}};
  for (const auto& m : d.mismatch) {
    const report::Cell p = m.p_value < kTinyP ? report::Cell("below 1e-12") : report::Cell(m.p_value);
    t.rows.push_back(
        {physics::to_string(m.stage), m.channel, m.frame, m.rms, m.noise_rms, m.unit, p, m.where});
  }
  page.section("What differs, and where");
  if (t.rows.empty())
    page.paragraph(!asked(d)                          ? "Nothing was compared with a model."
                   : d.verdict == Verdict::unfinished ? "Not known: the search was stopped."
                                                      : "No stage differs significantly from the model.");
  else
    page.table(t);
  if (!d.tracking_rms.empty()) {
    std::vector<report::Fact> facts;
    for (const auto& [channel, value] : d.tracking_rms)
      facts.push_back(
          {"tracking error " + channel, fmt::format("{:.4f}", value), channel[0] == 'p' ? "m RMS" : "RMS"});
    page.paragraph(
        "The tracking error alone, for comparison: integral action hides a constant load from it.");
    page.facts(facts);
  }
}

/// One line a finding: what is named, and what stands for it on this flight.
void groups(report::Page& page, const Diagnosis& d) {
  const bool several = std::any_of(d.findings.begin(), d.findings.end(),
                                   [](const auto& f) { return !f.cannot_be_told_apart_from.empty(); });
  if (!several) return;
  report::Table t;
  t.caption = "Of each line, one is there: what this flight cannot tell apart";
  t.columns = {{.name = "named"}, {.name = "explains it as well"}, {.name = "looks nearly the same"}};
  for (const auto& f : d.findings) {
    const auto& all = f.cannot_be_told_apart_from;
    const auto split = all.begin() + std::min<std::ptrdiff_t>(std::max(f.rivals, 0), std::ssize(all));
    t.rows.push_back({f.effect, listed({all.begin(), split}), listed({split, all.end()})});
  }
  page.table(t);
}

/// Single effects by evidence, as differences to the best: a ln Bayes factor of 100000 against nothing says
/// little.
void candidates(report::Page& page, const Diagnosis& d) {
  auto sorted = d.candidates;
  std::erase_if(sorted, [](const auto& c) { return !std::isfinite(c.gain); });
  if (sorted.empty()) return;
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.gain > b.gain; });
  if (sorted.size() > 16) sorted.resize(16);
  report::Table t;
  t.caption = "Each effect alone: how much worse than the best one";
  t.columns = {{.name = "effect"},
               {.name = "ln Bayes factor less", .significant_digits = 3},
               {.name = "against nothing"}};
  for (const auto& c : sorted)
    t.rows.push_back({c.effect, sorted.front().gain - c.gain,
                      c.gain > c.needed ? "more likely than nothing" : "no more likely than nothing"});
  page.details("What each effect would explain alone", [&](report::Page& p) { p.table(t); });
}

/// The chain from what differs to what explains it, and what was asked beside.
void chain(report::Page& page, const Diagnosis& d) {
  const auto steps = evidence(d);
  if (steps.empty()) return;
  page.section("Evidence");
  report::Table t;
  t.columns = {{.name = "question"}, {.name = "answer"}};
  for (const Evidence& e : steps) t.rows.push_back({e.question, e.answer});
  page.table(t);
  if (auto asked = asked_effects(d); !asked.rows.empty())
    page.details("What else was asked, one by one", [&](report::Page& p) { p.table(asked); });
}

void findings(report::Page& page, const Diagnosis& d) {
  page.section("Which physics");
  if (d.findings.empty())
    page.paragraph(!asked(d)                          ? "Not asked."
                   : d.verdict == Verdict::unfinished ? "Not known: the search was stopped."
                                                      : "No effect of the library is named.");
  report::Bars bars{.title = "Probability of each named effect", .full = 1.0};
  for (const auto& f : d.findings) {
    if (!std::isfinite(f.probability)) continue;  // of an answer that is not finished
    bars.bars.push_back(
        {.name = f.effect,
         .value = f.probability,
         .note = f.cannot_be_told_apart_from.empty() ? "" : "or " + listed(f.cannot_be_told_apart_from)});
  }
  if (!bars.bars.empty()) page.bars(bars);
  groups(page, d);
  for (const auto& f : d.findings) {
    page.paragraph(f.sentence);
    page.equation(f.latex);
    report::Table t;
    t.caption =
        f.effect + " (stage: " + physics::to_string(f.stage) + ", channels: " + listed(f.channels) + ")";
    t.columns = {{.name = "parameter"}, {.name = "symbol", .symbols = true},
                 {.name = "value"},     {.name = "95 % from"},
                 {.name = "to"},        {.name = "unit"}};
    for (const auto& p : f.parameters) {
      if (identifiable(f.effect, p))
        t.rows.push_back({p.name, p.symbol, p.value, p.low, p.high, p.unit});
      else
        t.rows.push_back({p.name, p.symbol, "not identifiable", "", "", p.unit});
    }
    page.table(t);
  }
  candidates(page, d);
}

void unknown_physics(report::Page& page, const Diagnosis& d) {
  if (d.unexplained.empty()) return;
  page.section("What no effect of the library explains");
  report::Table t;
  t.caption = "What can still be predicted, and from what";
  t.columns = {{.name = "channel"},    {.name = "frame"},  {.name = "share of what remains", .unit = "%"},
               {.name = "depends on"}, {.name = "parity"}, {.name = "energy"},
               {.name = "nearest"}};
  report::Table terms;
  terms.caption = "The smallest correction that predicts it: coefficient times (term less its mean)";
  terms.columns = {{.name = "channel"},     {.name = "frame"}, {.name = "term"},
                   {.name = "coefficient"}, {.name = "unit"},  {.name = "frequency", .unit = "Hz"}};
  for (const auto& u : d.unexplained) {
    t.rows.push_back(
        {u.channel, u.frame, 100 * u.share_of_residual, listed(u.depends_on), u.parity, u.energy, u.nearest});
    for (const auto& c : u.correction)
      terms.rows.push_back({u.channel, u.frame, c.words, c.coefficient, c.unit,
                            c.frequency_hz > 0 ? report::Cell(c.frequency_hz) : report::Cell(std::string())});
  }
  page.table(t);
  if (terms.rows.empty()) return;
  page.table(terms);
  page.paragraph(
      "model.yaml lists these terms under corrections, except those that follow an acceleration, and the "
      "simulator "
      "flies them; before and after below hold them as well.");
}

void fits(report::Page& page, const Diagnosis& d) {
  page.section("Does the fit improve");
  const auto table = [&](const std::vector<ChannelFit>& rows, const std::string& caption) {
    if (rows.empty()) return;
    report::Table t;
    t.caption = caption;
    t.columns = {{.name = "recording"},
                 {.name = "channel"},
                 {.name = "unit"},
                 {.name = "RMS before"},
                 {.name = "RMS after"},
                 {.name = "after / before", .significant_digits = 3},
                 {.name = "R2 before", .significant_digits = 3},
                 {.name = "R2 after", .significant_digits = 3}};
    for (const auto& r : rows) {
      const double ratio = r.rms_before > 0 ? r.rms_after / r.rms_before : 1.0;
      t.rows.push_back({r.recording.empty() ? "all fitted" : r.recording, r.channel, r.unit, r.rms_before,
                        r.rms_after, report::Cell(ratio, ratio), r.r2_before, r.r2_after});
    }
    page.table(t);
  };
  // what differs is in sight; the other channels, which show that nothing is spoilt, are folded
  const auto differs = [&](const ChannelFit& f) {
    return std::any_of(d.mismatch.begin(), d.mismatch.end(),
                       [&](const Mismatch& m) { return m.channel == f.channel; });
  };
  const auto part = [&](std::vector<ChannelFit> rows, bool wanted) {
    std::erase_if(rows, [&](const ChannelFit& f) { return differs(f) != wanted; });
    return rows;
  };
  table(part(d.fit.held_out, true), "Held out: data no fit has touched");
  table(part(d.fit.in_sample, true), "In sample");
  const auto others = part(d.fit.held_out, false), others_fitted = part(d.fit.in_sample, false);
  if (!others.empty() || !others_fitted.empty())
    page.details("Channels that do not differ", [&](report::Page&) {
      table(others, "Held out: data no fit has touched");
      table(others_fitted, "In sample");
    });
  if (!d.fit.rollout.empty()) {
    report::Table t;
    t.caption = "Open-loop prediction from recorded rotor speeds";
    t.columns = {{.name = "horizon", .unit = "s"},
                 {.name = "channel"},
                 {.name = "unit"},
                 {.name = "RMSE before"},
                 {.name = "RMSE after"}};
    for (const auto& r : d.fit.rollout)
      t.rows.push_back({r.horizon_s, r.channel, r.unit, r.rmse_before, r.rmse_after});
    page.table(t);
  }
}

/// Times at which a channel differs.
std::vector<report::Window> windows_of(const Diagnosis& d, const std::string& channel) {
  std::vector<report::Window> out;
  for (const Mismatch& m : d.mismatch) {
    if (m.stage != physics::Stage::wrench) continue;
    if (m.channel != channel && !(channel == "Fz_world" && m.channel == "Fz")) continue;
    for (const auto& [from, to] : m.windows_s)
      if (out.size() < 100)
        out.push_back({.from = from, .to = to, .label = "differs", .tone = report::Tone::warn});
  }
  return out;
}

void residual_plots(report::Page& page, const Diagnosis& d) {
  page.section("Residuals before and after");
  for (const Series& s : d.series) {
    for (std::size_t k = 0; k < s.channels.size(); ++k) {
      const bool torque = s.channels[k][0] == 'M';
      const std::string unit = torque ? "Nm" : (s.channels[k][0] == 'a' ? "m/s2" : "N");
      page.plot({.title = s.channels[k] + " residual",
                 .y_label = s.channels[k] + " [" + unit + "]",
                 .series = {{.name = "before", .x = s.t_s, .y = s.before[k]},
                            {.name = "after", .x = s.t_s, .y = s.after[k]}},
                 .windows = windows_of(d, s.channels[k]),
                 .height_px = 200,
                 .group = s.file});
      if (s.channels[k] == "Fz_world" && s.height_m.size() == s.t_s.size())
        page.plot({.title = "Vertical residual against height",
                   .x_label = "height [m]",
                   .y_label = "Fz, world [N]",
                   .series = {{.name = "before", .x = s.height_m, .y = s.before[k], .points = true},
                              {.name = "after", .x = s.height_m, .y = s.after[k], .points = true}}});
    }
    break;  // one flight is shown; the figures above cover all
  }
}

/// Where the flight went, coloured by the size of the force that the model does not explain.
void flight_path(report::Page& page, const Diagnosis& d, const recording::Recording& flown) {
  const recording::Signal* p = flown.find("position");
  if (!p) p = flown.find("est_position");
  if (!p || p->width() != 3 || d.series.empty() || d.series.front().t_s.size() < 10) return;
  const Series& s = d.series.front();
  const Eigen::MatrixXd x = recording::resample(*p, s.t_s, 0.5);
  const auto draw = [&](const std::vector<std::vector<double>>& rest, const std::string& title) {
    report::PathPlot plot{.title = title, .value_label = "unexplained force [N]"};
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double f = std::hypot(rest[0][k], rest[1][k], rest[2][k]);
      if (!x.row(i).allFinite() || !std::isfinite(f)) continue;
      plot.x.push_back(x(i, 0));
      plot.y.push_back(x(i, 1));
      plot.z.push_back(x(i, 2));
      plot.value.push_back(f);
      plot.t.push_back(s.t_s[k]);
    }
    if (plot.x.size() > 10) page.path_plot(plot);
  };
  if (s.before.size() < 3 || s.after.size() < 3) return;
  page.section("Where on the flight path");
  draw(s.before, "Before: force that the nominal model does not explain");
  draw(s.after, "After: force that the model found does not explain");
}

void intake_section(report::Page& page, const Intake& in, bool named) {
  if (in.signals.empty()) return;
  page.section(named ? "What " + in.recording + " can tell" : "What this recording can tell");
  report::Table signals;
  signals.caption = "Signals";
  signals.columns = {{.name = "signal"},
                     {.name = "unit"},
                     {.name = "samples"},
                     {.name = "rate", .unit = "Hz"},
                     {.name = "longest gap", .unit = "s"}};
  for (const auto& s : in.signals)
    signals.rows.push_back({s.name, s.unit, s.samples, s.rate_hz, s.longest_gap_s});
  page.table(signals);
  if (!in.alignment.empty()) {
    report::Table clocks;
    clocks.caption = "Clocks: how much later one signal comes than another, by cross-correlation";
    clocks.columns = {{.name = "signal"},
                      {.name = "comes after"},
                      {.name = "lag", .unit = "ms"},
                      {.name = "its standard error", .unit = "ms"},
                      {.name = "drift", .unit = "ppm"},
                      {.name = "its standard error", .unit = "ppm"},
                      {.name = "correlation"}};
    for (const auto& a : in.alignment)
      clocks.rows.push_back(
          {a.late, a.early, 1e3 * a.lag_s, 1e3 * a.lag_se, 1e6 * a.skew, 1e6 * a.skew_se, a.correlation});
    page.table(clocks);
  }
  if (!in.sensors.empty()) {
    report::Table sensors;
    sensors.caption = "What the sensors say of themselves";
    sensors.columns = {{.name = "signal"}, {.name = "quantity"}, {.name = "value"}, {.name = "unit"}};
    for (const auto& x : in.sensors) sensors.rows.push_back({x.signal, x.quantity, x.value, x.unit});
    page.table(sensors);
  }
  if (!in.missing.empty()) {
    report::Table missing;
    missing.caption = "What is missing, and what that costs; the most telling first";
    missing.columns = {{.name = "signal"}, {.name = "cost"}};
    for (const auto& x : in.missing) missing.rows.push_back({x.signal, x.costs});
    page.table(missing);
  }
  if (!in.detectability.empty()) {
    report::Bars bars{.title = "How clearly an effect of ordinary size would show (sigma)"};
    bars.marker = 3.0;
    bars.marker_label = "just visible";
    for (const auto& x : in.detectability)
      if (std::isfinite(x.sigma)) bars.bars.push_back({.name = x.effect, .value = x.sigma});
    page.bars(bars);
  }
  for (const auto& group : in.alias_groups)
    page.paragraph("These look alike on this flight: " + listed(group) + ".");
  for (const auto& note : in.notes) page.paragraph(note);
}

}  // namespace

Status write_page(const Diagnosis& d, const Refit& refit, const recording::Recording& flown,
                  const std::string& title, const std::string& path) {
  report::Page page(title, d.inputs.empty() ? "" : d.inputs.front().file);
  const auto steps = evidence(d);
  page.verdict(
      tone(d), first_sentence(d),
      steps.size() > 1 ? steps[0].answer + ".\nWith what is named, " + steps[1].answer + "." : d.summary);
  std::vector<report::Fact> facts;
  for (const auto& in : d.inputs) facts.push_back({in.file, fmt::format("{:.1f}", in.duration_s), "s"});
  page.facts(facts);
  chain(page, d);
  findings(page, d);
  mismatches(page, d);
  if (steps.size() > 1) page.details("All of it in one paragraph", d.summary);
  unknown_physics(page, d);
  const bool fitted = asked(d);
  if (fitted) fits(page, d);
  if (refit.flown) {
    page.section("The simulator with the model found");
    page.table(comparison_table(refit.before, "Before: nominal simulation against the recording"));
    page.table(comparison_table(refit.after, "After: simulation with model.yaml against the recording"));
  }
  flight_path(page, d, flown);
  if (fitted) residual_plots(page, d);
  add_next_flight(page, d.next_flight);
  intake_section(page, d.intake, !d.further.empty());
  for (const Intake& in : d.further) intake_section(page, in, true);
  if (!d.left_out.empty()) page.paragraph("Left out: " + listed(d.left_out) + ".");
  page.section("Inputs");
  for (const auto& in : d.inputs) {
    std::string cut;
    for (const auto& w : in.excluded) cut += fmt::format("{:.2f} to {:.2f} s: {}\n", w.from_s, w.to_s, w.why);
    page.details(in.file + ", sha256 " + in.sha256,
                 "Signals: " + listed(in.signals) + "\nCut out:\n" + (cut.empty() ? "nothing" : cut));
  }
  return page.write(path);
}

}  // namespace omniflight::cli
