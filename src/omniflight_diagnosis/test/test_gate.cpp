// What must stand on data it was not fitted to is not less of an effect because another flight lacks it, or
// because tolerances could stand in for it.
#include "../src/gate.hpp"

#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// The gate of one effect, fitted to these flights.
Gate gate_of(const physics::Effect& effect, const std::vector<recording::Recording>& recordings,
             const Options& o) {
  const vehicle::Vehicle v = test::omnimorph();
  std::vector<Flight> flights;
  for (const recording::Recording& r : recordings) {
    auto f = prepare_flight(r, v, o);
    EXPECT_TRUE(f);
    if (f) flights.push_back(std::move(*f));
  }
  std::vector<const Flight*> all;
  for (const Flight& f : flights) all.push_back(&f);
  const Problem problem(all, v, o);
  return gate_effect(problem, fit_with(problem, fit_effects(problem, {}, o), effect, o), 0, o);
}

TEST(Gate, AFlightThatLacksAnEffectTakesNoShareOfItAway) {
  const physics::Effect& drag = *physics::find_effect("rotor_drag");
  const vehicle::Vehicle v = test::omnimorph();
  const std::vector<double> theta{1e-4};
  test::Flown quick, still;
  quick.side_m = 1.2;
  still.side_m = still.climb_m = 0;
  still.duration_s = 90;
  still.seed = 2;
  const auto moving = test::fly(v, {{&drag, theta}}, quick), resting = test::fly(v, {{&drag, theta}}, still);
  const double one = gate_of(drag, {moving}, {}).energy_share;
  const double both = gate_of(drag, {moving, resting}, {}).energy_share;
  EXPECT_GT(one, 0.01);
  EXPECT_GT(both, 0.5 * one) << "of all samples it is less than a third of that";
}

TEST(Gate, ASteadyEffectIsProminentThoughTolerancesCouldStandInForIt) {
  const physics::Effect& load = *physics::find_effect("payload_mass");
  const vehicle::Vehicle v = test::omnimorph();
  test::Flown f;
  f.duration_s = 60;
  const auto flown = test::fly(v, {{&load, {0.012}}}, f);
  const Gate gate = gate_of(load, {flown}, {});
  EXPECT_GT(gate.prominence, 2 * gate.energy_share);
  EXPECT_GT(gate.prominence, 0.1);
  const Gate none = gate_of(load, {test::fly(v, {}, f)}, {});
  EXPECT_LT(none.prominence, 0.5 * gate.prominence);
}

}  // namespace
}  // namespace omniflight::diagnosis
