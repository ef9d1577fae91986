#include "floor_height.hpp"

#include <algorithm>

#include "fit.hpp"
#include "ground.hpp"
#include "text.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kHigher[] = {0.5, 0.7, 0.9, 1.1, 1.3, 1.6};  ///< radii
constexpr double kClearly = 3;                                ///< units of log-likelihood

void move_floor(double hub_height, Flight& f) {
  f.floor_z = *f.stood_at - hub_height;
  for (auto* states : {&f.situation, &f.smooth, &f.instrument})
    for (physics::Situation& s : *states) s.environment.floor_z = f.floor_z;
}

/// What the ground effect explains, in units of log-likelihood.
double explained(const std::vector<Flight>& flights, const physics::Effect& effect,
                 const vehicle::Vehicle& vehicle, const Options& o) {
  std::vector<const Flight*> pointers;
  for (const Flight& f : flights) pointers.push_back(&f);
  const Problem problem(pointers, vehicle, o);
  const Fit without = fit_effects(problem, {}, o);
  const Fit with = fit_with(problem, without, effect, o);
  return at_limit(problem, with.effects.back()) ? 0 : with.log_likelihood - without.log_likelihood;
}

}  // namespace

std::optional<double> hub_height(const std::vector<Flight>& flights, const vehicle::Vehicle& vehicle,
                                 const Options& o) {
  const physics::Effect* effect = physics::find_effect("ground_effect");
  const double radius = mean_radius(vehicle);
  std::vector<Flight> standing;
  for (const Flight& f : flights)
    if (f.stood_at) standing.push_back(f);
  if (!effect || !(radius > 0) || standing.empty()) return {};
  std::vector<double> gains{explained(standing, *effect, vehicle, o)};
  for (const double share : kHigher) {
    if (o.stopped()) return {};
    for (Flight& f : standing) move_floor(share * radius, f);
    gains.push_back(explained(standing, *effect, vehicle, o));
  }
  // the lowest that is nearly as good as the best: strength and height go together
  const double enough = *std::max_element(gains.begin(), gains.end()) - kClearly;
  const auto lowest = std::find_if(gains.begin(), gains.end(), [&](double g) { return g >= enough; });
  if (lowest == gains.begin()) return {};
  return kHigher[lowest - gains.begin() - 1] * radius;
}

void put_floor(double hub_height, Flight& f) {
  if (!f.stood_at) return;
  move_floor(hub_height, f);
  f.notes.push_back(
      format("The floor is taken %.0f mm below where the vehicle stood: so the ground effect explains its "
             "take-offs and landings best. environment.floor_z_m says where it is.",
             1e3 * hub_height));
}

}  // namespace omniflight::diagnosis
