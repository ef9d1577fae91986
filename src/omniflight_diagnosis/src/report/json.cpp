// diagnosis.json, schema omniflight.diagnosis/1.
#include <cmath>
#include <nlohmann/json.hpp>

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

/// A number, or null where it is not finite.
Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json inputs(const Diagnosis& d) {
  Json out = Json::array();
  for (const Input& in : d.inputs) {
    Json windows = Json::array();
    for (const Window& w : in.excluded)
      windows.push_back({{"from_s", number(w.from_s)}, {"to_s", number(w.to_s)}, {"why", w.why}});
    out.push_back({{"file", in.file},
                   {"sha256", in.sha256},
                   {"duration_s", number(in.duration_s)},
                   {"signals", in.signals},
                   {"excluded_windows", windows}});
  }
  return out;
}

Json mismatches(const Diagnosis& d) {
  Json out = Json::array();
  for (const Mismatch& m : d.mismatch) {
    Json windows = Json::array();
    for (const auto& [from, to] : m.windows_s) windows.push_back({number(from), number(to)});
    out.push_back({{"stage", to_string(m.stage)},
                   {"channel", m.channel},
                   {"frame", m.frame},
                   {"unit", m.unit},
                   {"windows_s", windows},
                   {"where", m.where},
                   {"p_value", number(m.p_value)},
                   {"rms", number(m.rms)},
                   {"noise_rms", number(m.noise_rms)},
                   {"recordings", m.recordings}});
  }
  return out;
}

Json findings(const Diagnosis& d) {
  Json out = Json::array();
  for (const Finding& f : d.findings) {
    Json parameters = Json::array();
    for (const ParameterValue& p : f.parameters)
      parameters.push_back({{"name", p.name},
                            {"symbol", p.symbol},
                            {"value", number(p.value)},
                            {"unit", p.unit},
                            {"identifiable", identifiable(f.effect, p)},
                            {"interval95", {number(p.low), number(p.high)}}});
    out.push_back({{"effect", f.effect},
                   {"probability", number(f.probability)},
                   {"cannot_be_told_apart_from", f.cannot_be_told_apart_from},
                   {"stage", to_string(f.stage)},
                   {"channels", f.channels},
                   {"sentence", f.sentence},
                   {"equation", f.equation},
                   {"parameters", parameters},
                   {"recordings", f.recordings}});
  }
  return out;
}

Json unexplained(const Diagnosis& d) {
  Json out = Json::array();
  for (const Unexplained& u : d.unexplained) {
    Json correction = Json::array();
    for (const CorrectionTerm& t : u.correction)
      correction.push_back({{"term", t.words},
                            {"coefficient", number(t.coefficient)},
                            {"unit", t.unit},
                            {"frequency_hz", number(t.frequency_hz)}});
    out.push_back({{"stage", to_string(u.stage)},
                   {"channel", u.channel},
                   {"unit", u.unit},
                   {"depends_on", u.depends_on},
                   {"frame", u.frame},
                   {"parity", u.parity},
                   {"energy", u.energy},
                   {"share_of_residual", number(u.share_of_residual)},
                   {"nearest", u.nearest},
                   {"correction", correction}});
  }
  return out;
}

Json fit_report(const FitReport& f) {
  const auto channels = [](const std::vector<ChannelFit>& list, bool named) {
    Json out = Json::array();
    for (const ChannelFit& c : list) {
      Json j;
      if (named) j["recording"] = c.recording;
      j["channel"] = c.channel;
      j["unit"] = c.unit;
      j["rms_before"] = number(c.rms_before);
      j["rms_after"] = number(c.rms_after);
      if (named) j["r2_before"] = number(c.r2_before), j["r2_after"] = number(c.r2_after);
      out.push_back(j);
    }
    return out;
  };
  Json rollout = Json::array(), closed = Json::array();
  for (const RolloutFit& r : f.rollout)
    rollout.push_back({{"horizon_s", r.horizon_s},
                       {"channel", r.channel},
                       {"unit", r.unit},
                       {"rmse_before", number(r.rmse_before)},
                       {"rmse_after", number(r.rmse_after)}});
  for (const ClosedLoop& c : f.closed_loop)
    closed.push_back({{"channel", c.channel},
                      {"unit", c.unit},
                      {"real", number(c.real)},
                      {"simulated_before", number(c.simulated_before)},
                      {"simulated_after", number(c.simulated_after)},
                      {"integral",
                       {{"unit", c.unit == "m" ? "m/s2" : "rad/s2"},
                        {"real", number(c.integral.real)},
                        {"simulated_before", number(c.integral.simulated_before)},
                        {"simulated_after", number(c.integral.simulated_after)},
                        {"ratio_before", number(c.integral.real / c.integral.simulated_before)},
                        {"ratio_after", number(c.integral.real / c.integral.simulated_after)}}}});
  return {{"in_sample", channels(f.in_sample, false)},
          {"held_out", channels(f.held_out, true)},
          {"rollout", rollout},
          {"closed_loop", closed},
          {"power",
           {{"real_W", number(f.power.real_W)},
            {"simulated_before_W", number(f.power.simulated_before_W)},
            {"simulated_after_W", number(f.power.simulated_after_W)}}}};
}

