// Where a flight and the model differ, which left-out physics explains it, and how much better the model is
// with it.
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

struct Input {
  std::string file, sha256;
  double duration_s = 0;
  std::vector<std::string> signals;
  std::vector<Window> excluded;
};

struct Mismatch {
  physics::Stage stage = physics::Stage::wrench;
  std::string channel, frame, unit;
  std::vector<std::pair<double, double>> windows_s;  ///< of the first flight in which it is seen
  std::string where;                                 ///< "grows with height above 0.62 m: -2.45 N per m"
  double p_value = 1;             ///< holds for coloured noise; 0 where two computed numbers are compared
  double rms = 0, noise_rms = 0;  ///< before, and what no term explains
  std::vector<std::string> recordings;  ///< files in which a sensor shows it; empty: fitted over all
};

struct Finding {
  std::string effect;
  double probability = 0;  ///< not a number in an unfinished answer
  double log_factor = 0;   ///< ln Bayes factor, where it is not one of the parameters' sizes
  /// The first `rivals` explain the flight as well; the others look nearly the same but need more numbers, or
  /// explain it a little worse.
  std::vector<std::string> cannot_be_told_apart_from;
  int rivals = 0;
  physics::Stage stage = physics::Stage::wrench;
  std::vector<std::string> channels;
  std::string sentence, equation, latex;
  std::vector<ParameterValue> parameters;  ///< of a sensor: in the first of `recordings`
  std::vector<std::string> recordings;     ///< files in which a sensor shows it; empty: fitted over all
};

/// Whether the flight bounds the parameter: its 95 % interval is not the whole range that the effect allows.
bool identifiable(const std::string& effect, const ParameterValue& parameter);

/// A term of the smallest correction that predicts what no effect explains: coefficient * (words - its mean).
struct CorrectionTerm {
  std::string words;                         ///< "climb speed times height"
  double coefficient = 0;                    ///< in `unit`; of what pulsates, its amplitude
  std::string unit;                          ///< N or Nm per unit of the words
  double frequency_hz = 0;                   ///< of what pulsates, else 0
  std::optional<physics::Correction> model;  ///< as model.yaml lists it and the simulator flies it
};

struct Unexplained {
  physics::Stage stage = physics::Stage::wrench;
  std::string channel, unit, frame, parity, energy = "unknown", nearest;
  std::vector<std::string> depends_on;
  double share_of_residual = 0;
  std::vector<CorrectionTerm> correction;  ///< the strongest first; never a named effect
};

struct ChannelFit {
  std::string recording;  ///< file; empty in sample
  std::string channel, unit;
  double rms_before = 0, rms_after = 0;
  /// Share of the variance of the measured channel (mass or inertia times acceleration) that the model
  /// explains, a constant apart; negative where it does worse than none. Not a number in sample.
  double r2_before = std::nan(""), r2_after = std::nan("");
};
struct RolloutFit {
  double horizon_s = 0;
  std::string channel, unit;
  double rmse_before = 0, rmse_after = 0;
};
/// RMS of one quantity in three flights; not a number where nobody recorded it.
struct ThreeFlights {
  double real = std::nan(""), simulated_before = std::nan(""), simulated_after = std::nan("");
};
struct ClosedLoop {
  std::string channel, unit;
  double real = 0, simulated_before = 0, simulated_after = 0;  ///< RMSE of the tracking
  /// Integral action of the axis [m/s^2 or rad/s^2]: it carries what integration hides from the tracking.
  ThreeFlights integral = {};
};
struct Power {
  double real_W = 0, simulated_before_W = 0, simulated_after_W = 0;
};
struct FitReport {
  std::vector<ChannelFit> in_sample, held_out;
  std::vector<RolloutFit> rollout;
  std::vector<ClosedLoop> closed_loop;  ///< filled by whoever re-flies the model
  Power power;                          ///< likewise
};

/// For plots and tables of the report; not part of diagnosis.json.
struct Series {
  std::string file;
  std::vector<double> t_s, height_m;
  std::vector<std::string> channels;               ///< Fx ... Mz body, Fz_world
  std::vector<std::vector<double>> before, after;  ///< a channel, NaN where cut out
};
struct CandidateGain {
  std::string effect;
  double gain = 0;    ///< ln Bayes factor alone, against nothing
  double needed = 0;  ///< ln prior odds against it
};

struct ProposedWaypoint {
  Vec3 by = Vec3::Zero();       ///< m, from the waypoint before
  Vec3 rpy_deg = Vec3::Zero();  ///< deg, attitude there; ignored by a vehicle that must lean to move
  double hold_s = 1;
  std::optional<double> alpha = {};  ///< rad, tilt of the rotors to move to there, before holding
};

/// A flight that would tell rivals apart.
struct ProposedFlight {
  std::string name, words;
  Vec3 start = Vec3::Zero();                        ///< m, world: about where the flight was
  double alpha = 0;                                 ///< rad, tilt of the rotors at the start
  double speed = 0.4, acceleration = 0.5;           ///< m/s, m/s^2: limits
  double rate = 0.52, angular_acceleration = 1.57;  ///< rad/s, rad/s^2: limits
  std::vector<ProposedWaypoint> waypoints;
  std::vector<double> separations_sigma;  ///< predicted, of every pair in NextFlight::separates
  double separation_sigma = 0;            ///< of the pair that stays closest
};

