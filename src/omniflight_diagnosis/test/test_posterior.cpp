// Answers to flights whose truth is known.
#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "../src/regression/predetermined.hpp"
#include "../src/regression/regression_problem.hpp"
#include "../src/search/posterior.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::find_effect;

const Finding* find(const Diagnosis& d, const std::string& effect) {
  const auto at = std::find_if(d.findings.begin(), d.findings.end(),
                               [&](const Finding& f) { return f.effect == effect; });
  return at == d.findings.end() ? nullptr : &*at;
}

Diagnosis answer(const std::vector<physics::ActiveEffect>& world, const test::Flown& f,
                 const std::map<std::string, double>& inclusion = {}) {
  const vehicle::Vehicle v = test::omnimorph();
  const recording::Recording r = test::fly(v, world, f);
  Options o;
  o.threads = 2;
  o.inclusion = inclusion;
  o.only = {"payload_mass", "hung_cable", "thrust_scale",  "constant_pull",
            "catenary",     "rotor_drag", "cable_pendulum"};
  auto d = diagnose(std::span(&r, 1), {}, v, o);
  EXPECT_TRUE(d) << d.error().text();
  return d ? *d : Diagnosis{};
}

// Together half as heavy as the vehicle: at the acceleration that the nominal vehicle would have, the load
// would seem to grow with the cable's weight.
TEST(RegressionProblem, LoadsWeighByTheAccelerationThatTheVehicleHasWithThem) {
  test::Flown f;
  f.duration_s = 60;
  f.force_noise_N = 0.03;
  const std::vector<physics::ActiveEffect> world{{find_effect("payload_mass"), {0.28}},
                                                 {find_effect("hung_cable"), {0.30, 0.62, 5.0}}};
  const vehicle::Vehicle v = test::omnimorph();
  Options o;
  const auto flight = prepare_flight(test::fly(v, world, f), v, o);
  ASSERT_TRUE(flight) << flight.error().text();
  const Flight* one[] = {&*flight};
  RegressionProblem problem(one, v, o, Horizon{least_horizon(*flight)});
  std::vector<EffectTerm> terms;
  for (const physics::ActiveEffect& e : world) terms.push_back({e.effect, e.theta, {}});
  const auto left = [&](States states) {
    const Eigen::VectorXd rest = problem.residual() - problem.wrench_of(terms, states);
    const int n = problem.samples();
    return std::sqrt(rest.segment(2 * n, n).squaredNorm() / n);
  };
  const double measured = left(States::measured), predicted = left(States::predicted);
  problem.expect(terms);
  const double expected = left(States::predicted);
  std::printf(
      "Fz: %.3f N left at measured states, %.3f N at predicted ones, %.3f N with the loads expected\n",
      measured, predicted, expected);
  EXPECT_GT(predicted, 2 * expected);
  EXPECT_LT(expected, 1.2 * measured);
}

TEST(Posterior, ASingleFlightIsPredictedByThirds) {
  test::Flown f;
  f.duration_s = 60;
  const Diagnosis d = answer({{find_effect("hung_cable"), {0.30, 0.62, 5.0}}}, f);
  ASSERT_TRUE(find(d, "hung_cable")) << d.summary;
  int parts = 0;
  for (const ChannelFit& c : d.fit.held_out) {
    if (c.channel != "Fz") continue;
    ++parts;
    EXPECT_NE(c.recording.find("not fitted"), std::string::npos) << c.recording;
    EXPECT_LT(c.rms_after, c.rms_before);
  }
  EXPECT_EQ(parts, 3);
  EXPECT_FALSE(d.fit.rollout.empty());
}

// m (a + g) = k F in every motion of the centre of mass: only torques tell a load from a weak thrust, and the
// prior where there are none. Here thrust is known to be often weak.
TEST(Posterior, WhatCannotBeToldApartHasAFlightThatWould) {
  test::Flown f;
  const Diagnosis d = answer({{find_effect("payload_mass"), {0.15}}}, f, {{"thrust_scale", 0.7}});
  ASSERT_EQ(d.verdict, Verdict::ambiguous) << d.summary;
  const auto& pairs = d.next_flight.separates;
  const auto pair = std::find_if(pairs.begin(), pairs.end(), [](const auto& p) {
    return p == std::pair<std::string, std::string>("payload_mass", "thrust_scale") ||
           p == std::pair<std::string, std::string>("thrust_scale", "payload_mass");
  });
  ASSERT_NE(pair, pairs.end()) << d.summary;
  ASSERT_FALSE(d.next_flight.proposed.empty());
  const ProposedFlight& first = d.next_flight.proposed.front();
  EXPECT_GT(first.separations_sigma[static_cast<std::size_t>(pair - pairs.begin())], 3) << first.name;
}

// The answer must not know how many threads there were.
TEST(Posterior, EveryThreadFindsTheSame) {
  const vehicle::Vehicle v = test::omnimorph();
  test::Flown f;
  f.duration_s = 20, f.climb_m = 1.1, f.sway = 0.2;
  const recording::Recording r = test::fly(
      v, {{find_effect("hung_cable"), {0.15, 0.5, 1.2}}, {find_effect("thrust_scale"), {-0.03}}}, f);
  std::vector<nlohmann::json> answers;
  for (const int threads : {1, 3}) {
    Options o;
    o.threads = threads;
    o.rollouts = false;
    o.only = {"hung_cable", "thrust_scale", "payload_mass", "com_offset", "constant_pull", "inertia_error"};
    const auto d = diagnose(std::span(&r, 1), {}, v, o);
    ASSERT_TRUE(d) << d.error().text();
    answers.push_back(nlohmann::json::parse(to_json(*d)));
    EXPECT_FALSE(d->findings.empty()) << d->summary;
  }
  EXPECT_EQ(answers[0], answers[1]);  // to the bit
}

