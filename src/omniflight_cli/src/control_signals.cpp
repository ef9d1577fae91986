#include "control_signals.hpp"

#include <cmath>
#include <functional>

namespace omniflight::cli {
namespace {

using recording::Recording;
using recording::Signal;

/// A stage of the chain: where its samples come from.
struct Stage {
  const char* stage;
  const char* name;                     ///< of a channel: name + component
  std::vector<const char*> components;  ///< names; empty: 1, 2, ... for each rotor
  const char* unit;
  double scale;  ///< from the signal's unit
  const char* signal;
  int first;               ///< column of the first component
  const char* plot_title;  ///< of a plot of the components
};

const std::vector<Stage>& stages() {
  static const std::vector<Stage> table{
      {"control", "qddr ", {"x", "y", "z"}, "m/s2", 1, "qddr", 0, "Demanded acceleration (control)"},
      {"control",
       "qddr ",
       {"roll", "pitch", "yaw"},
       "rad/s2",
       1,
       "qddr",
       3,
       "Demanded angular acceleration (control)"},
      {"control", "integral ", {"x", "y", "z"}, "m/s2", 1, "integral", 0, "Integral action (control)"},
      {"control", "integral ", {"roll", "pitch", "yaw"}, "rad/s2", 1, "integral", 3, ""},
      {"allocation",
       "not achieved ",
       {"x", "y", "z"},
       "m/s2",
       1,
       "missed",
       0,
       "Demanded less achieved acceleration (allocation)"},
      {"allocation", "not achieved ", {"roll", "pitch", "yaw"}, "rad/s2", 1, "missed", 3, ""},
      {"allocation", "alpha", {""}, "deg", 180.0 / kPi, "alpha_command", 0, "Tilt alpha (allocation)"},
      {"allocation", "u", {}, "N", 1, "thrust_command", 0, "Rotor thrusts u (allocation)"},
      {"actuation", "speed ", {}, "rad/s", 1, "rotor_speed", 0, "Rotor speeds (actuation)"},
  };
  return table;
}

/// The samples of a stage; `missed` is made of two signals with one time base.
Signal samples(const Recording& r, const std::string& name) {
  if (name != "missed") return r.find(name) ? *r.find(name) : Signal{};
  const Signal *wanted = r.find("qddr"), *given = r.find("qdd");
  if (!wanted || !given) return {};
  Signal out = *wanted;
  out.values -= recording::resample(*given, wanted->t_s);
  return out;
}

double rms(const Signal& s, Eigen::Index column, double from, double to) {
  double sum = 0;
  std::size_t used = 0;
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    const double t = s.t_s[static_cast<std::size_t>(i)], x = s.values(i, column);
    if (t < from || t > to || !std::isfinite(x)) continue;
    sum += x * x;
    ++used;
  }
  return used > 0 ? std::sqrt(sum / static_cast<double>(used)) : 0.0;
}

double rms_power(const Flown& f) {
  const PowerCurve p = mechanical_power(f.recording, f.vehicle);
  Signal s;
  s.t_s = p.t;
  s.values = Eigen::Map<const Eigen::VectorXd>(p.W.data(), static_cast<Eigen::Index>(p.W.size()));
  return rms(s, 0, f.metrics.from, f.metrics.to);
}

std::string channel(const Stage& stage, Eigen::Index k) {
  return stage.name +
         (stage.components.empty() ? std::to_string(k + 1) : stage.components[static_cast<std::size_t>(k)]);
}

/// Calls with every stage and component that both flights have.
void for_each(const Flown& a, const Flown& b,
              const std::function<void(const Stage&, Eigen::Index, const Signal&, const Signal&)>& call) {
  for (const Stage& stage : stages()) {
    const Signal x = samples(a.recording, stage.signal), y = samples(b.recording, stage.signal);
    const Eigen::Index first = stage.first;
    Eigen::Index count = std::min(x.width(), y.width()) - first;
    if (!stage.components.empty())
      count = std::min(count, static_cast<Eigen::Index>(stage.components.size()));
    for (Eigen::Index k = 0; k < count; ++k) call(stage, k, x, y);
  }
}

report::Series line(const std::string& name, const Flown& f, const Signal& s, Eigen::Index column,
                    double scale, bool dashed) {
  report::Series out{.name = name, .dashed = dashed};
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    out.x.push_back(s.t_s[static_cast<std::size_t>(i)] - f.metrics.from);
    out.y.push_back(scale * s.values(i, column));
  }
  return out;
}

}  // namespace

