#include "motor_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "omniflight_core/frames.hpp"

namespace omniflight::cli {
namespace {

using namespace identification;
using nlohmann::json;

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json estimate(double value, double sigma, const char* unit) {
  return {{"value", number(value)},
          {"interval95", {number(value - 1.96 * sigma), number(value + 1.96 * sigma)}},
          {"unit", unit}};
}

json complex_list(const std::vector<std::complex<double>>& values) {
  json out = json::array();
  for (const auto& v : values) out.push_back({v.real(), v.imag()});
  return out;
}

json test_json(const ResidualTest& t) {
  return {{"statistic", number(t.statistic)}, {"p_value", number(t.p_value)}, {"passed", t.passed}};
}

json structure_json(const StructureResult& s) {
  const PolynomialModel& m = s.candidate.fitted.model;
  const Orders o = m.orders();
  json parameters = json::array();
  const auto names = m.parameter_names();
  const Eigen::VectorXd theta = m.parameters();
  for (Eigen::Index k = 0; k < theta.size(); ++k)
    parameters.push_back({{"name", names[static_cast<std::size_t>(k)]},
                          {"value", number(theta[k])},
                          {"sigma", number(std::sqrt(s.candidate.fitted.covariance(k, k)))}});
  json out{
      {"structure", name_of(s.structure)},
      {"orders", {{"a", o.a}, {"b", o.b}, {"c", o.c}, {"d", o.d}, {"f", o.f}, {"delay_samples", o.delay}}},
      {"parameters", parameters},
      {"fit_percent",
       {{"estimation", number(s.candidate.estimation_percent)},
        {"validation", number(s.candidate.validation_percent)}}},
      {"poles", complex_list(m.poles())},
      {"zeros", complex_list(m.zeros(0))},
      {"innovation_rms_radps", number(std::sqrt(s.candidate.fitted.variance))},
      {"whiteness", test_json(s.whiteness)},
      {"independence", test_json(s.independence)}};
  if (s.continuous)
    out["continuous"] = {
        {"lag_s", s.continuous->lag_s}, {"delay_s", s.continuous->delay_s}, {"gain", s.continuous->gain}};
  if (s.structure == Structure::state_space) {
    const StateSpace ss = state_space(m);
    const auto rows = [](const Eigen::MatrixXd& M) {
      json list = json::array();
      for (Eigen::Index i = 0; i < M.rows(); ++i)
        list.push_back(std::vector<double>(M.row(i).begin(), M.row(i).end()));
      return list;
    };
    out["matrices"] = {{"A", rows(ss.A)}, {"B", rows(ss.B)}, {"C", rows(ss.C)}, {"K", rows(ss.K)}};
  }
  return out;
}

/// Speed [rad/s] that a share of the samples does not exceed.
double quantile(const Dataset& data, double share) {
  std::vector<double> all;
  for (const Experiment& e : data.experiments) all.insert(all.end(), e.y.begin(), e.y.end());
  const auto at = all.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(all.size() - 1));
  std::nth_element(all.begin(), at, all.end());
  return *at;
}

json rotor_json(const RotorReport& r, const MotorSignals& signals) {
  const MotorDynamics& m = r.result.motor;
  json structures = json::array();
  for (const StructureResult& s : r.result.structures) structures.push_back(structure_json(s));
  json out{
      {"rotor", r.rotor + 1},
      {"lag_up", estimate(m.lag_up, m.sigma_lag_up(), "s")},
      {"lag_down", estimate(m.lag_down, m.sigma_lag_down(), "s")},
      {"delay", estimate(m.delay, m.sigma_delay(), "s")},
      {"gain", estimate(m.gain[0], std::sqrt(m.covariance(0, 0)), signals.unit == "rad/s" ? "1" : "rad/s")},
      {"fit_percent",
       {{"estimation", number(m.fit_percent)}, {"validation", number(r.result.validation_percent)}}},
      {"battery_voltage", name_of(r.voltage)},
      {"speeds_radps", {quantile(r.validation, 0.1), quantile(r.validation, 0.9)}},
      {"best_structure", name_of(r.result.structures.front().structure)},
      {"structures", structures},
      {"closed_loop", !r.result.feedback.passed},
      {"closed_loop_note", closed_loop_words(r.result)}};
  if (m.gain.size() > 1) out["voltage_gain"] = estimate(m.gain[1], std::sqrt(m.covariance(1, 1)), "rad/s/V");
  if (r.result.prbs)
    out["prbs"] = {{"from_sample", r.result.prbs->from},
                   {"to_sample", r.result.prbs->to},
                   {"bits", r.result.prbs->bits},
                   {"bit_s", r.result.prbs->bit_samples * signals.period_s}};
  json not_fitted = json::array();
  for (const Error& e : r.result.failed) not_fitted.push_back(e.text());
  out["not_fitted"] = not_fitted;
  return out;
}

report::Series series(std::string name, const std::vector<double>& x, const Eigen::VectorXd& y) {
  report::Series s;
  s.name = std::move(name);
  s.x = x;
  s.y.assign(y.begin(), y.end());
  return s;
}

std::vector<double> times(Eigen::Index count, double period_s) {
  std::vector<double> t(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < t.size(); ++k) t[k] = period_s * static_cast<double>(k);
  return t;
}

void structure_table(report::Page& page, const RotorResult& r) {
  report::Table t;
  t.caption =
      "Structures, best on the validation data first. Fit: 100 (1 - |y - simulation| / |y - mean|), as "
      "MATLAB's compare.";
  t.columns = {{.name = "structure"},
               {.name = "poles"},
               {.name = "fit, validation", .unit = "%"},
               {.name = "fit, estimation", .unit = "%"},
               {.name = "lag", .unit = "ms"},
               {.name = "delay", .unit = "ms"},
               {.name = "residuals white"},
               {.name = "independent of the command"}};
  for (const StructureResult& s : r.structures)
    t.rows.push_back(
        {name_of(s.structure), static_cast<int>(s.candidate.fitted.model.poles().size()),
         s.candidate.validation_percent, s.candidate.estimation_percent,
         s.continuous ? 1000 * s.continuous->lag_s : std::nan(""),
         s.continuous ? 1000 * s.continuous->delay_s : std::nan(""),
         fmt::format("{} (p = {:.2g})", s.whiteness.passed ? "yes" : "no", s.whiteness.p_value),
         fmt::format("{} (p = {:.2g})", s.independence.passed ? "yes" : "no", s.independence.p_value)});
  page.table(t);
}

void validation_plot(report::Page& page, const RotorReport& r) {
  const Experiment& e = r.validation.experiments.front();
  const std::vector<double> t = times(e.y.size(), r.validation.period_s);
  page.plot({.title = "Validation data: measured speed and the simulation of lag and delay",
             .y_label = "speed [rad/s]",
             .series = {series("measured", t, e.y),
                        series("lag and delay", t, simulated(r.result.motor, r.validation.period_s, e))}});
}

void response_plots(report::Page& page, const RotorReport& r) {
  const double T = r.validation.period_s;
  const MotorDynamics& m = r.result.motor;
  const auto count = static_cast<Eigen::Index>(std::min(2000.0, std::ceil((6 * m.lag() + m.delay) / T)));
  std::vector<report::Series> steps, magnitudes, phases;
  std::vector<double> decades;
  const double top = 0.5 / T;
  for (int k = 0; k <= 120; ++k) decades.push_back(std::log10(top) - 2.5 * (1 - k / 120.0));
  const auto add = [&](const std::string& name, double gain, const auto& at) {
    Eigen::VectorXd magnitude(static_cast<Eigen::Index>(decades.size())), phase = magnitude;
    double before = 0, turns = 0;
    for (std::size_t k = 0; k < decades.size(); ++k) {
      const std::complex<double> g = at(2 * kPi * std::pow(10.0, decades[k])) / gain;
      const double now = std::arg(g);
      if (k > 0 && now - before > kPi) turns -= 2 * kPi;
      if (k > 0 && now - before < -kPi) turns += 2 * kPi;
      before = now;
      magnitude[static_cast<Eigen::Index>(k)] = 20 * std::log10(std::abs(g));
      phase[static_cast<Eigen::Index>(k)] = to_degrees(now + turns);
    }
    magnitudes.push_back(series(name, decades, magnitude));
    phases.push_back(series(name, decades, phase));
  };
  for (const StructureResult& s : r.result.structures) {
    const PolynomialModel& model = s.candidate.fitted.model;
    const double gain = model.static_gain(0);
    steps.push_back(series(name_of(s.structure), times(count, T), model.step(0, count) / gain));
    add(name_of(s.structure), gain, [&](double w) { return model.response(0, w); });
  }
  add("lag and delay", m.gain[0], [&](double w) { return response(m, w); });
  page.plot({.title = "Step response, as a share of its end", .y_label = "share [1]", .series = steps});
  page.plot({.title = "Bode: magnitude over the gain at rest",
             .x_label = "frequency [log10 Hz]",
             .y_label = "magnitude [dB]",
             .series = magnitudes});
  page.plot({.title = "Bode: phase",
             .x_label = "frequency [log10 Hz]",
             .y_label = "phase [deg]",
             .series = phases});
}

void pole_and_residual_plots(report::Page& page, const RotorReport& r) {
  std::vector<report::Series> poles, correlations;
  for (const StructureResult& s : r.result.structures) {
    report::Series p{.name = name_of(s.structure), .points = true};
    for (const auto& pole : s.candidate.fitted.model.poles()) {
      p.x.push_back(pole.real());
      p.y.push_back(pole.imag());
    }
    poles.push_back(std::move(p));
    correlations.push_back(series(name_of(s.structure),
                                  times(s.whiteness.correlation.size(), r.validation.period_s),
                                  s.whiteness.correlation));
  }
  page.plot({.title = "Poles of the sampled models (stable inside the unit circle)",
             .x_label = "real part [1]",
             .y_label = "imaginary part [1]",
             .series = poles});
  page.plot({.title = fmt::format(
                 "Autocorrelation of residuals on the validation data; white ones stay within {:.3f}",
                 r.result.structures.front().whiteness.bound),
             .x_label = "lag [s]",
             .y_label = "correlation [1]",
             .series = correlations});
}

}  // namespace

