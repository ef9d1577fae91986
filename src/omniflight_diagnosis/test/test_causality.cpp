// Rotors that answer a disturbance are not taken for rotors that turn the body less than they should.
#include "../src/causality.hpp"

#include "../src/problem.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// Whether a law of one number, fitted alone to a flight in this world, is seen through; its value in
/// `scale`.
bool seen_through(const char* law, const std::vector<physics::ActiveEffect>& truth, const test::Flown& f,
                  double& scale) {
  const vehicle::Vehicle v = test::omnimorph();
  const Options o;
  const auto flight = prepare_flight(test::fly(v, truth, f), v, o);
  EXPECT_TRUE(flight) << flight.error().text();
  if (!flight) return false;
  const Flight* one[] = {&*flight};
  const Problem problem(one, v, o);
  EXPECT_FALSE(problem.instrumented());
  const Fit fit = fit_effects(problem, {{physics::find_effect(law), {0.0}}}, o);
  scale = fit.effects[0].theta[0];
  return answers_instead_of_causing(problem, fit, 0, o);
}

TEST(Causality, ThrustThatAnswersATorqueDoesNotCauseIt) {
  test::Flown f;
  f.torque_noise_Nm = 0.05;
  f.answer_s = 0.08;
  int seen = 0;
  for (f.seed = 1; f.seed <= 5; ++f.seed) {
    double scale = 0;
    seen += seen_through("drag_torque_scale", {}, f, scale);
    EXPECT_LT(scale, -0.2) << "this is what a regression makes of it, seed " << f.seed;
  }
  EXPECT_EQ(seen, 5);
}

TEST(Causality, ThrustThatIsWeakIsLeftAlone) {
  test::Flown f;
  f.sway = 0.3;
  f.force_noise_N = 0.02;
  for (f.seed = 1; f.seed <= 5; ++f.seed) {
    double scale = 0;
    EXPECT_FALSE(seen_through("thrust_scale", {{physics::find_effect("thrust_scale"), {-0.1}}}, f, scale));
    EXPECT_NEAR(scale, -0.1, 0.03);
  }
}

}  // namespace
}  // namespace omniflight::diagnosis
