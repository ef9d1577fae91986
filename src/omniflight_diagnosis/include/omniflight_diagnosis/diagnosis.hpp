// The diagnosis of a flight: where it differs from the model, which effects missing in the model explain
// that, and how much better the model predicts with them.
#pragma once

#include <map>
#include <optional>
#include <span>

#include "omniflight_diagnosis/flight.hpp"
#include "omniflight_physics/correction.hpp"

namespace omniflight::diagnosis {

/// checked: nothing was fitted. unfinished: stopped or out of time; there are no probabilities then.
enum class Verdict { nothing_missing, explained, ambiguous, unexplained, unusable, checked, unfinished };
std::string to_string(Verdict verdict);

/// One recording as it was given.
struct Input {
  std::string file, sha256;
  double duration_s = 0;
  std::vector<std::string> signals;
  std::vector<Window> excluded;
};

/// A channel in which flight and nominal model differ beyond noise.
struct Mismatch {
  physics::Stage stage = physics::Stage::wrench;
  std::string channel, frame, unit;
  std::vector<std::pair<double, double>> windows_s;  ///< in the first flight that shows it
  std::string where;  ///< for the reader: "grows with height above 0.62 m: -2.45 N per m"
  /// Wrench: posterior probability of the empty set. Drives: inverse Bayes factor, at most 1. Sensors:
  /// two-sided normal p-value of deviation over standard error. Faults and allocation: 0 (no noise). Control:
  /// 1e-6, a nominal value.
  double p_value = 1;
  double rms = 0, noise_rms = 0;        ///< in `unit`: of the nominal residual; of what no effect explains
  std::vector<std::string> recordings;  ///< files of a sensor mismatch; empty: over all fitted recordings
};

/// One effect that is missing in the model.
struct Finding {
  std::string effect;      ///< id of the library
  double probability = 0;  ///< posterior inclusion probability; NaN in an unfinished answer
  double log_factor = 0;   ///< ln Bayes factor where `parameters` do not give it
  /// The first `rivals` explain the flight equally well; the others nearly as well, or with more parameters.
  std::vector<std::string> cannot_be_told_apart_from;
  int rivals = 0;
  physics::Stage stage = physics::Stage::wrench;
  std::vector<std::string> channels;
  std::string sentence, equation, latex;
  std::vector<ParameterValue> parameters;  ///< of a sensor: from the first of `recordings`
  std::vector<std::string> recordings;     ///< files of a sensor finding; empty: fitted over all
};

/// Whether the flight informs the parameter: its 95 % interval is narrower than the range that the effect
/// allows.
bool identifiable(const std::string& effect, const ParameterValue& parameter);

/// One term of an empirical correction of a residual that no effect explains: coefficient * (v - mean(v)) for
/// the state variable v that `words` names, or a sinusoid.
struct CorrectionTerm {
  std::string words;                         ///< "climb speed times height"
  double coefficient = 0;                    ///< in `unit`; amplitude of a sinusoid
  std::string unit;                          ///< N or Nm per unit of v
  double frequency_hz = 0;                   ///< of a sinusoid, else 0
  std::optional<physics::Correction> model;  ///< as model.yaml lists it and the simulator flies it
};

/// A predictable part of the residual that no effect of the library explains.
struct Unexplained {
  physics::Stage stage = physics::Stage::wrench;
  std::string channel, unit, frame, parity, energy = "unknown", nearest;
  std::vector<std::string> depends_on;
  double share_of_residual = 0;
  std::vector<CorrectionTerm> correction;  ///< largest first; none of them is an effect of the library
};

/// Prediction error of one channel, without (before) and with (after) the findings.
struct ChannelFit {
  std::string recording;  ///< file that was predicted; empty: the fitted ones
  std::string channel, unit;
  double rms_before = 0, rms_after = 0;
  /// Coefficient of determination of the measured channel (mass or inertia times acceleration), its mean
  /// removed; negative where the model is worse than that mean. NaN in sample.
  double r2_before = std::nan(""), r2_after = std::nan("");
};
/// Open-loop prediction error after horizon_s, without and with the findings.
struct RolloutFit {
  double horizon_s = 0;
  std::string channel, unit;
  double rmse_before = 0, rmse_after = 0;
};
/// RMS of one quantity as recorded, and as simulated without and with the findings; NaN where not recorded.
struct ThreeFlights {
  double real = std::nan(""), simulated_before = std::nan(""), simulated_after = std::nan("");
};
/// One channel of the flight repeated in closed-loop simulation.
struct ClosedLoop {
  std::string channel, unit;
  double real = 0, simulated_before = 0, simulated_after = 0;  ///< RMS tracking error, in `unit`
  /// Integral action of the axis [m/s^2 or rad/s^2]. It compensates constant disturbances, which the tracking
  /// error therefore does not show.
  ThreeFlights integral = {};
};
/// Mean electrical power, recorded and simulated.
struct Power {
  double real_W = 0, simulated_before_W = 0, simulated_after_W = 0;
};
struct FitReport {
  std::vector<ChannelFit> in_sample, held_out;
  std::vector<RolloutFit> rollout;
  std::vector<ClosedLoop> closed_loop;  ///< set by the caller that simulates the closed loop
  Power power;                          ///< likewise
};

/// Residuals over the used samples, for plots of the report; not part of diagnosis.json.
struct Series {
  std::string file;
  std::vector<double> t_s, height_m;
  std::vector<std::string> channels;               ///< Fx ... Mz body, Fz_world
  std::vector<std::vector<double>> before, after;  ///< channels x samples [N, Nm]
};
/// How strongly the flight speaks for an effect by itself; not part of diagnosis.json.
struct CandidateGain {
  std::string effect;
  double gain = 0;    ///< ln Bayes factor of this effect alone against the nominal model
  double needed = 0;  ///< ln prior odds against it
};

struct ProposedWaypoint {
  Vec3 by = Vec3::Zero();       ///< m, world, displacement from the previous waypoint
  Vec3 rpy_deg = Vec3::Zero();  ///< deg, attitude there; ignored by underactuated vehicles
  double hold_s = 1;
  std::optional<double> alpha = {};  ///< rad, rotor tilt to assume there before holding
};

/// A flight predicted to discriminate between rival effects.
struct ProposedFlight {
  std::string name, words;
  Vec3 start = Vec3::Zero();                        ///< m, world; near the recorded flight
  double alpha = 0;                                 ///< rad, tilt of the rotors at the start
  double speed = 0.4, acceleration = 0.5;           ///< m/s, m/s^2: limits along the path
  double rate = 0.52, angular_acceleration = 1.57;  ///< rad/s, rad/s^2: limits
  std::vector<ProposedWaypoint> waypoints;
  std::vector<double> separations_sigma;  ///< predicted, of every pair in NextFlight::separates
  double separation_sigma = 0;            ///< the smallest of them
};

struct NextFlight {
  std::vector<std::pair<std::string, std::string>> separates;  ///< pairs of rivals
  std::vector<std::string> manoeuvres;                         ///< sentences from the effect library
  std::vector<ProposedFlight> proposed;   ///< best first; not checked against any test bed
  std::string mission;                    ///< file; set by the caller that checks and writes one of them
  double predicted_separation_sigma = 0;  ///< of the flight in `mission`
  /// Of the flight in `mission`, for the first pairs of `separates`; later pairs have no prediction.
  std::vector<double> separations_sigma;
};

/// Sentence listing the pairs that the chosen flight hardly separates, with predicted separations; "" if
/// none.
std::string stay_together(const NextFlight& next);

/// Sampling of one signal of a recording.
struct SignalInfo {
  std::string name, unit;
  int samples = 0;
  double rate_hz = 0, longest_gap_s = 0;
};
/// Range of one quantity during the flight: what the flight excites.
struct Excitation {
  std::string name, unit;
  double low = 0, high = 0, rms = 0;  ///< over the usable part
};
/// Expected signal-to-noise ratio of an effect at a typical size.
struct Detectability {
  std::string effect;
  double sigma = 0;  ///< norm of its whitened contribution
};
/// One statistic of a sensor, from its signal alone or from two redundant ones.
struct SensorFact {
  std::string signal, quantity, unit;
  double value = 0;
};
/// A signal that was not recorded, and which statements that prevents.
struct MissingSignal {
  std::string signal, costs;
};
/// Contents and consistency of one recording, before anything is fitted.
struct Intake {
  std::string recording;  ///< file
  std::vector<SignalInfo> signals;
  std::vector<SensorFact> sensors;
  std::vector<MissingSignal> missing;  ///< most informative first
  std::vector<Alignment> alignment;
  std::vector<Excitation> excitation;
  std::vector<Detectability> detectability;
  /// Effects with collinear whitened contributions on this flight (cosine above 0.98).
  std::vector<std::vector<std::string>> alias_groups;
  std::vector<std::string> notes;  ///< sentences on repairs and missing signals
};

/// One decision on the way to the answer: test, statistic, threshold and outcome.
struct Decision {
  std::string about, asked;
  double statistic = 0, threshold = 0;
  std::string source, outcome;
};
/// How regressors were kept apart from what feedback makes of disturbances.
struct EstimatorChoice {
  std::string name;  ///< "direct" or "instrumental"; empty: no wrench was inferred
  std::string reason;
};
/// A set of effects that was asked, by the ids of its members ("unknown: VARIABLE" of physics outside the
/// library).
struct RankedSet {
  std::vector<std::string> effects;
  /// ln of its evidence over that of nothing at all, and of its prior odds against it [nat]; its share of the
  /// posterior [1].
  double log_evidence = 0, log_prior = 0, probability = 0;
};
/// What the best model leaves of a channel.
struct Remaining {
  std::string channel, unit;
  /// RMS of the residual less lone samples; root of the noise spectrum near its highest frequencies,
  /// temperature included, both in `unit`; share of the power beyond that of such noise, which is still
  /// predictable [1].
  double rms = 0, noise_rms = 0, predictable_share = 0;
  /// Samples that have an impulse beside noise: blows, snatches, faults of a sensor. How many; the largest
  /// one, in `unit` over one sample of the grid, and when it was [s].
  int lone_samples = 0;
  double largest_lone_sample = 0, largest_at_s = 0;
};

struct Diagnosis {
  std::vector<Decision> decisions;
  EstimatorChoice estimator;
  std::vector<RankedSet> sets;       ///< the likeliest first
  std::vector<Remaining> remaining;  ///< every judged channel
  std::vector<Input> inputs;
  Verdict verdict = Verdict::nothing_missing;
  std::string summary;
  /// Posterior probability that nothing was left out of the wrench; NaN where that was not inferred.
  double probability_of_nothing = std::nan("");
  std::vector<Mismatch> mismatch;
  std::vector<Finding> findings;
  std::vector<Unexplained> unexplained;
  FitReport fit;
  NextFlight next_flight;
  Intake intake;                ///< of the first recording
  std::vector<Intake> further;  ///< of the others that are fitted
  /// What is missing in this answer and why: time limit, interrupt, no proposal that fits the test bed.
  std::vector<std::string> left_out;
  double runtime_s = 0;  ///< set by the caller

