// Where the rotors stand when the tilt servo's lag and play are told.
#include <gtest/gtest.h>

#include <algorithm>

#include "../src/conditioning/tilt_servo.hpp"
#include "omniflight_diagnosis/flight.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;
using test::omnimorph;

constexpr double kPeriod = 0.01;  // s
constexpr double kLag = 0.08;     // s
constexpr double kSlope = 0.2;    // rad/s

vehicle::Vehicle told() {
  vehicle::Vehicle v = omnimorph();
  v.tilt.time_constant = kLag;
  return v;
}

/// A ramp from 0.2 rad that lies `late` [s] behind time.
Signal ramp(const char* name, double late) {
  Signal s;
  s.name = name;
  s.values.resize(200, 1);
  for (int i = 0; i < 200; ++i) {
    s.t_s.push_back(kPeriod * i);
    s.values(i, 0) = 0.2 + kSlope * std::max(0.0, kPeriod * i - late);
  }
  return s;
}

Recording recorded(std::initializer_list<Signal> signals) {
  Recording r;
  for (const Signal& s : signals) r.signals[s.name] = s;
  return r;
}

double last(const RotorTilt& tilt) { return tilt.alpha.values(tilt.alpha.size() - 1, 0); }

TEST(ToldServo, AMeasuredTiltIsWhereTheRotorsStand) {
  const auto tilt = rotor_tilt(recorded({ramp("alpha", kLag), ramp("alpha_command", 0)}), told());
  ASSERT_TRUE(tilt);
  EXPECT_FALSE(tilt->modelled);
  EXPECT_EQ(last(*tilt), ramp("alpha", kLag).values(199, 0));
}

TEST(ToldServo, ATiltThatRepeatsItsCommandIsFollowedWithTheToldLag) {
  const Recording r = recorded({ramp("alpha", 0), ramp("alpha_command", 0)});
  const auto tilt = rotor_tilt(r, told());
  ASSERT_TRUE(tilt);
  EXPECT_TRUE(tilt->modelled);
  EXPECT_NEAR(last(*tilt), ramp("", kLag).values(199, 0), 0.01 * kSlope * kLag) << "rate times lag behind";
  EXPECT_EQ(last(*rotor_tilt(r, omnimorph())), last(*rotor_tilt(recorded({ramp("alpha", 0)}), omnimorph())))
      << "where nothing is told it is taken as it is";
}

TEST(ToldServo, ACommandAloneIsFollowedAsTheVehicleFileTells) {
  const auto tilt = rotor_tilt(recorded({ramp("alpha_command", 0)}), told());
  ASSERT_TRUE(tilt);
  EXPECT_TRUE(tilt->modelled);
  EXPECT_NEAR(last(*tilt), ramp("", kLag).values(199, 0), 0.01 * kSlope * kLag);
  vehicle::Vehicle fixed = omnimorph();
  fixed.tilt = {};
  EXPECT_FALSE(rotor_tilt(recorded({ramp("alpha_command", 0)}), fixed));
  EXPECT_FALSE(rotor_tilt({}, told()));
}

TEST(ToldServo, RatePlayAndGapsAreThoseOfTheServo) {
  const std::vector<double> t{0, 0.1, 0.2, 0.3, 0.4};
  Eigen::VectorXd input(5);
  input << 0.0, 1.0, std::nan(""), 1.0, 1.0;
  const Eigen::VectorXd rated = answer_of_servo({vehicle::TiltKind::common, 0, 1, 2.0}, t, input);
  EXPECT_NEAR(rated[1], 0.2, 1e-12);
  EXPECT_TRUE(std::isnan(rated[2]));
  EXPECT_NEAR(rated[3], 0.6, 1e-12) << "it goes on over the gap";
  input << 0.0, 0.3, 0.3, 0.25, 0.0;
  const Eigen::VectorXd loose = answer_of_servo({vehicle::TiltKind::common, 0, 1, 0, 0, 0.2}, t, input);
  EXPECT_NEAR(loose[2], 0.2, 1e-12);
  EXPECT_NEAR(loose[3], 0.2, 1e-12) << "within its play";
  EXPECT_NEAR(loose[4], 0.1, 1e-12) << "the other side of its play";
}

TEST(ToldServo, AFlightWithoutMeasuredTiltIsPreparedAtTheOneItsCommandGives) {
  const vehicle::Vehicle v = told();
  Recording r = test::fly(v, {}, {.duration_s = 10});
  const auto measured = prepare_flight(r, v, {});
  ASSERT_TRUE(measured) << measured.error().text();
  r.signals["alpha_command"] = r.signals["alpha"];
  r.signals["alpha_command"].name = "alpha_command";
  r.signals.erase("alpha");
  const auto commanded = prepare_flight(r, v, {});
  ASSERT_TRUE(commanded) << commanded.error().text();
  EXPECT_TRUE(commanded->has_alpha);
  const auto middle = static_cast<std::size_t>(commanded->size() / 2);
  EXPECT_NEAR(commanded->situation[middle].alpha, measured->situation[middle].alpha, 1e-9);
  EXPECT_TRUE(std::any_of(commanded->notes.begin(), commanded->notes.end(), [](const std::string& note) {
    return note.find("follow its command") != std::string::npos;
  }));
}

}  // namespace
}  // namespace omniflight::diagnosis
