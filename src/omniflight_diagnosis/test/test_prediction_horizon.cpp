#include "../src/search/prediction_horizon.hpp"

#include "../src/regression/predetermined.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

HorizonChoice chosen(double answer_s) {
  const vehicle::Vehicle v = test::omnimorph();
  Options o;
  o.engine = Engine::posterior;
  test::Flown f;
  f.duration_s = 60;
  f.sway = 0.2;
  f.answer_s = answer_s;
  f.accelerometer_noise = 0.3;  // the record tells less of the disturbance than the rotors' answer to it
  f.gyro_noise = 0.02;
  const auto flight = prepare_flight(test::fly(v, {}, f), v, o);
  EXPECT_TRUE(flight);
  const Flight* one[] = {&*flight};
  HorizonChoice choice;
  const auto problem = problem_of_consistent_horizon(one, v, o, choice);
  EXPECT_EQ(problem->rows(), 6 * problem->samples());
  EXPECT_GE(choice.horizon_s(), least_horizon(*flight));
  return choice;
}

TEST(PredictionHorizon, WithoutFeedbackTheShortestIsConsistent) {
  const HorizonChoice c = chosen(0);
  EXPECT_EQ(c.tests.size(), 1U);
  EXPECT_LT(c.tests[0].statistic, kHorizonsDisagree) << c.tests[0].about;
}

TEST(PredictionHorizon, FeedbackThatTheRecordDoesNotTellIsSeen) {
  const HorizonChoice c = chosen(0.04);
  EXPECT_GT(c.tests[0].statistic, kHorizonsDisagree) << c.tests[0].about;
  EXPECT_GT(c.horizon_s(), c.tests[0].horizon_s);
}

}  // namespace
}  // namespace omniflight::diagnosis
