#include "hypothesis.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "../discrepancy/patterns.hpp"
#include "../discrepancy/pulsations.hpp"
#include "../evidence/first_stage.hpp"
#include "../numerics/parallel.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::Effect;
using physics::ParameterPrior;

/// Expected number of effects that a vehicle file leaves out, and of phenomena that are in no library; with
/// the first, nothing at all has a prior probability of one half.
const double kExpectedEffects = std::log(2.0);
constexpr double kExpectedUnknown = 0.02;

/// Points at which shapes are tried: quantiles of their priors, a low-discrepancy set where there are
/// several.
int point_count(int shapes) {
  constexpr int kPoints[] = {1, 10, 24, 24};
  return kPoints[std::min(shapes, 3)];
}

/// Radical inverse (Halton 1960) of k in a prime base.
double halton(int k, int base) {
  double value = 0, digit = 1.0 / base;
  for (; k > 0; k /= base, digit /= base) value += digit * (k % base);
  return value;
}

/// Standard normal quantile (Acklam's rational approximation is not needed: bisection on erfc).
double normal_quantile(double p) {
  double low = -6, high = 6;
  for (int k = 0; k < 50; ++k) {
    const double mid = 0.5 * (low + high);
    (0.5 * std::erfc(-mid / std::sqrt(2.0)) < p ? low : high) = mid;
  }
  return 0.5 * (low + high);
}

/// Values at which each parameter of the drives is tried alone: what limits, steps and dead zones do is
/// nothing up to a value and all at once beyond.
std::vector<ShapePoint> drive_points(const RegressionProblem& problem, const Effect& effect) {
  const auto& parameters = effect.info().parameters;
  std::vector<double> neutral;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const ParameterPrior prior = problem.prior(effect, k);
    neutral.push_back(prior.value(std::clamp(prior.coordinate(parameters[k].neutral), -4.0, 4.0)));
  }
  std::vector<ShapePoint> out;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const ParameterPrior prior = problem.prior(effect, k);
    std::vector<double> tried{0.1, 0.2, 0.4, 0.8, 1.6};
    if (prior.law == ParameterPrior::Law::log_normal) tried = {-2.4, -1.6, -0.8, 0, 0.8, 1.6};
    if (prior.law == ParameterPrior::Law::normal)
      for (std::size_t i = 0; i < 5; ++i) tried.push_back(-tried[i]);
    for (const double u : tried) {
      ShapePoint at;
      at.theta = neutral;
      at.theta[k] = prior.value(u);
      out.push_back(std::move(at));
    }
  }
  return out;
}

std::vector<ShapePoint> shape_points(const RegressionProblem& problem, const Effect& effect) {
  if (is_of_drives(effect.info())) return drive_points(problem, effect);
  constexpr int kPrimes[] = {2, 3, 5, 7, 11, 13, 17, 19};
  const auto& parameters = effect.info().parameters;
  std::vector<std::size_t> shapes, amplitudes;
  ShapePoint rest;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const bool amplitude = physics::is_amplitude(parameters[k]);
    // an attachment shifts a lever by little: it is fitted from zero, and not tried on the grid
    const bool lever = parameters[k].name.starts_with("attachment_");
    if (amplitude || !lever) (amplitude ? amplitudes : shapes).push_back(k);
    rest.theta.push_back(parameters[k].neutral);
  }
  rest.amplitude = amplitudes;
  std::vector<ShapePoint> out;
  if (const auto telling = effect.telling_shapes(problem.situations()); !telling.empty()) {
    for (const std::vector<double>& theta : telling) {
      out.push_back(rest);
      out.back().theta = theta;
    }
    return out;
  }
  const int points = point_count(static_cast<int>(shapes.size()));
  for (int p = 0; p < points; ++p) {
    ShapePoint at = rest;
    for (std::size_t s = 0; s < shapes.size(); ++s) {
      const double q = shapes.size() == 1 ? (p + 0.5) / points : halton(p + 1, kPrimes[s % 8]);
      const ParameterPrior prior = problem.prior(effect, shapes[s]);
      at.theta[shapes[s]] = prior.value(normal_quantile(q));
    }
    out.push_back(std::move(at));
  }
  return out;
}