nlohmann::json to_json(const MotorReport& report) {
  json rotors = json::array(), failed = json::array();
  for (const RotorReport& r : report.rotors) rotors.push_back(rotor_json(r, report.signals));
  for (const auto& [rotor, error] : report.failed)
    failed.push_back({{"rotor", rotor + 1}, {"reason", error.text()}});
  return {{"schema", "omniflight.motor/1"},
          {"recordings", report.recordings},
          {"sha256", report.sha256},
          {"held_out", report.held_out},
          {"command", {{"signal", report.signals.command}, {"unit", report.signals.unit}}},
          {"reference_V", report.signals.reference_V},
          {"period_s", report.signals.period_s},
          {"rotors", rotors},
          {"failed", failed}};
}

std::string to_text(const MotorReport& report) {
  std::string out = fmt::format(
      "command {} -> speed [rad/s], every {:.2f} ms{}\n", report.signals.command,
      1000 * report.signals.period_s,
      report.rotors.empty() ? ""
                            : fmt::format("; battery voltage: {}", name_of(report.rotors.front().voltage)));
  out += fmt::format("  {:>5} {:>16} {:>16} {:>16} {:>12}  {}\n", "rotor", "lag up [ms]", "lag down [ms]",
                     "delay [ms]", "held out [%]", "best structure [%]");
  const auto pm = [](double value, double sigma) {
    return fmt::format("{:.1f} +- {:.1f}", 1000 * value, 1960 * sigma);
  };
  for (const RotorReport& r : report.rotors) {
    const MotorDynamics& m = r.result.motor;
    const StructureResult& best = r.result.structures.front();
    out += fmt::format("  {:>5} {:>16} {:>16} {:>16} {:>12.1f}  {} {:.1f}\n", r.rotor + 1,
                       pm(m.lag_up, m.sigma_lag_up()), pm(m.lag_down, m.sigma_lag_down()),
                       pm(m.delay, m.sigma_delay()), r.result.validation_percent, name_of(best.structure),
                       best.candidate.validation_percent);
  }
  for (const auto& [rotor, error] : report.failed)
    out += fmt::format("  {:>5} {}\n", rotor + 1, error.text());
  if (!report.rotors.empty()) out += "  " + closed_loop_words(report.rotors.front().result);
  return out;
}

