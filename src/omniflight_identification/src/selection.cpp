#include "omniflight_identification/selection.hpp"

#include <algorithm>

#include "prediction_error.hpp"
#include "starts.hpp"

namespace omniflight::identification {
namespace {

constexpr int kBeyond = 8;  // samples past the best delay so far after which no better one is expected

std::vector<int> delays(Eigen::Index inputs, int first) {
  std::vector<int> out(static_cast<std::size_t>(inputs), 1);
  out[0] = first;
  return out;
}

}  // namespace

Result<DelayEstimate> estimate_delay(const Dataset& data, int most, const FitOptions& options) {
  DelayEstimate out;
  double least = std::numeric_limits<double>::infinity();
  Error last{ErrorCode::incomplete, "was stopped before the first delay was tried", "delay",
             "Give more time"};
  for (int delay = 1; delay <= most; ++delay) {
    if ((options.stop && options.stop()) || delay > out.samples + kBeyond) break;
    const auto fitted =
        fit(Structure::output_error, orders_of(Structure::output_error, 1, 0, delays(data.inputs(), delay)),
            data, options);
    if (!fitted) last = fitted.error();
    out.loss.push_back(fitted ? fitted->variance : std::numeric_limits<double>::infinity());
    if (out.loss.back() < least) {
      least = out.loss.back();
      out.samples = delay;
    }
  }
  if (!std::isfinite(least)) return Failure(last);
  return out;
}

Result<Candidate> select(Structure structure, const Dataset& estimation, const Dataset& validation, int delay,
                         const SelectionOptions& options) {
  if (auto ok = check(validation); !ok) return Failure(ok.error());
  std::vector<Candidate> candidates;
  Error last{ErrorCode::incomplete, "was stopped before the first model was fitted", name_of(structure),
             "Give more time"};
  const auto attempt = [&](int order, int zeros, int d) {
    if (d < 1 || (options.fit.stop && options.fit.stop())) return;
    auto fitted = fit(structure, orders_of(structure, order, zeros, delays(estimation.inputs(), d)),
                      estimation, options.fit);
    if (fitted && !fitted->converged)
      last = {ErrorCode::incomplete, "the search did not converge", name_of(structure),
              "Give more time, or choose lower orders"};
    else if (!fitted)
      last = fitted.error();
    if (!fitted || !fitted->converged) return;
    Candidate c;
    c.validation_percent = fit_percent(fitted->model, validation);
    c.estimation_percent = fit_percent(fitted->model, estimation);
    c.order = order;
    c.zeros = zeros;
    c.fitted = std::move(*fitted);
    if (std::isfinite(c.validation_percent)) candidates.push_back(std::move(c));
  };
  for (int order = 1; order <= options.max_order; ++order)
    for (int zeros = 0; zeros < (structure == Structure::state_space ? 1 : order); ++zeros)
      attempt(order, zeros, delay);
  if (!candidates.empty()) {  // other delays for the best of these
    const Candidate best = *std::max_element(
        candidates.begin(), candidates.end(),
        [](const auto& a, const auto& b) { return a.validation_percent < b.validation_percent; });
    for (int d = delay - options.delay_spread; d <= delay + options.delay_spread; ++d)
      if (d != delay) attempt(best.order, best.zeros, d);
  }
  if (candidates.empty()) return Failure(last);
  double best = candidates.front().validation_percent;
  for (const Candidate& c : candidates) best = std::max(best, c.validation_percent);
  const auto size = [&](const Candidate& c) { return c.fitted.model.orders().count(estimation.inputs()); };
  const Candidate* chosen = nullptr;
  for (const Candidate& c : candidates) {
    if (c.validation_percent < best - options.worth_percent) continue;
    if (chosen == nullptr || size(c) < size(*chosen) ||
        (size(c) == size(*chosen) && c.validation_percent > chosen->validation_percent))
      chosen = &c;
  }
  return *chosen;
}

}  // namespace omniflight::identification
