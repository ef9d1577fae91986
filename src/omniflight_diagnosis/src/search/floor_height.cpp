#include "floor_height.hpp"

#include <algorithm>

#include "../conditioning/ground.hpp"
#include "../conditioning/pointers.hpp"
#include "../evidence/laplace.hpp"
#include "../evidence/noise_estimate.hpp"
#include "../numerics/text.hpp"
#include "../regression/predetermined.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kHigher[] = {0.5, 0.7, 0.9, 1.1, 1.3, 1.6};  ///< radii
constexpr double kClearly = 3;                                ///< nat

void move_floor(double hub_height, Flight& f) {
  f.floor_z = *f.stood_at - hub_height;
  for (physics::Situation& s : f.situation) s.environment.floor_z = f.floor_z;
}

/// Effects that tell where the floor is: the ground effect.
std::vector<const physics::Effect*> telling_effects() {
  std::vector<const physics::Effect*> out;
  for (const physics::Effect* effect : physics::builtin_effects())
    if (effect->info().tells_floor_height) out.push_back(effect);
  return out;
}

/// ln Bayes factor of an effect against nothing, at least 0, in the noise that slow functions of place leave.
double log_factor(const RegressionProblem& problem, const NoiseModel& noise, const physics::Effect& effect,
                  const Options& o) {
  Hypothesis law;
  law.id = effect.info().id;
  law.effect = &effect;
  const std::vector<Hypothesis> one{without_grid(law, problem, noise)};
  const Evidence evidence(problem, noise, one, o.error_of_laws(),
                          Eigen::VectorXd::Ones(problem.calibration().settled.size()));
  SetMember member;
  for (const physics::Parameter& p : effect.info().parameters) member.theta.push_back(p.typical);
  return std::max(0.0, evidence.fit({member}).log_evidence - evidence.fit({}).log_evidence);
}

}  // namespace

std::optional<double> hub_height(const std::vector<Flight>& flights, const vehicle::Vehicle& vehicle,
                                 const Options& o) {
  const double radius = mean_radius(vehicle);
  std::vector<Flight> standing;
  for (const Flight& f : flights)
    if (f.stood_at) standing.push_back(f);
  if (!(radius > 0) || standing.empty()) return {};
  const std::vector<const Flight*> all = pointers_to(standing);
  const Horizon horizon{least_horizon(all)};
  const RegressionProblem assumed(all, vehicle, o, horizon);
  const auto noise = estimate_noise(assumed, slow_columns(assumed), Eigen::VectorXd::Zero(assumed.rows()),
                                    assumed.temperature());  // the floor is no matter to it
  const auto gain = [&, effects = telling_effects()](const RegressionProblem& problem) {
    double most = 0;
    for (const physics::Effect* e : effects) most = std::max(most, log_factor(problem, *noise, *e, o));
    return most;
  };
  std::vector<double> gains{gain(assumed)};
  for (const double share : kHigher) {
    if (o.stopped()) return {};
    for (Flight& f : standing) move_floor(share * radius, f);
    gains.push_back(gain(RegressionProblem(all, vehicle, o, horizon)));
  }
  // the lowest that is nearly as good as the best: strength and height go together
  const double enough = *std::max_element(gains.begin(), gains.end()) - kClearly;
  const auto lowest = std::find_if(gains.begin(), gains.end(), [&](double g) { return g >= enough; });
  if (lowest == gains.begin()) return {};
  return kHigher[lowest - gains.begin() - 1] * radius;
}

void set_floor_height(double hub_height, Flight& f) {
  if (!f.stood_at) return;
  move_floor(hub_height, f);
  f.notes.push_back(
      format("The floor is taken %.0f mm below where the vehicle stood: so the ground effect explains its "
             "take-offs and landings best. environment.floor_z_m says where it is.",
             1e3 * hub_height));
}

}  // namespace omniflight::diagnosis
