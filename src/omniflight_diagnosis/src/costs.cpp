#include "costs.hpp"

#include <algorithm>
#include <cmath>

#include "statistics.hpp"

namespace omniflight::diagnosis {

Costs::Costs(std::size_t candidates, double error_rate, bool instrumented) {
  const double each = error_rate / std::max<double>(2.0, static_cast<double>(candidates));
  for (int k = 1; k <= physics::kMaxParameters; ++k)
    entry_.push_back(instrumented ? 0.5 * chi_squared_quantile(each, k) : 3.0 * (k - 1) - std::log(each));
}

double Costs::entry(const physics::Effect& effect) const {
  return entry_[static_cast<std::size_t>(effect.parameter_count() - 1)];
}

double Costs::entry(const Fit& fit) const {
  double sum = 0;
  for (const physics::ActiveEffect& e : fit.effects) sum += entry(*e.effect);
  return sum;
}

double Costs::complexity(const physics::Effect& effect) const {
  return entry_.front() + 3.0 * (effect.parameter_count() - 1);
}

double score(const Fit& fit, const Costs& costs) {
  double sum = fit.log_likelihood;
  for (const physics::ActiveEffect& e : fit.effects) sum -= costs.complexity(*e.effect);
  return sum;
}

double tested(const Fit& fit, const Costs& costs) { return fit.log_likelihood - costs.entry(fit); }

double tie(double gain, int fewer) {
  return std::max(3.0, fewer >= 3 ? std::min(0.1 * gain, 100 + 0.01 * gain) : 0.01 * gain);
}

}  // namespace omniflight::diagnosis
