// Fits of laws with kinks, where no Gauss-Newton step leads ahead, however short.
#include "../src/fit.hpp"

#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// A cable has two kinks, where it leaves the floor and where all of it is in the air; its lever, which is
/// not fitted, pulls at both.
TEST(Fit, ACableIsFoundAcrossItsKinks) {
  const vehicle::Vehicle v = test::omnimorph();
  const physics::Effect* cable = physics::find_effect("hung_cable");
  const physics::ActiveEffect lever{physics::find_effect("attachment_torque"), {0, 0, -0.012, 0.1}};
  test::Flown f;
  f.climb_m = 1.1, f.sway = 0.2;
  f.force_noise_N = 0.01, f.torque_noise_Nm = 0.001;
  const Options o;
  for (const double length : {0.6, 0.8}) {
    const physics::ActiveEffect truth{cable, {0.15, 0.5, length}};
    const auto flight = prepare_flight(test::fly(v, {truth, lever}, f), v, o);
    ASSERT_TRUE(flight) << flight.error().text();
    const Flight* one[] = {&*flight};
    const Problem problem(one, v, o);
    const Fit none = fit_effects(problem, {}, o), near = fit_effects(problem, {truth}, o),
              found = fit_with(problem, none, *cable, o);
    printf("%.4f kg/m from %.3f m on, %.3f m long; %.1f nats behind one that starts at the truth\n",
           found.effects[0].theta[0], found.effects[0].theta[1], found.effects[0].theta[2],
           near.log_likelihood - found.log_likelihood);
    EXPECT_GT(found.log_likelihood - none.log_likelihood, 10000);
    EXPECT_GT(found.log_likelihood, near.log_likelihood - 3);
  }
}

}  // namespace
}  // namespace omniflight::diagnosis