  std::vector<physics::ActiveEffect> model;    ///< effects at their estimates, as in model.yaml
  std::optional<ToldController> controller;    ///< estimated gains, where they differ from those told
  std::map<std::string, double> tracking_rms;  ///< RMS tracking error by axis ("px", ...) [m]
  std::vector<Series> series;
  std::vector<CandidateGain> candidates;
};

/// Diagnoses recordings of one vehicle. `fit` recordings are fitted together; `held_out` ones are only
/// predicted. Without `held_out`, each third of a single flight is predicted by a fit to the other two.
/// Recordings without the signals of a wrench analysis are judged by the balance of their motors, or by their
/// sensors alone (verdict unusable). When Options::stop returns true the verdict is unfinished. Errors: no
/// recording, or one that prepare_flight() refuses.
Result<Diagnosis> diagnose(std::span<const recording::Recording> fit,
                           std::span<const recording::Recording> held_out, const vehicle::Vehicle& vehicle,
                           const Options& options = {});

/// Intake of every recording without a fit: signals, rates, clocks, excitation, sensor faults, and which
/// effects the flight could show or distinguish. Takes seconds. findings holds sensor faults only; the
/// verdict is checked, or unusable when at least one recording is (the summary names it). Errors: as
/// diagnose().
Result<Diagnosis> check(std::span<const recording::Recording> recordings, const vehicle::Vehicle& vehicle,
                        const Options& options = {});

/// Turns an answer that was stopped into an unfinished one: probabilities become NaN, left_out lists what is
/// open.
void mark_unfinished(Diagnosis& diagnosis);

/// diagnosis.json, schema omniflight.diagnosis/1, pretty-printed.
std::string to_json(const Diagnosis& diagnosis);

/// Text of model.yaml (schema omniflight.model/1), which the simulator loads as it stands.
std::string model_yaml(const Diagnosis& diagnosis);

}  // namespace omniflight::diagnosis
