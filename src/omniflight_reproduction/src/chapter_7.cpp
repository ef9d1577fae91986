// Chapter 7 without its laboratory: trajectories 1 and 2 in the simulator and with everything hidden, through
// gateway and boards.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "chapters.hpp"
#include "flown.hpp"
#include "omniflight_reproduction/flights.hpp"
#include "table_7_1.hpp"

namespace omniflight::reproduction {
namespace {

struct Pair {
  Flown simulated, hidden;
  std::string words;  ///< what `hidden` is
};

/// The nominal flight and the one with everything hidden, through the boards where there is one.
Result<Pair> pair(const Inputs& in, const std::string& t) {
  auto nominal = flown(in, t + "_nominal"), boards = flown(in, t + "_hidden_boards"),
       hidden = flown(in, t + "_hidden");
  for (const auto* f : {&nominal, &boards, &hidden})
    if (!*f) return Failure(f->error());
  if (!*nominal || (!*boards && !*hidden))
    return fail(ErrorCode::incomplete, "the flights that it compares were not flown", t);
  if (*boards) return Pair{**nominal, **boards, "hidden causes, through the boards"};
  return Pair{**nominal, **hidden, "hidden causes, simulator"};
}

void add_lines(report::TimePlot& plot, const Pair& p, const std::string& signal,
               const std::vector<std::string>& names, int first, double scale = 1) {
  std::vector<std::string> a, b;
  for (const auto& n : names) a.push_back(n + " simulated"), b.push_back(n + " hidden");
  for (auto& s : curves(p.simulated, signal, a, first, scale, true)) plot.series.push_back(std::move(s));
  for (auto& s : curves(p.hidden, signal, b, first, scale, false)) plot.series.push_back(std::move(s));
}

report::TimePlot plot_of(const std::string& title, const std::string& label, const std::string& group) {
  return {.title = title,
          .x_label = "time from the first motion [s]",
          .y_label = label,
          .height_px = 220,
          .group = group};
}

template <int T>
std::string name() {
  return "t" + std::to_string(T);
}

template <int T>
Result<Finding> positions(const Inputs& in) {
  const auto p = pair(in, name<T>());
  if (!p) return Failure(p.error());
  Finding f;
  for (int k = 0; k < 3; ++k) {
    const std::string axis(1, "xyz"[k]);
    auto plot = plot_of("Position " + axis, axis + " [m]", "positions " + name<T>());
    for (auto& s : curves(p->simulated, "ref_position", {"reference"}, k, 1, true))
      plot.series.push_back(std::move(s));
    add_lines(plot, *p, "position", {axis}, k);
    f.plots.push_back(std::move(plot));
  }
  f.rows = {shown("largest distance from the reference, simulated", "m",
                  p->simulated.metrics.measured.worst_position),
            shown("the same, " + p->words, "m", p->hidden.metrics.measured.worst_position)};
  return f;
}

report::Series error_curve(const std::string& label, const Flown& flown, int column, bool dashed) {
  report::Series s{.name = label, .dashed = dashed};
  const auto& m = flown.metrics.measured;
  const auto step = step_of_curve(m.t.size());
  for (std::size_t i = 0; i < m.t.size(); i += step) {
    s.x.push_back(m.t[i] - flown.metrics.from);
    s.y.push_back(m.error(static_cast<Eigen::Index>(i), column));
  }
  return s;
}

/// Errors in position (first 0) or attitude (first 3).
Result<Finding> errors(const Inputs& in, const std::string& t, int first) {
  const auto p = pair(in, t);
  if (!p) return Failure(p.error());
  Finding f;
  for (int k = first; k < first + 3; ++k) {
    const char* const names[] = {"x", "y", "z", "roll", "pitch", "yaw"};
    auto plot =
        plot_of(std::string("Error in ") + names[k], first == 0 ? "error [m]" : "error [deg]", t + "errors");
    plot.series = {error_curve("simulated", p->simulated, k, true),
                   error_curve("hidden", p->hidden, k, false)};
    f.plots.push_back(std::move(plot));
    const auto rmse = [&](const Flown& x) {
      return first == 0 ? x.metrics.measured.position_rmse[k] : x.metrics.measured.attitude_rmse[k - 3];
    };
    const char* unit = first == 0 ? "m" : "deg";
    f.rows.push_back(shown(std::string("RMSE ") + names[k] + ", simulated", unit, rmse(p->simulated)));
    f.rows.push_back(shown(std::string("RMSE ") + names[k] + ", " + p->words, unit, rmse(p->hidden)));
  }
  f.notes = {"Printed as curves; their RMSE stands in table 7.1 and is compared there."};
  return f;
}

template <int T>
Result<Finding> position_errors(const Inputs& in) {
  return errors(in, name<T>(), 0);
}
template <int T>
Result<Finding> attitude_errors(const Inputs& in) {
  return errors(in, name<T>(), 3);
}

Result<Finding> power(const Inputs& in) {
  Finding f;
  for (const char* t : {"t1", "t2"}) {
    const auto p = pair(in, t);
    if (!p) return Failure(p.error());
    auto plot =
        plot_of(std::string("Mechanical power, trajectory ") + t[1], "power [W]", std::string("power ") + t);
    for (const Flown* x : {&p->simulated, &p->hidden}) {
      const auto curve = report::mechanical_power(*x->recording, in.omnimorph);
      report::Series s{.name = x == &p->simulated ? "simulated" : "hidden", .dashed = x == &p->simulated};
      const auto step = step_of_curve(curve.t.size());
      for (std::size_t i = 0; i < curve.t.size(); i += step) {
        if (curve.t[i] < x->metrics.from || curve.t[i] > x->metrics.to) continue;
        s.x.push_back(curve.t[i] - x->metrics.from);
        s.y.push_back(curve.W[i]);
      }
      plot.series.push_back(std::move(s));
    }
    f.plots.push_back(std::move(plot));
    f.rows.push_back(
        shown(fmt::format("{}: mean mechanical power, simulated", t), "W", p->simulated.metrics.mean_power));
    f.rows.push_back(shown(fmt::format("{}: the same, {}", t, p->words), "W", p->hidden.metrics.mean_power));
  }
  return f;
}

Result<Finding> control_signals(const Inputs& in) {
  Finding f;
  for (const char* t : {"t1", "t2"}) {
    const auto p = pair(in, t);
    if (!p) return Failure(p.error());
    report::Table table;
    table.caption = fmt::format("Trajectory {}: RMS while the reference moves", t[1]);
    table.columns = {{.name = "signal"}, {.name = "unit"}, {.name = "simulated"}, {.name = "hidden"}};
    const char* const axes[] = {"x", "y", "z", "roll", "pitch", "yaw"};
    for (const auto& [signal, words] :
         {std::pair{"qddr", "demanded acceleration"}, {"integral", "integral action"}})
      for (int k = 0; k < 6; ++k)
        table.rows.push_back({fmt::format("{} {}", words, axes[k]), k < 3 ? "m/s2" : "rad/s2",
                              rms(p->simulated, signal, k), rms(p->hidden, signal, k)});
    for (int k = 0; k < in.omnimorph.rotor_count(); ++k)
      table.rows.push_back({fmt::format("thrust of rotor {}", k + 1), "N",
                            rms(p->simulated, "thrust_command", k), rms(p->hidden, "thrust_command", k)});
    f.tables.push_back(std::move(table));
    auto force = plot_of(std::string("Integral action, trajectory ") + t[1], "integral [m/s2]",
                         std::string("control ") + t),
         turn = plot_of(std::string("Integral action about the axes, trajectory ") + t[1],
                        "integral [rad/s2]", std::string("control ") + t);
    add_lines(force, *p, "integral", {"x", "y", "z"}, 0);
    add_lines(turn, *p, "integral", {"roll", "pitch", "yaw"}, 3);
    for (auto* plot : {&force, &turn})
      if (!plot->series.empty()) f.plots.push_back(std::move(*plot));
  }
  f.notes = {
      "What is hidden shows in the integral action: it carries the cable and the pull, which the tracking "
      "error hides."};
  return f;
}

/// What the diagnosis found in the flights through the boards, beside what was hidden in them.
Result<Finding> diagnosed(const Inputs& in) {
  if (in.diagnosis.empty()) return fail(ErrorCode::incomplete, "the flights were not diagnosed", "diagnosis");
  const auto j = nlohmann::json::parse(in.diagnosis, nullptr, false);
  if (!j.is_object()) return bad_input("is no JSON object", "diagnosis.json", "Delete it and run again");
  const auto text = [](const nlohmann::json& o, const char* key) {
    return o.is_object() && o.contains(key) && o[key].is_string() ? o[key].get<std::string>() : std::string();
  };
  Finding f;
  report::Table found;
  found.caption = "What the diagnosis of both flights together says";
  found.columns = {{.name = "effect"}, {.name = "probability"}, {.name = "parameters"}};
  if (const auto& list = j.value("findings", nlohmann::json::array()); list.is_array())
    for (const auto& one : list) {
      std::string parameters;
      if (one.is_object() && one.contains("parameters") && one["parameters"].is_array())
        for (const auto& p : one["parameters"])
          if (p.is_object() && p.contains("value") && p["value"].is_number())
            parameters += fmt::format("{}{} {:.4g} {}", parameters.empty() ? "" : ", ", text(p, "name"),
                                      p["value"].get<double>(), text(p, "unit"));
      const bool likely = one.is_object() && one.contains("probability") && one["probability"].is_number();
      found.rows.push_back(
          {text(one, "effect"),
           likely ? report::Cell(fmt::format("{:.2f}", one["probability"].get<double>())) : report::Cell("-"),
           parameters.empty() ? "-" : parameters});
    }
  report::Table hidden;
  hidden.caption = "What was hidden";
  hidden.columns = {{.name = "cause"}, {.name = "effects"}};
  for (const Cause& c : causes()) hidden.rows.push_back({c.words, c.effects});
  f.tables = {found, hidden};
  f.notes = {"Verdict: " + text(j, "verdict") + ". " + text(j, "summary")};
  f.rows = {shown("findings", "", static_cast<double>(found.rows.size())),
            shown("causes hidden", "", static_cast<double>(causes().size()))};
  return f;
}

std::vector<std::string> of(const std::vector<std::string>& names) {
  std::vector<std::string> out;
  for (const char* t : {"t1_", "t2_"})
    for (const auto& n : names) out.push_back(t + n);
  return out;
}

std::vector<std::string> everything() {
  std::vector<std::string> out;
  for (const Flight& f : flights()) out.push_back(f.name);
  return out;
}

}  // namespace

std::vector<Figure> chapter_7() {
  const auto compared_1 = std::vector<std::string>{"t1_nominal", "t1_hidden", "t1_hidden_boards"},
             compared_2 = std::vector<std::string>{"t2_nominal", "t2_hidden", "t2_hidden_boards"},
             both = of({"nominal", "hidden", "hidden_boards"});
  return {
      {"table 7.1", "Tracking and power, simulated and real", false, false, everything(), false, table_7_1},
      {"7.2", "Trajectory 1: positions", true, false, compared_1, false, positions<1>},
      {"7.3", "Trajectory 1: errors in position", true, false, compared_1, false, position_errors<1>},
      {"7.4", "Trajectory 1: errors in attitude", true, false, compared_1, false, attitude_errors<1>},
      {"7.5", "Trajectory 2: positions", true, false, compared_2, false, positions<2>},
      {"7.6", "Trajectory 2: errors in position", true, false, compared_2, false, position_errors<2>},
      {"7.7", "Trajectory 2: errors in attitude", true, false, compared_2, false, attitude_errors<2>},
      {"7.8", "Power of both trajectories", true, false, both, false, power},
      {"7.9", "Control signals", false, false, both, false, control_signals},
      {"chapter 7", "What the diagnosis finds in those flights", true, false, of({"hidden_boards"}), true,
       diagnosed},
  };
}

}  // namespace omniflight::reproduction
