#include "omniflight_identification/identify_rotor.hpp"

#include <algorithm>

namespace omniflight::identification {
namespace {

constexpr Eigen::Index kFewestWhite = 500;  // samples; a shorter white part is no test signal
constexpr double kFollowed = 0.1;           // share of a bit's step that a motor must follow

std::string milliseconds(double s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f ms", 1000 * s);
  return text;
}

Status within_band(const std::optional<WhitePart>& prbs, const MotorDynamics& motor, double period_s) {
  if (!prbs) return {};
  const double bit_s = prbs->bit_samples * period_s, followed = followed_share(bit_s, motor.lag());
  if (followed >= kFollowed) return {};
  return bad_input("its bits last " + milliseconds(bit_s) + ", of which a motor with a lag of " +
                       milliseconds(motor.lag()) + " follows " +
                       std::to_string(static_cast<int>(100 * followed)) +
                       " %: the signal lies beyond the motor's band",
                   "PRBS, command",
                   "Make one with a band of at most " + std::to_string(0.443 / (0.25 * motor.lag())) + " Hz");
}

/// Every experiment whose command is a PRBS cut to the white part of it; the white part of the first.
std::optional<WhitePart> keep_white(Dataset& data) {
  std::optional<WhitePart> first;
  for (std::size_t k = 0; k < data.experiments.size(); ++k) {
    Experiment& e = data.experiments[k];
    const auto part = white_part(e.u.col(0));
    if (k == 0) first = part;
    if (!part || part->to - part->from < kFewestWhite) continue;
    e = Experiment{e.y.segment(part->from, part->to - part->from),
                   e.u.middleRows(part->from, part->to - part->from)};
  }
  return first;
}

}  // namespace

Result<RotorResult> identify_rotor(const Dataset& estimation, const Dataset& validation,
                                   const RotorOptions& options) {
  if (auto ok = check(estimation); !ok) return Failure(ok.error());
  if (auto ok = check(validation); !ok) return Failure(ok.error());
  RotorResult out;
  Dataset fit_on = estimation;
  out.prbs = keep_white(fit_on);
  const double T = estimation.period_s;
  FitOptions fit_options;
  fit_options.transient_samples = static_cast<Eigen::Index>(std::ceil(options.transient_s / T));
  fit_options.stop = options.stop;
  auto motor = fit_dynamics(fit_on, {.max_delay_s = 2 * options.max_delay_s,
                                     .transient_samples = fit_options.transient_samples,
                                     .stop = options.stop});
  if (!motor) {
    Error error = motor.error();
    if (out.prbs)
      error.next_step += ". The command is a PRBS with bits of " + milliseconds(out.prbs->bit_samples * T) +
                         "; longer ones may be what the motor can follow";
    return Failure(error);
  }
  out.motor = std::move(*motor);
  if (auto ok = within_band(out.prbs, out.motor, T); !ok) return Failure(ok.error());
  out.validation_percent = fit_percent(out.motor, validation);

  const Dataset first = detrended(fit_on, options.trend), second = detrended(validation, options.trend);
  const int most = std::max(2, static_cast<int>(std::ceil(options.max_delay_s / T)));
  auto delay = estimate_delay(first, std::min(most, 60), fit_options);
  if (!delay) return Failure(delay.error());
  out.delay = std::move(*delay);
  SelectionOptions selection;
  selection.max_order = options.max_order;
  selection.fit = fit_options;
  for (const Structure structure : all_structures()) {
    auto chosen = select(structure, first, second, out.delay.samples, selection);
    if (!chosen) {
      out.failed.push_back(chosen.error());
      continue;
    }
    StructureResult result;
    result.structure = structure;
    result.candidate = std::move(*chosen);
    const PolynomialModel& model = result.candidate.fitted.model;
    if (auto continuous = continuous_equivalent(model, 0)) result.continuous = *continuous;
    result.whiteness = whiteness(model, second, fit_options);
    result.independence = independence(model, second, 0, fit_options);
    out.structures.push_back(std::move(result));
  }
  if (options.stop && options.stop())
    return fail(ErrorCode::incomplete, "was stopped before every structure was tried", "identification",
                "Give more time, fewer logs or a lower order");
  if (out.structures.empty()) return Failure(out.failed.back());
  std::stable_sort(out.structures.begin(), out.structures.end(), [](const auto& a, const auto& b) {
    return a.candidate.validation_percent > b.candidate.validation_percent;
  });
  out.feedback = feedback(out.structures.front().candidate.fitted.model, second, 0, fit_options);
  return out;
}

std::string closed_loop_words(const RotorResult& result) {
  if (result.feedback.passed)
    return "No feedback from speed to command shows in the residuals, so that a bias by it (direct method) "
           "is small "
           "beside the intervals. A controller that flies the vehicle still closes a loop around its motion.";
  std::string words =
      "The command follows the measured motion (closed loop; residuals correlate with later commands). "
      "Models are "
      "fitted by the direct method: consistent only where the noise model is right (ARMAX, Box-Jenkins, "
      "state space); "
      "Output-Error and the lag with delay carry a bias that grows with the share of the command that is "
      "fed-back "
      "noise.";
  const StructureResult* with_noise = nullptr;
  const StructureResult* without = nullptr;
  for (const StructureResult& s : result.structures) {
    if (s.structure == Structure::box_jenkins) with_noise = &s;
    if (s.structure == Structure::output_error) without = &s;
  }
  if (with_noise != nullptr && without != nullptr && with_noise->continuous && without->continuous)
    words += " Here Box-Jenkins and Output-Error differ by " +
             milliseconds(std::abs(with_noise->continuous->lag_s + with_noise->continuous->delay_s -
                                   without->continuous->lag_s - without->continuous->delay_s)) +
             " in lag and delay together: a measure of that bias.";
  return words;
}

}  // namespace omniflight::identification