report::Page page_of(const MotorReport& report) {
  std::string files;
  for (const std::string& file : report.recordings) files += (files.empty() ? "" : ", ") + file;
  report::Page page("Motor identification", files);
  page.section("Motors");
  report::Table t;
  t.caption =
      "Lag of the speed behind its command while it rises and falls, after a delay; intervals of 95 %";
  t.columns = {{.name = "rotor"},
               {.name = "lag up", .unit = "ms"},
               {.name = "lag down", .unit = "ms"},
               {.name = "delay", .unit = "ms"},
               {.name = "gain", .unit = "rad/s per " + report.signals.unit},
               {.name = "fit, validation", .unit = "%"}};
  const auto pm = [](double value, double sigma) {
    return fmt::format("{:.2f} ± {:.2f}", 1000 * value, 1960 * sigma);
  };
  for (const RotorReport& r : report.rotors) {
    const MotorDynamics& m = r.result.motor;
    t.rows.push_back({static_cast<int>(r.rotor + 1), pm(m.lag_up, m.sigma_lag_up()),
                      pm(m.lag_down, m.sigma_lag_down()), pm(m.delay, m.sigma_delay()), m.gain[0],
                      r.result.validation_percent});
  }
  page.table(t);
  for (const auto& [rotor, error] : report.failed)
    page.paragraph(fmt::format("Rotor {} was not identified: {}", rotor + 1, error.text()));
  for (const RotorReport& r : report.rotors) {
    page.section(fmt::format("Rotor {}", r.rotor + 1));
    page.paragraph(closed_loop_words(r.result));
    page.paragraph(fmt::format("Battery voltage: {}.{}", name_of(r.voltage),
                               r.voltage == VoltageUse::product
                                   ? fmt::format(" Gains hold at {:.3g} V.", report.signals.reference_V)
                                   : ""));
    structure_table(page, r.result);
    validation_plot(page, r);
    page.details("Responses, poles and residuals", [&](report::Page& inner) {
      response_plots(inner, r);
      pole_and_residual_plots(inner, r);
    });
  }
  return page;
}

}  // namespace omniflight::cli