/// What one standard deviation of each amplitude does at these shapes; the whole wrench where there is none.
Eigen::MatrixXd amplitude_columns(const RegressionProblem& problem, const Effect& effect,
                                  const ShapePoint& at, States states) {
  Eigen::MatrixXd columns(problem.rows(), static_cast<Eigen::Index>(at.amplitude.size()));
  EffectTerm term{&effect, at.theta, {}};
  Eigen::VectorXd neutral, moved;
  if (at.amplitude.empty()) {
    problem.wrench_of(term, moved, nullptr, nullptr, states);
    return moved;
  }
  problem.wrench_of(term, neutral, nullptr, nullptr, states);
  for (std::size_t k = 0; k < at.amplitude.size(); ++k) {
    const std::size_t p = at.amplitude[k];
    const ParameterPrior prior = problem.prior(effect, p);
    term.theta[p] = prior.value(1);
    problem.wrench_of(term, moved, nullptr, nullptr, states);
    term.theta[p] = at.theta[p];
    columns.col(static_cast<Eigen::Index>(k)) = moved - neutral;
  }
  return columns;
}

/// The same of each initial state of a load of one standard deviation.
Eigen::MatrixXd start_columns(const RegressionProblem& problem, const Effect& effect, const ShapePoint& at) {
  const std::vector<double> spread = effect.start_spread(at.theta.data());
  if (spread.empty() || at.amplitude.empty()) return Eigen::MatrixXd(problem.rows(), 0);
  EffectTerm term{&effect, at.theta, {}};
  const std::size_t mass = at.amplitude.front();
  term.theta[mass] = problem.prior(effect, mass).value(1);
  Eigen::VectorXd moved;
  Eigen::MatrixXd by_start;
  problem.wrench_of(term, moved, nullptr, &by_start);
  Eigen::Index more = 0;
  for (const double s : spread) more += s > 0;
  const auto windows = static_cast<Eigen::Index>(problem.memory_windows().size());
  Eigen::MatrixXd columns(problem.rows(), more * windows);
  Eigen::Index next = 0;
  for (Eigen::Index k = 0; k < by_start.cols(); ++k) {
    const double s = spread[static_cast<std::size_t>(k) % spread.size()];
    if (s > 0) columns.col(next++) = s * by_start.col(k);
  }
  return columns;
}

/// Columns that never change, and their first stages.
void prepare_linear(const RegressionProblem& problem, const NoiseModel& noise, Hypothesis& h) {
  if (!has_constant_columns(*h.effect)) return;
  EffectTerm term{h.effect, {}, {}};
  for (const physics::Parameter& p : h.effect->info().parameters) term.theta.push_back(p.neutral);
  Eigen::VectorXd value;
  Eigen::MatrixXd columns;
  problem.wrench_of(term, value, &columns, nullptr);
  h.linear_amplitudes = cosine_amplitudes(problem, columns);
  problem.wrench_of(term, value, &columns, nullptr, States::measured);
  h.first_stage = first_stages(noise.scale(h.linear_amplitudes), noise.apply(columns));
}

/// Columns of all shapes and their first stages.
void prepare(const RegressionProblem& problem, const NoiseModel& noise, Hypothesis& h) {
  if (h.pattern) {
    auto p = std::make_shared<Pattern>(*h.pattern);
    p->amplitudes = cosine_amplitudes(problem, p->raw).cast<float>();
    h.pattern = std::move(p);
    return;
  }
  for (ShapePoint& at : h.points) {
    const Eigen::MatrixXd own =
        cosine_amplitudes(problem, amplitude_columns(problem, *h.effect, at, States::predicted));
    const Eigen::MatrixXd start = cosine_amplitudes(problem, start_columns(problem, *h.effect, at));
    at.first_stage = first_stages(noise.scale(own),
                                  noise.apply(amplitude_columns(problem, *h.effect, at, States::measured)));
    at.amplitudes.resize(own.rows(), own.cols() + start.cols());
    at.amplitudes << own.cast<float>(), start.cast<float>();
  }
  prepare_linear(problem, noise, h);
}

