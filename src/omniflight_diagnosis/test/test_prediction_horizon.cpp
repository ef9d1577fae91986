#include "../src/search/prediction_horizon.hpp"

#include "../src/evidence/laplace.hpp"
#include "../src/regression/predetermined.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// One minute; `answer_s`: of rotors to disturbances of which the record does not tell.
Flight flown(const vehicle::Vehicle& v, const Options& o, double answer_s,
             const std::vector<physics::ActiveEffect>& world = {}) {
  test::Flown f;
  f.duration_s = 60;
  f.sway = 0.2;
  f.answer_s = answer_s;
  f.accelerometer_noise = 0.3;  // the record tells less of the disturbance than the rotors' answer to it
  f.gyro_noise = 0.02;
  auto flight = prepare_flight(test::fly(v, world, f), v, o);
  EXPECT_TRUE(flight);
  return std::move(*flight);
}

std::vector<HorizonTest> asked(double answer_s) {
  const vehicle::Vehicle v = test::omnimorph();
  const Options o;
  const Flight flight = flown(v, o, answer_s);
  const Flight* one[] = {&flight};
  const Horizons horizons(one, v, o);
  std::vector<HorizonTest> out;
  for (std::size_t k = 0; k < horizons.count(); ++k) {
    EXPECT_EQ(horizons.problem(k)->rows(), 6 * horizons.problem(k)->samples());
    out.push_back(horizons.test(k));
    EXPECT_GE(out.back().horizon.s, least_horizon(flight));
  }
  EXPECT_TRUE(out.back().agrees());  // with nothing
  return out;
}

TEST(PredictionHorizon, WithoutFeedbackTheShortestIsConsistent) {
  const HorizonTest shortest = asked(0).front();
  EXPECT_TRUE(shortest.agrees()) << shortest.about;
}

TEST(PredictionHorizon, FeedbackThatTheRecordDoesNotTellIsSeen) {
  const HorizonTest shortest = asked(0.04).front();
  EXPECT_FALSE(shortest.agrees()) << shortest.about;
}

TEST(PredictionHorizon, WhereRatesAreNotRecordedTheShortestIsNotAsked) {
  const vehicle::Vehicle v = test::omnimorph();
  const Options o;
  test::Flown f;
  f.duration_s = 20;
  recording::Recording r = test::fly(v, {}, f);
  ASSERT_EQ(r.signals.erase("gyro"), 1U);
  const auto flight = prepare_flight(r, v, o);
  ASSERT_TRUE(flight) << flight.error().text();
  const Flight* one[] = {&*flight};
  const Horizons horizons(one, v, o);
  EXPECT_LT(least_horizon(*flight), 0.1);
  EXPECT_EQ(horizons.test(0).horizon.s, 0.15);
  EXPECT_GT(horizons.count(), 1U);
}

/// The largest of the statistics of a law alone, fitted at the shortest horizon, against longer ones.
HorizonTest of_law(const std::string& id, const Flight& flight, const vehicle::Vehicle& v, const Options& o) {
  const Flight* one[] = {&flight};
  const Horizons horizons(one, v, o);
  const auto problem = horizons.problem(0);
  const auto noise =
      estimate_noise(*problem, slow_columns(*problem), Eigen::VectorXd::Zero(problem->rows()), 1);
  const auto hypotheses = make_hypotheses(*problem, *noise, {physics::find_effect(id)}, o);
  const Evidence evidence(*problem, *noise, hypotheses, 0,
                          Eigen::VectorXd::Ones(problem->calibration().settled.size()));
  const SetFit fit = evidence.fit({evidence.member_at(0, 0, Eigen::VectorXd::Ones(1))});
  const EffectTerm found[] = {{hypotheses[0].effect, fit.members[0].theta, {}}};
  return horizons.test(0, problem->wrench_of(found, States::measured), found);
}

TEST(PredictionHorizon, ALawThatFeedbackMimicsIsNotFoundAgain) {
  const vehicle::Vehicle v = test::omnimorph();
  const Options o;
  const HorizonTest mimicked = of_law("payload_mass", flown(v, o, 0.04), v, o);
  EXPECT_GT(mimicked.of_laws, mimicked.threshold());
  const HorizonTest real =
      of_law("payload_mass", flown(v, o, 0, {{physics::find_effect("payload_mass"), {0.05}}}), v, o);
  EXPECT_TRUE(real.agrees()) << real.about << " " << real.statistic;
}

TEST(PredictionHorizon, AlsoCountsWhatALawHasWrong) {
  const vehicle::Vehicle v = test::omnimorph();
  Options exact, coarse;
  exact.law_error = 0;
  coarse.law_error = 0.5;
  const Flight flight = flown(v, exact, 0.04, {{physics::find_effect("payload_mass"), {0.3}}});
  const double sharp = of_law("payload_mass", flight, v, exact).of_laws;
  EXPECT_GT(sharp, 0);
  EXPECT_LT(of_law("payload_mass", flight, v, coarse).of_laws, 0.8 * sharp);
}

}  // namespace
}  // namespace omniflight::diagnosis