Json intake(const Intake& in) {
  Json signals = Json::array(), alignment = Json::array(), excitation = Json::array(), detect = Json::array(),
       sensors = Json::array(), missing = Json::array();
  for (const SignalInfo& s : in.signals)
    signals.push_back({{"name", s.name},
                       {"unit", s.unit},
                       {"samples", s.samples},
                       {"rate_hz", number(s.rate_hz)},
                       {"longest_gap_s", number(s.longest_gap_s)}});
  for (const Alignment& a : in.alignment)
    alignment.push_back({{"early", a.early},
                         {"late", a.late},
                         {"lag_s", number(a.lag_s)},
                         {"lag_standard_error_s", number(a.lag_se)},
                         {"skew", number(a.skew)},
                         {"skew_standard_error", number(a.skew_se)},
                         {"correlation", number(a.correlation)}});
  for (const Excitation& e : in.excitation)
    excitation.push_back({{"name", e.name},
                          {"unit", e.unit},
                          {"low", number(e.low)},
                          {"high", number(e.high)},
                          {"rms", number(e.rms)}});
  for (const Detectability& x : in.detectability)
    detect.push_back({{"effect", x.effect}, {"sigma_at_ordinary_size", number(x.sigma)}});
  for (const SensorFact& x : in.sensors)
    sensors.push_back(
        {{"signal", x.signal}, {"quantity", x.quantity}, {"value", number(x.value)}, {"unit", x.unit}});
  for (const MissingSignal& x : in.missing) missing.push_back({{"signal", x.signal}, {"costs", x.costs}});
  return {{"recording", in.recording}, {"signals", signals},
          {"sensors", sensors},        {"missing", missing},
          {"alignment", alignment},    {"excitation", excitation},
          {"detectability", detect},   {"alias_groups", in.alias_groups},
          {"notes", in.notes}};
}

Json decisions(const Diagnosis& d) {
  Json out = Json::array();
  for (const Decision& x : d.decisions)
    out.push_back({{"about", x.about},
                   {"asked", x.asked},
                   {"statistic", number(x.statistic)},
                   {"threshold", number(x.threshold)},
                   {"source", x.source},
                   {"outcome", x.outcome}});
  return out;
}

Json remaining(const Diagnosis& d) {
  Json out = Json::array();
  for (const Remaining& x : d.remaining)
    out.push_back({{"channel", x.channel},
                   {"unit", x.unit},
                   {"rms", number(x.rms)},
                   {"noise_rms", number(x.noise_rms)},
                   {"predictable_share", number(x.predictable_share)},
                   {"lone_samples", x.lone_samples},
                   {"largest_lone_sample", number(x.largest_lone_sample)},
                   {"largest_at_s", number(x.largest_at_s)}});
  return out;
}

Json sets(const Diagnosis& d) {
  Json out = Json::array();
  for (const RankedSet& x : d.sets)
    out.push_back({{"effects", x.effects},
                   {"log_evidence_over_nothing", number(x.log_evidence)},
                   {"log_prior", number(x.log_prior)},
                   {"probability", number(x.probability)}});
  return out;
}

/// The first recording's, and those of the others in a list of their own.
Json intakes(const Diagnosis& d) {
  Json out = intake(d.intake), further = Json::array();
  for (const Intake& in : d.further) further.push_back(intake(in));
  out["further"] = further;
  return out;
}

}  // namespace

std::string to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::nothing_missing:
      return "nothing_missing";
    case Verdict::explained:
      return "explained";
    case Verdict::ambiguous:
      return "ambiguous";
    case Verdict::unexplained:
      return "unexplained";
    case Verdict::unusable:
      return "unusable";
    case Verdict::checked:
      return "checked";
    case Verdict::unfinished:
      return "unfinished";
  }
  return "unusable";
}

std::string to_json(const Diagnosis& d) {
  Json separates = Json::array(), separations = Json::array();
  for (const auto& [a, b] : d.next_flight.separates) separates.push_back({a, b});
  for (const double sigma : d.next_flight.separations_sigma) separations.push_back(number(sigma));
  const Json out{
      {"schema", "omniflight.diagnosis/1"},
      {"inputs", inputs(d)},
      {"verdict", to_string(d.verdict)},
      {"summary", d.summary},
      {"probability_of_nothing", number(d.probability_of_nothing)},
      {"mismatch", mismatches(d)},
      {"findings", findings(d)},
      {"unexplained", unexplained(d)},
      {"fit", fit_report(d.fit)},
      {"next_flight",
       {{"mission", d.next_flight.mission},
        {"separates", separates},
        {"manoeuvres", d.next_flight.manoeuvres},
        {"separations_sigma", separations},
        {"predicted_separation_sigma",
         d.next_flight.mission.empty() ? Json(nullptr) : number(d.next_flight.predicted_separation_sigma)}}},
      {"intake", intakes(d)},
      {"decisions", decisions(d)},
      {"estimator", d.estimator.name.empty()
                        ? Json(nullptr)
                        : Json{{"name", d.estimator.name}, {"reason", d.estimator.reason}}},
      {"sets", sets(d)},
      {"remaining", remaining(d)},
      {"left_out", d.left_out},
      {"runtime_s", number(d.runtime_s)}};
  return out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string model_yaml(const Diagnosis& d) {
  return physics::model_yaml(d.model,
                             "Effects that the diagnosis found; the simulator loads this file as it stands.");
}

}  // namespace omniflight::diagnosis
