// A force that pulsates in time follows no variable of the state, and is no part of a smooth spectrum.
#include <cmath>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_physics/correction.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

TEST(Diagnose, TellsTheFrequencyOfWhatPulsates) {
  physics::Correction pulse;
  pulse.channel = 1;
  pulse.world = true;
  pulse.feature.form = physics::Feature::Form::pulse;
  pulse.feature.frequency = 1.37;
  pulse.feature.phase = 0.6;
  pulse.coefficient = 0.15;
  pulse.low = -1;
  pulse.high = 1;
  const vehicle::Vehicle v = test::omnimorph();
  test::Flown f;
  f.duration_s = 40;
  f.sway = 0.2;
  const recording::Recording r = test::fly(v, {physics::as_effect(pulse)}, f);
  Options o;
  o.threads = 2;
  o.only = {"payload_mass", "constant_pull", "rotor_drag", "cable_pendulum", "wind"};
  const auto d = diagnose(std::span(&r, 1), {}, v, o);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(d->verdict, Verdict::unexplained) << d->summary;
  ASSERT_EQ(d->unexplained.size(), 1u) << d->summary;
  const Unexplained& u = d->unexplained[0];
  EXPECT_EQ(u.depends_on, std::vector<std::string>{"time"});
  EXPECT_EQ(u.channel, "Fy");
  EXPECT_EQ(u.frame, "world");
  ASSERT_EQ(u.correction.size(), 1u);
  EXPECT_NEAR(u.correction[0].frequency_hz, 1.37, 0.25 / f.duration_s);
  EXPECT_NEAR(u.correction[0].coefficient, 0.15, 0.03);
  ASSERT_TRUE(u.correction[0].model);
  EXPECT_EQ(u.correction[0].model->feature.form, physics::Feature::Form::pulse);
  // at the middle of the flight the phase is what the frequency leaves of it
  const double at = 2 * kPi * (u.correction[0].frequency_hz - 1.37) * 0.5 * f.duration_s -
                    (u.correction[0].model->feature.phase - 0.6);
  EXPECT_NEAR(std::remainder(at, 2 * kPi), 0, 0.3);
}

}  // namespace
}  // namespace omniflight::diagnosis