void whiten_one(const NoiseModel& noise, Hypothesis& h) {
  if (h.pattern) {
    auto p = std::make_shared<Pattern>(*h.pattern);
    p->whitened = noise.scale(p->amplitudes);
    h.pattern = std::move(p);
    return;
  }
  for (ShapePoint& at : h.points) {
    at.columns = noise.scale(at.amplitudes);
    for (Eigen::Index k = 0; k < at.first_stage.size(); ++k) at.columns.col(k) *= at.first_stage[k];
  }
  if (h.is_linear()) h.linear = noise.scale(h.linear_amplitudes) * h.first_stage.asDiagonal();
}

}  // namespace

bool has_constant_columns(const Effect& effect) {
  return effect.memory_size().total() == 0 && !is_of_drives(effect.info()) &&
         std::all_of(effect.info().parameters.begin(), effect.info().parameters.end(),
                     [](const physics::Parameter& p) { return p.linear; });
}

std::vector<Hypothesis> make_hypotheses(const RegressionProblem& problem, const NoiseModel& noise,
                                        const std::vector<const Effect*>& effects, const Options& o) {
  std::vector<Hypothesis> out;
  // an effect of each rotor by itself shares the rate of the whole
  std::map<std::string, double> share;
  for (const Effect* e : effects) share[e->info().id] += 1;
  const auto occurrence = [&](const Effect& e) {
    return o.assumes(Assumption::occurrence) ? physics::occurrence(e.info()) : 1.0;
  };
  double total = 0;
  for (const Effect* e : effects) total += occurrence(*e) / share[e->info().id];
  for (const Effect* e : effects) {
    Hypothesis h;
    h.id = e->info().id;
    h.effect = e;
    const auto told = o.inclusion.find(h.id);
    const double odds = told == o.inclusion.end() ? kExpectedEffects * occurrence(*e) / total
                                                  : told->second / (1 - told->second);
    h.log_odds = std::log(odds / share[h.id]);
    h.points = shape_points(problem, *e);
    out.push_back(std::move(h));
  }
  std::vector<Pattern> patterns;
  std::vector<Pulsation> pulsations;
  if (o.assumes(Assumption::unknown_physics)) {
    patterns = make_patterns(problem);
    pulsations = make_pulsations(problem, noise);
  }
  const double each = kExpectedUnknown / static_cast<double>(patterns.size() + pulsations.size());
  const auto add_unknown = [&](Pattern&& p, double choices) {
    Hypothesis h;
    h.id = "unknown";
    h.pattern = std::make_shared<const Pattern>(std::move(p));
    h.log_choices = std::log(choices);
    h.log_odds = std::log(each) - h.log_choices;
    out.push_back(std::move(h));
  };
  for (Pattern& p : patterns) add_unknown(std::move(p), 1);
  // all frequencies are equally likely, and only the strongest is asked
  for (Pulsation& p : pulsations) add_unknown(std::move(p.pattern), p.distinct);
  parallel_for(out.size(), o.threads, [&](std::size_t k) { prepare(problem, noise, out[k]); });
  whiten(noise, o.threads, out);
  return out;
}

void prepare_again(const RegressionProblem& problem, const NoiseModel& noise, int threads,
                   std::vector<Hypothesis>& hypotheses) {
  parallel_for(hypotheses.size(), threads, [&](std::size_t k) {
    if (hypotheses[k].effect != nullptr) prepare(problem, noise, hypotheses[k]);
  });
}

Hypothesis without_grid(const Hypothesis& h) {
  Hypothesis out;
  out.id = h.id;
  out.effect = h.effect;
  out.pattern = h.pattern;
  out.log_odds = h.log_odds;
  out.first_stage = h.first_stage;
  out.linear_amplitudes = h.linear_amplitudes;
  return out;
}

Hypothesis without_grid(const Hypothesis& h, const RegressionProblem& problem, const NoiseModel& noise) {
  Hypothesis out;
  out.id = h.id;
  out.effect = h.effect;
  out.pattern = h.pattern;
  out.log_odds = h.log_odds;
  if (out.effect != nullptr) prepare_linear(problem, noise, out);
  whiten_one(noise, out);
  return out;
}

void whiten(const NoiseModel& noise, int threads, std::vector<Hypothesis>& hypotheses) {
  parallel_for(hypotheses.size(), threads, [&](std::size_t k) { whiten_one(noise, hypotheses[k]); });
}

}  // namespace omniflight::diagnosis