std::vector<ControlRow> compare_control(const Flown& a, const Flown& b) {
  std::vector<ControlRow> rows;
  for_each(a, b, [&](const Stage& stage, Eigen::Index k, const Signal& x, const Signal& y) {
    rows.push_back({stage.stage, channel(stage, k), stage.unit,
                    stage.scale * rms(x, stage.first + k, a.metrics.from, a.metrics.to),
                    stage.scale * rms(y, stage.first + k, b.metrics.from, b.metrics.to)});
  });
  if (const double pa = rms_power(a), pb = rms_power(b); pa > 0 && pb > 0)
    rows.push_back({"power", "mechanical", "W", pa, pb});
  return rows;
}

report::Table control_table(const std::vector<ControlRow>& rows) {
  report::Table t;
  t.caption = "RMS of every control signal while the reference moves; ratio = recorded / simulated";
  t.columns = {{.name = "stage"},     {.name = "channel"},  {.name = "unit"},
               {.name = "simulated"}, {.name = "recorded"}, {.name = "ratio", .significant_digits = 3}};
  for (const ControlRow& r : rows)
    t.rows.push_back({r.stage, r.channel, r.unit, r.simulated, r.real,
                      r.ratio() > 0 ? report::Cell(r.ratio(), r.ratio()) : report::Cell("-")});
  return t;
}

nlohmann::json to_json(const std::vector<ControlRow>& rows) {
  nlohmann::json out = nlohmann::json::array();
  for (const ControlRow& r : rows)
    out.push_back({{"stage", r.stage},
                   {"channel", r.channel},
                   {"unit", r.unit},
                   {"simulated_rms", r.simulated},
                   {"real_rms", r.real},
                   {"ratio", r.ratio()}});
  return out;
}

void plot_control(report::Page& page, const Flown& a, const Flown& b) {
  std::vector<report::TimePlot> plots;
  for_each(a, b, [&](const Stage& stage, Eigen::Index k, const Signal& x, const Signal& y) {
    const bool rotors = stage.components.empty();
    if (*stage.plot_title == 0 || (rotors && k >= 4)) return;  // the upper rotors stand for all
    if (plots.empty() || plots.back().title != stage.plot_title)
      plots.push_back({.title = stage.plot_title,
                       .x_label = "time from the first motion [s]",
                       .y_label = std::string(stage.signal) + " [" + stage.unit + "]",
                       .height_px = 220,
                       .group = "control"});
    const std::string name = channel(stage, k);
    plots.back().series.push_back(line(name + " simulated", a, x, stage.first + k, stage.scale, true));
    plots.back().series.push_back(line(name + " recorded", b, y, stage.first + k, stage.scale, false));
  });
  report::TimePlot power{.title = "Mechanical power",
                         .x_label = "time from the first motion [s]",
                         .y_label = "power [W]",
                         .height_px = 220,
                         .group = "control"};
  for (const Flown* f : {&a, &b}) {
    PowerCurve p = mechanical_power(f->recording, f->vehicle);
    for (double& t : p.t) t -= f->metrics.from;
    if (!p.t.empty())
      power.series.push_back({.name = f == &a ? "simulated" : "recorded",
                              .x = std::move(p.t),
                              .y = std::move(p.W),
                              .dashed = f == &a});
  }
  if (!power.series.empty()) plots.push_back(std::move(power));
  for (auto& plot : plots) page.plot(std::move(plot));
}

}  // namespace omniflight::cli
