// Values refined so that short open-loop flights stay close to what was recorded.
#include "../src/shooting.hpp"

#include "../src/problem.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

test::Flown quiet(std::uint64_t seed) {
  test::Flown f;
  f.force_noise_N = f.torque_noise_Nm = 0;
  f.seed = seed;
  return f;
}

Fit model_of(const Problem& problem, const std::vector<physics::ActiveEffect>& effects) {
  Fit fit;
  fit.effects = effects;
  fit.offsets = Eigen::VectorXd::Zero(problem.offset_sigma().size());
  problem.predict(fit.effects, fit.offsets, fit.residual, nullptr);
  return fit;
}

TEST(Shooting, FindsTheValuesThatFlew) {
  const vehicle::Vehicle v = test::omnimorph();
  const physics::Effect* cable = physics::find_effect("hung_cable");
  ASSERT_NE(cable, nullptr);
  const std::vector<double> truth{0.25, 0.6, 5.0};
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const auto flight = prepare_flight(test::fly(v, {{cable, truth}}, quiet(seed)), v, {});
    ASSERT_TRUE(flight) << flight.error().text();
    const Flight* one[] = {&*flight};
    const Problem problem(one, v, {});
    const Fit wrong = model_of(problem, {{cable, {0.19, 0.66, 5.0}}});
    const auto better = refine_by_shooting(one, v, problem, wrong, {});
    ASSERT_TRUE(better);
    EXPECT_NEAR(better->fit.effects[0].theta[0], truth[0], 0.02 * truth[0]);
    EXPECT_NEAR(better->fit.effects[0].theta[1], truth[1], 0.02);
    EXPECT_LT(better->summary.error_after, 0.8 * better->summary.error_before);
    EXPECT_LE(better->fit.plausible[0].first, 0.19);
    EXPECT_LT(better->fit.residual.norm(), wrong.residual.norm());
    // the same to the bit
    const auto again = refine_by_shooting(one, v, problem, wrong, {});
    ASSERT_TRUE(again);
    EXPECT_EQ(again->fit.effects[0].theta, better->fit.effects[0].theta);
  }
}

TEST(Shooting, LeavesAloneWhatItCannotBetter) {
  const vehicle::Vehicle v = test::omnimorph();
  const physics::Effect* cable = physics::find_effect("hung_cable");
  const auto flight = prepare_flight(test::fly(v, {{cable, {0.25, 0.6, 5.0}}}, quiet(3)), v, {});
  ASSERT_TRUE(flight);
  const Flight* one[] = {&*flight};
  const Problem problem(one, v, {});
  const auto better = refine_by_shooting(one, v, problem, model_of(problem, {{cable, {0.25, 0.6, 5.0}}}), {});
  if (better) {  // by a hair, then
    EXPECT_NEAR(better->fit.effects[0].theta[0], 0.25, 0.002);
  }
  EXPECT_FALSE(refine_by_shooting(one, v, problem, model_of(problem, {}), {}));
  Options stopped;
  stopped.stop = [] { return true; };
  EXPECT_FALSE(refine_by_shooting(one, v, problem, model_of(problem, {{cable, {0.1, 0.6, 5.0}}}), stopped));
}

}  // namespace
}  // namespace omniflight::diagnosis
