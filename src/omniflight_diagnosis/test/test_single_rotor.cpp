// One rotor out of eight as a hypothesis of its own.
#include <gtest/gtest.h>

#include "../src/search/single_rotor.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

TEST(SingleRotor, SaysWhatTheWholeEffectSaysOfThatRotor) {
  const vehicle::Vehicle v = test::omnimorph();
  const auto hypotheses =
      by_rotor({physics::find_effect("payload_mass"), physics::find_effect("rotor_axis_misalignment")}, v);
  ASSERT_EQ(hypotheses.size(), 1u + 8u);
  EXPECT_EQ(hypotheses[0]->info().id, "payload_mass");
  physics::Situation s;
  RigidState x;
  x.p_WB.z() = 1;
  const std::vector<double> speeds{500, 510, 520, 530, 540, 550, 560, 570};
  physics::prepare(v, x, 0.5, speeds, {}, {}, s);
  for (int rotor = 0; rotor < 8; ++rotor) {
    const physics::Effect& one = *hypotheses[static_cast<std::size_t>(1 + rotor)];
    EXPECT_EQ(one.info().id, "rotor_axis_misalignment");
    ASSERT_EQ(one.parameter_count(), 2);
    const physics::ActiveEffect part{&one, {0.03, -0.02}}, whole = in_full(part);
    ASSERT_EQ(whole.theta.size(), 16u);
    EXPECT_EQ(whole.theta[static_cast<std::size_t>(2 * rotor)], 0.03);
    std::array<double, 6> a{}, b{};
    std::array<double, 6 * physics::kMaxParameters> ja{}, jb{};
    one.wrench_with_jacobian(s, part.theta.data(), a.data(), ja.data());
    whole.effect->wrench_with_jacobian(s, whole.theta.data(), b.data(), jb.data());
    for (std::size_t c = 0; c < 6; ++c) EXPECT_EQ(a[c], b[c]);
    for (std::size_t c = 0; c < 12; ++c) EXPECT_EQ(ja[c], jb[c + static_cast<std::size_t>(12 * rotor)]);
  }
  const physics::ActiveEffect other{physics::find_effect("payload_mass"), {0.1}};
  EXPECT_EQ(in_full(other).effect, other.effect);
}

TEST(UnrecordedForm, IsOfferedBesideTheFirstOfItsAliasesAndToldAsItsEffect) {
  const vehicle::Vehicle v = test::omnimorph();
  const physics::Effect* lag = physics::find_effect("tilt_servo_lag");
  const auto offered = by_rotor({physics::find_effect("tilt_offset"), physics::find_effect("wind")}, v);
  ASSERT_EQ(offered.size(), 3u);
  EXPECT_EQ(offered[1], lag->unrecorded_form());
  const physics::ActiveEffect whole = in_full({lag->unrecorded_form(), {0.07}});
  EXPECT_EQ(whole.effect, lag);
  EXPECT_EQ(whole.theta, (std::vector<double>{0.07, 0.0}));
  EXPECT_EQ(by_rotor({physics::find_effect("tilt_efficiency")}, v).size(), 1u) << "an alias, not the first";
}

TEST(SingleRotor, AWeakPropellerIsNamedWithItsNumber) {
  const vehicle::Vehicle v = test::omnimorph();
  const physics::Effect* scale = physics::find_effect("rotor_thrust_scale");
  std::vector<double> theta(static_cast<std::size_t>(scale->parameter_count()), 0.0);
  theta[4] = -0.05;
  test::Flown f;
  f.sway = 0.2;
  const auto r = test::fly(v, {{scale, theta}}, f);
  Options o;
  o.rollouts = false;
  o.threads = 2;
  o.only = {"payload_mass",  "thrust_scale",      "com_offset",          "rotor_thrust_scale",
            "constant_pull", "attachment_torque", "rotor_position_error"};
  o.tolerance.thrust_scale = 0.001;
  o.tolerance.torque_trim = 0.001;
  // by default 2 % each, and 2 % of the arm: 5 % of one rotor among eight is calibration
  o.tolerance.rotor_scale = 0.002;
  o.tolerance.center_of_mass = 0.001;
  const auto d = diagnose({&r, 1}, {}, v, o);
  ASSERT_TRUE(d) << d.error().text();
  ASSERT_EQ(d->findings.size(), 1u) << d->summary;
  EXPECT_EQ(d->findings[0].effect, "rotor_thrust_scale");
  ASSERT_EQ(d->findings[0].parameters.size(), 1u);
  EXPECT_EQ(d->findings[0].parameters[0].name, "scale_5");
  EXPECT_NEAR(d->findings[0].parameters[0].value, -0.05, 0.01);
  ASSERT_EQ(d->model.size(), 1u);
  EXPECT_EQ(d->model[0].theta.size(), theta.size()) << "the model holds the effect of the library";
}

}  // namespace
}  // namespace omniflight::diagnosis