struct NextFlight {
  std::vector<std::pair<std::string, std::string>> separates;
  std::vector<std::string> manoeuvres;    ///< in words, from the effect library
  std::vector<ProposedFlight> proposed;   ///< best first; not yet checked for any place
  std::string mission;                    ///< file, set by whoever writes and checks one of them
  double predicted_separation_sigma = 0;  ///< of that one
  std::vector<double>
      separations_sigma;  ///< of that one, a pair of `separates` (further pairs: no prediction)
};

/// The pairs that the chosen flight would hardly tell apart, with their predicted separations; "" when none.
std::string stay_together(const NextFlight& next);

/// What a recording holds and how its parts agree, before anything is fitted.
struct SignalInfo {
  std::string name, unit;
  int samples = 0;
  double rate_hz = 0, longest_gap_s = 0;
};
struct Excitation {
  std::string name, unit;
  double low = 0, high = 0, rms = 0;  ///< over the usable part
};
struct Detectability {
  std::string effect;
  double sigma = 0;  ///< length of its contribution at an ordinary size, in units of the noise
};
/// A number that a signal alone, or two that tell of one thing, give about the sensors.
struct SensorFact {
  std::string signal, quantity, unit;
  double value = 0;
};
/// What cannot be said for want of a signal.
struct MissingSignal {
  std::string signal, costs;
};
/// Of one recording.
struct Intake {
  std::string recording;  ///< file
  std::vector<SignalInfo> signals;
  std::vector<SensorFact> sensors;
  std::vector<MissingSignal> missing;  ///< the one that would tell most first
  std::vector<Alignment> alignment;
  std::vector<Excitation> excitation;
  std::vector<Detectability> detectability;
  std::vector<std::vector<std::string>>
      alias_groups;                ///< effects that look alike on this flight (cosine > 0.98)
  std::vector<std::string> notes;  ///< what missing signals cost
};

/// One question that was asked on the way to the answer, and what came of it.
struct Decision {
  std::string about, asked;
  double statistic = 0, threshold = 0;
  std::string source, outcome;
};
/// What the best model leaves of a channel.
struct Remaining {
  std::string channel, unit;
  double rms = 0, noise_rms = 0, predictable_share = 0;
};

struct Diagnosis {
  std::vector<Decision> decisions;
  std::vector<Remaining> remaining;  ///< every judged channel
  std::vector<Input> inputs;
  Verdict verdict = Verdict::nothing_missing;
  std::string summary;
  std::vector<Mismatch> mismatch;
  std::vector<Finding> findings;
  std::vector<Unexplained> unexplained;
  FitReport fit;
  NextFlight next_flight;
  Intake intake;                ///< of the first recording
  std::vector<Intake> further;  ///< of the others that are fitted
  /// What the answer does without, and why: time, an interrupt, a proposal that fits nowhere.
  std::vector<std::string> left_out;
  double runtime_s = 0;  ///< set by the caller

  std::vector<physics::ActiveEffect> model;    ///< effects with values: what model.yaml lists
  std::optional<ToldController> controller;    ///< gains as flown, where they are not those told
  std::map<std::string, double> tracking_rms;  ///< "px" [m] ...: shows how blind the tracking error is
  std::vector<Series> series;
  std::vector<CandidateGain> candidates;
};

/// Locates, names, models. `fit` recordings are fitted together; `held_out` ones are only predicted. With no
/// held-out recording the last third of a single flight is held out as a block, and named so. Recordings that
/// lack what a wrench needs are judged by what they have: the balance of the motors, or the sensors alone,
/// and then the verdict is unusable. Once Options::stop has said so, the verdict is unfinished. Errors: no
/// recording, or one that prepare_flight refuses.
Result<Diagnosis> diagnose(std::span<const recording::Recording> fit,
                           std::span<const recording::Recording> held_out, const vehicle::Vehicle& vehicle,
                           const Options& options = {});

/// Only looks: signals, rates, clocks, excitation, faults, and which effects this flight could show or tell
/// apart, of every recording. Takes seconds; fits nothing. findings holds sensor faults only; verdict is
/// unusable (of one recording at least, which the summary names) or checked.
Result<Diagnosis> check(std::span<const recording::Recording> recordings, const vehicle::Vehicle& vehicle,
                        const Options& options = {});

/// Makes an answer that was stopped an unfinished one: no probabilities, and what is still open in left_out.
void mark_unfinished(Diagnosis& diagnosis);

/// diagnosis.json, schema omniflight.diagnosis/1, pretty-printed.
std::string to_json(const Diagnosis& diagnosis);

/// Text of model.yaml (schema omniflight.model/1), which the simulator loads as it stands.
std::string model_yaml(const Diagnosis& diagnosis);

}  // namespace omniflight::diagnosis