/// ln joint densities of nothing, of one law, and of that law beside another, which explains this much more;
/// prior odds of -4 a law. What the laws do is spread over this many amplitudes.
Posterior with_a_second(double first, double more, Eigen::Index amplitudes = 100000) {
  Posterior p;
  p.energy.setConstant(amplitudes, 2 * std::abs(first + more) / static_cast<double>(amplitudes));
  p.sets = {
      {{}, {}, {}, 0, 0, 0}, {{0}, {}, {}, first - 4, -4, 0}, {{0, 1}, {}, {}, first + more - 8, -8, 0}};
  return p;
}

// Of 500 nat, laws that are right within one, two or four tenths leave 10, 40 or 160 to chance.
TEST(Posterior, WhatALawHasWrongIsNoEvidenceOfAnother) {
  const auto share_of_second = [](double first, double more, double law_error) {
    Posterior p = with_a_second(first, more);
    share_probability(law_error, p);
    EXPECT_NEAR(p.sets[0].probability + p.sets[1].probability + p.sets[2].probability, 1, 1e-12);
    EXPECT_LT(p.probability_of_nothing, 1e-3);
    return p.sets[2].probability / (1 - p.probability_of_nothing);
  };
  EXPECT_NEAR(share_of_second(500, 10, 0), 1 / (1 + std::exp(4.0 - 10)), 1e-9);
  double mean = 0;
  for (const double variance : {0.02, 0.08, 0.32})
    mean += 1 / (1 + std::exp(4 - 10 / (1 + variance * 510))) / 3;
  EXPECT_NEAR(share_of_second(500, 10, 0.1), mean, 1e-9);
  EXPECT_LT(share_of_second(500, 10, 0.1), 0.1);
  EXPECT_GT(share_of_second(50, 40, 0.1), 0.5) << "of little a tenth is nothing";
  EXPECT_GT(share_of_second(500, 400, 0.1), 0.5) << "what is no misfit";
}

// Of 500 nat in 20 amplitudes, 160 would be left by laws that are wrong by four tenths, and only 10 are.
TEST(Posterior, LawsLeaveNoMoreThanIsThere) {
  Posterior p = with_a_second(480, 20, 20);
  share_probability(0.1, p);
  EXPECT_NEAR(p.left_by_laws, 5, 1e-9);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(p.left_between_laws[k], 10, 1e-9);
  EXPECT_NEAR(p.sets[2].probability, 1 / (1 + std::exp(4 - 20.0 / 11)), 1e-9);
}

// Laws that were wrong by four tenths would leave sixteen times the noise in each of fifty amplitudes.
TEST(Posterior, WhatIsLeftTellsHowWrongLawsAre) {
  const double temperature = 2;
  const Eigen::ArrayXd energy = Eigen::ArrayXd::Constant(50, 50), none = Eigen::ArrayXd::Zero(50);
  Random random(4);
  const auto left_by = [&](double error) {  // noise and errors of that size
    Eigen::ArrayXd out(50);
    for (double& x : out) x = std::sqrt(1 / temperature + error * error * 50) * random.normal();
    return probability_of_errors(0.1, energy, out, temperature);
  };
  for (const double p : probability_of_errors(0.1, none, none, temperature)) EXPECT_NEAR(p, 1.0 / 3, 1e-12);
  EXPECT_GT(left_by(0.0)[0], 0.9);
  EXPECT_GT(left_by(0.4)[2], 0.9);
  EXPECT_LT(left_by(0.0)[2], 1e-3);
}

// Where every law is far less likely than nothing, shares are numbers nevertheless.
TEST(Posterior, SharesAreFiniteWhereNothingIsFarLikelier) {
  Posterior p = with_a_second(-2000, -2000);
  share_probability(0.1, p);
  EXPECT_NEAR(p.probability_of_nothing, 1, 1e-12);
  for (const SetPosterior& s : p.sets) EXPECT_TRUE(std::isfinite(s.probability));
}

// By 40 deg from the begin: the likelihood has an optimum near many lengths.
TEST(Posterior, ALoadThatAlreadySwingsIsNamedWithItsLength) {
  const vehicle::Vehicle v = test::omnimorph();
  test::Flown f;
  f.duration_s = 40;
  f.swing = 0.7;
  f.force_noise_N = 0.04;
  f.torque_noise_Nm = 0.004;
  const physics::ActiveEffect load{find_effect("slung_load"), {0.06, 0.25, 0.05, 0, 0, -0.02}};
  const recording::Recording r = test::fly(v, {load}, f);
  Options o;
  o.threads = 2;
  o.only = {"payload_mass", "hung_cable", "slung_load", "cable_pendulum", "constant_pull", "overhead_rope"};
  const auto d = diagnose(std::span(&r, 1), {}, v, o);
  ASSERT_TRUE(d) << d.error().text();
  const Finding* found = find(*d, "slung_load");
  ASSERT_TRUE(found) << d->summary;
  EXPECT_NEAR(found->parameters[0].value, 0.06, 0.015);
  EXPECT_NEAR(found->parameters[1].value, 0.25, 0.02);
}

}  // namespace
}  // namespace omniflight::diagnosis
