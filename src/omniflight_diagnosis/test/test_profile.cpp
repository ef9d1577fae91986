#include "../src/search/profile.hpp"

#include <memory>

#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// OmniMorph with a payload of 0.4 kg, and what the profile of that set is where accelerations are expected
/// with a payload of `expected` [kg] (of the best set so far).
Profile of_payload(double expected) {
  const vehicle::Vehicle v = test::omnimorph();
  const Options o;
  const physics::Effect* payload = physics::find_effect("payload_mass");
  test::Flown f;
  f.duration_s = 30;
  const auto flight = prepare_flight(test::fly(v, {{payload, {0.4}}}, f), v, o);
  EXPECT_TRUE(flight);
  const Flight* one[] = {&*flight};
  RegressionProblem problem(one, v, o, {0.1});
  const EffectTerm term{payload, {expected}, {}};
  problem.expect(std::span(&term, 1));
  const SlowColumns slow = slow_columns(problem);
  const auto noise = estimate_noise(problem, slow, Eigen::VectorXd::Zero(problem.rows()), 1);
  const auto hypotheses = make_hypotheses(problem, *noise, {payload}, o);
  const FittedAmplitudes fitted(problem);
  const Profiler profiler(problem, hypotheses, slow, fitted, o);
  SetMember member;
  member.theta = {expected};
  Profile out = profiler.of({member}, Eigen::VectorXd::Ones(problem.calibration().settled.size()));
  out.noise.reset();  // it refers to the problem
  return out;
}

TEST(Profile, ASetIsFittedAtItsOwnAccelerationsWhateverWasFoundBefore) {
  const Profile nothing = of_payload(0), half = of_payload(0.2), truth = of_payload(0.4);
  const double mass = truth.fit.members.at(0).theta.at(0);
  EXPECT_NEAR(mass, 0.4, 0.08);  // a thrust coefficient that is told to 3 % hides some of it
  for (const Profile* p : {&nothing, &half}) {
    EXPECT_NEAR(p->fit.members.at(0).theta.at(0), mass, 0.02 * mass);
    // at accelerations without a payload, 3 m/s^2 too large, it is 36 nat behind, and 0.25 kg
    EXPECT_NEAR(p->joint, truth.joint, 15);
  }
}

}  // namespace
}  // namespace omniflight::diagnosis
