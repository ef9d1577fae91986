#include "omniflight_identification/continuous.hpp"

namespace omniflight::identification {
namespace {

constexpr Eigen::Index kLongest = 20'000;
constexpr double kSettledShare = 1e-3;  // of the end, over the last quarter

/// Time [s] at which the response first reaches a share of its end, linear between samples.
double reached(const Eigen::VectorXd& share, double level, double period_s) {
  for (Eigen::Index t = 1; t < share.size(); ++t)
    if (share[t] >= level) {
      const double step = share[t] - share[t - 1];
      return period_s * (static_cast<double>(t) - (step > 0 ? (share[t] - level) / step : 0.0));
    }
  return 0.0;
}

}  // namespace

Result<ContinuousEquivalent> continuous_equivalent(const PolynomialModel& model, Eigen::Index input) {
  if (!model.stable())
    return bad_input("the model is unstable, so that it has no step response that ends", "model",
                     "Choose another order or structure");
  ContinuousEquivalent out;
  out.gain = model.static_gain(input);
  if (!std::isfinite(out.gain) || std::abs(out.gain) < 1e-300)
    return bad_input("the model has no gain at rest", "model", "Choose another order or structure");
  for (Eigen::Index count = 200; count <= kLongest; count *= 2) {
    const Eigen::VectorXd share = model.step(input, count) / out.gain;
    if ((share.tail(count / 4).array() - 1.0).abs().maxCoeff() > kSettledShare) continue;
    const double t28 = reached(share, 0.283, model.period_s), t63 = reached(share, 0.632, model.period_s);
    out.lag_s = 1.5 * (t63 - t28);
    out.delay_s = std::max(0.0, t63 - out.lag_s);
    return out;
  }
  return bad_input(
      "the model's step response does not settle within " + std::to_string(kLongest) + " samples", "model",
      "Remove drift, or record longer");
}

std::vector<std::complex<double>> continuous_poles(const PolynomialModel& model) {
  std::vector<std::complex<double>> out;
  for (const auto& pole : model.poles())
    if (std::abs(pole) > 1e-12) out.push_back(std::log(pole) / model.period_s);
  return out;
}

}  // namespace omniflight::identification
