#include "null_flights.hpp"

#include <algorithm>
#include <cmath>

#include "locate.hpp"

namespace omniflight::diagnosis {
namespace {

/// Distance of `value` from a few draws in their standard deviations; `least` is the smallest deviation that
/// can be believed. Small numbers widen it as they do a prediction.
double away(double value, const std::vector<double>& draws, double least) {
  const auto n = static_cast<double>(draws.size());
  double mean = 0, sum = 0;
  for (double x : draws) mean += x / n;
  for (double x : draws) sum += (x - mean) * (x - mean);
  const double spread = std::sqrt(sum / (n - 1) * (1 + 1 / n));
  return (value - mean) / std::max(spread, least);
}

}  // namespace

NullFlights::NullFlights(const Problem& problem, const Flight& flight, const vehicle::Vehicle& vehicle,
                         const Options& o) {
  Options quiet = o;
  quiet.refly = nullptr;
  for (int k = 0; k < o.reflights && !o.stopped(); ++k) {
    Random random(static_cast<std::uint64_t>(k + 1), "null flight");
    const Eigen::MatrixXd wrench = problem.noise().draw(random, flight.size());
    const auto flown = o.refly(wrench, flight.t.front(), flight.rate_hz, static_cast<std::uint64_t>(k + 1));
    if (!flown) break;
    auto prepared = prepare_flight(*flown, vehicle, quiet);
    if (prepared) flights_.push_back(std::move(*prepared));
  }
  for (const Flight& f : flights_) {
    const Flight* one[] = {&f};
    problems_.push_back(std::make_unique<const Problem>(one, vehicle, quiet));
  }
}

std::vector<double> NullFlights::standing_out(const Problem& problem, const Fit& model,
                                              const Options& o) const {
  std::vector<Fit> fits;
  for (const auto& p : problems_) fits.push_back(fit_effects(*p, model.effects, o));
  std::vector<double> out;
  for (std::size_t k = 0; k < model.effects.size(); ++k) {
    const auto whitened = [&](const physics::ActiveEffect& effect) {
      Fit one = model;
      one.effects[k] = effect;
      problem.predict(one.effects, one.offsets, one.residual, nullptr);
      return problem.noise().apply_vector(problem, contribution_of(problem, one, k));
    };
    const Eigen::VectorXd own = whitened(model.effects[k]);
    std::vector<double> draws;
    for (const Fit& f : fits) draws.push_back(own.dot(whitened(f.effects[k])) / own.squaredNorm());
    std::vector<physics::ActiveEffect> others = model.effects;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const double gain = std::max(0.5, model.log_likelihood - fit_effects(problem, others, o).log_likelihood);
    out.push_back(away(1.0, draws, 1 / std::sqrt(2 * gain)));
  }
  return out;
}

bool NullFlights::unexplained_stands_out(const Unexplained& found, const Options& o) const {
  std::vector<double> shares;
  for (const auto& p : problems_) {
    double share = 0;
    for (const Unexplained& u : locate_unexplained(*p, fit_effects(*p, {}, o), o))
      if (u.channel == found.channel) share = u.share_of_residual;
    shares.push_back(share);
  }
  return away(found.share_of_residual, shares, 0.03) > 5 &&
         found.share_of_residual > *std::max_element(shares.begin(), shares.end());
}

}  // namespace omniflight::diagnosis
