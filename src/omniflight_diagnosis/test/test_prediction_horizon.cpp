#include "../src/search/prediction_horizon.hpp"

#include "../src/regression/predetermined.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

std::vector<HorizonTest> asked(double answer_s) {
  const vehicle::Vehicle v = test::omnimorph();
  Options o;
  test::Flown f;
  f.duration_s = 60;
  f.sway = 0.2;
  f.answer_s = answer_s;
  f.accelerometer_noise = 0.3;  // the record tells less of the disturbance than the rotors' answer to it
  f.gyro_noise = 0.02;
  const auto flight = prepare_flight(test::fly(v, {}, f), v, o);
  EXPECT_TRUE(flight);
  const Flight* one[] = {&*flight};
  const Horizons horizons(one, v, o);
  std::vector<HorizonTest> out;
  for (std::size_t k = 0; k < horizons.count(); ++k) {
    EXPECT_EQ(horizons.problem(k)->rows(), 6 * horizons.problem(k)->samples());
    out.push_back(horizons.test(k));
    EXPECT_GE(out.back().horizon_s, least_horizon(*flight));
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

}  // namespace
}  // namespace omniflight::diagnosis
