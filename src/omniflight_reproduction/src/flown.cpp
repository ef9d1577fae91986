#include "flown.hpp"

#include <cmath>
#include <limits>

namespace omniflight::reproduction {
namespace {

constexpr std::size_t kMostPoints = 900;  // of a curve: a page has dozens

}  // namespace

Result<std::optional<Flown>> flown(const Inputs& inputs, const std::string& name) {
  const auto at = inputs.flights.find(name);
  if (at == inputs.flights.end()) return std::optional<Flown>();
  auto metrics = report::assess(at->second, inputs.omnimorph);
  if (!metrics) return Failure(metrics.error());
  return std::optional<Flown>(Flown{&at->second, std::move(*metrics)});
}

std::size_t step_of_curve(std::size_t samples) { return std::max<std::size_t>(1, samples / kMostPoints); }

std::vector<report::Series> curves(const Flown& flight, const std::string& signal,
                                   const std::vector<std::string>& names, int first, double scale,
                                   bool dashed) {
  std::vector<report::Series> out;
  const recording::Signal* s = flight.recording->find(signal);
  if (!s) return out;
  const auto step = step_of_curve(s->t_s.size());
  for (std::size_t k = 0; k < names.size(); ++k) {
    const Eigen::Index column = first + static_cast<Eigen::Index>(k);
    if (column >= s->width()) break;
    auto& series = out.emplace_back(report::Series{.name = names[k], .dashed = dashed});
    for (std::size_t i = 0; i < s->t_s.size(); i += step) {
      if (s->t_s[i] < flight.metrics.from || s->t_s[i] > flight.metrics.to) continue;
      series.x.push_back(s->t_s[i] - flight.metrics.from);
      series.y.push_back(scale * s->values(static_cast<Eigen::Index>(i), column));
    }
  }
  return out;
}

double rms(const Flown& flight, const std::string& signal, int column) {
  const recording::Signal* s = flight.recording->find(signal);
  if (!s || column >= s->width()) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  std::size_t used = 0;
  for (std::size_t i = 0; i < s->t_s.size(); ++i) {
    if (s->t_s[i] < flight.metrics.from || s->t_s[i] > flight.metrics.to) continue;
    sum += std::pow(s->values(static_cast<Eigen::Index>(i), column), 2);
    ++used;
  }
  return used > 0 ? std::sqrt(sum / static_cast<double>(used)) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace omniflight::reproduction
