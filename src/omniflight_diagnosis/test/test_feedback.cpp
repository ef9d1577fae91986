// Feedback makes rotors answer to turbulence. That is no effect.
#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// Slow turbulence that the rotors cancel after a quarter of a second.
test::Flown buffeted(std::uint64_t seed) {
  test::Flown f;
  f.force_noise_N = 0.3;
  f.torque_noise_Nm = 0.02;
  f.correlation_s = 1.0;
  f.answer_s = 0.25;
  f.sway = 0.15;
  f.seed = seed;
  return f;
}

Options options() {
  Options o;
  o.rollouts = false;
  o.threads = 2;
  o.only = {"payload_mass",  "thrust_scale",    "com_offset",   "inertia_error",
            "rotor_drag",    "parasitic_drag",  "wind",         "hung_cable",
            "constant_pull", "tilt_efficiency", "thrust_curve", "attachment_torque"};
  o.tolerance.thrust_scale = 0.001;
  o.tolerance.air_density = 0;  // told: unknown, it is worth more than the payload
  o.tolerance.torque_trim = 0.001;
  return o;
}

TEST(Feedback, TurbulenceThatTheRotorsCancelIsNoEffect) {
  const vehicle::Vehicle v = test::omnimorph();
  for (const std::uint64_t seed : {1u, 2u}) {
    const auto real = test::fly(v, {}, buffeted(seed));
    const auto d = diagnose({&real, 1}, {}, v, options());
    ASSERT_TRUE(d) << d.error().text();
    EXPECT_EQ(d->verdict, Verdict::nothing_missing) << "seed " << seed << ": " << d->summary;
  }
}

TEST(Feedback, APayloadUnderTurbulenceIsNamedWithItsMass) {
  const vehicle::Vehicle v = test::omnimorph();
  const std::vector<physics::ActiveEffect> load{{physics::find_effect("payload_mass"), {0.12}}};
  for (const std::size_t flights : {1u, 2u}) {
    const std::vector<recording::Recording> real{test::fly(v, load, buffeted(3)),
                                                 test::fly(v, load, buffeted(4))};
    const auto d = diagnose(std::span(real.data(), flights), {}, v, options());
    ASSERT_TRUE(d) << d.error().text();
    ASSERT_FALSE(d->findings.empty()) << d->summary;
    const Finding& f = d->findings.front();
    bool meant = f.effect == "payload_mass";
    for (const std::string& other : f.cannot_be_told_apart_from) meant = meant || other == "payload_mass";
    EXPECT_TRUE(meant) << d->summary;
    if (f.effect == "payload_mass") {
      EXPECT_NEAR(f.parameters[0].value, 0.12, 0.01);
    }
  }
}

}  // namespace
}  // namespace omniflight::diagnosis
