// Forces that no effect of the library makes, described by what they depend on.
#include <gtest/gtest.h>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// A flight with a force [N, world] of the state and the time added to what the accelerometer feels.
template <class Law>
recording::Recording with_force(const vehicle::Vehicle& v, const test::Flown& f, Law law) {
  recording::Recording r = test::fly(v, {}, f);
  auto& acc = r.signals["acc"];
  for (Eigen::Index i = 0; i < acc.values.rows(); ++i) {
    const double t = acc.t_s[static_cast<std::size_t>(i)], h = 1e-3;
    const Vec3 velocity = (test::path(t + h, f) - test::path(t - h, f)) / (2 * h);
    acc.values.row(i) +=
        (test::attitude(t, f).conjugate() * Vec3(law(t, test::path(t, f), velocity)) / v.mass).transpose();
  }
  return r;
}

Diagnosis judged(const recording::Recording& r, const vehicle::Vehicle& v, const test::Flown& f) {
  Options o;
  o.rollouts = false;
  o.only = {"payload_mass", "thrust_scale", "com_offset", "rotor_drag", "constant_pull"};
  o.tolerance.thrust_scale = 0.001;
  o.tolerance.torque_trim = 0.001;
  o.refly = {[&](const Eigen::MatrixXd&, double, double, const auto&) -> Result<recording::Recording> {
    test::Flown still = f;
    still.force_noise_N = still.torque_noise_Nm = still.accelerometer_noise = still.gyro_noise =
        still.speed_noise = 0;
    return test::fly(v, {}, still);
  }};
  const auto d = diagnose({&r, 1}, {}, v, o);
  EXPECT_TRUE(d) << d.error().text();
  return d ? *d : Diagnosis{};
}

test::Flown flown(std::uint64_t seed) {
  test::Flown f;
  f.side_m = 0.6;
  f.sway = 0.1;
  f.seed = seed;
  return f;
}

TEST(Dictionary, NothingIsMadeOfNoise) {
  const vehicle::Vehicle v = test::omnimorph();
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const test::Flown f = flown(seed);
    const Diagnosis d = judged(test::fly(v, {}, f), v, f);
    EXPECT_TRUE(d.unexplained.empty()) << d.summary << " seed " << seed;
  }
}

TEST(Dictionary, AForceThatPulsatesDependsOnTime) {
  const vehicle::Vehicle v = test::omnimorph();
  const test::Flown f = flown(1);
  const auto r = with_force(v, f, [](double t, const Vec3&, const Vec3&) {
    return Vec3(0, 0.2 * std::sin(2 * 3.14159 * 1.3 * t), 0);
  });
  const Diagnosis d = judged(r, v, f);
  EXPECT_EQ(d.verdict, Verdict::unexplained);
  ASSERT_FALSE(d.unexplained.empty());
  EXPECT_EQ(d.unexplained[0].channel, "Fy");
  EXPECT_EQ(d.unexplained[0].depends_on.front(), "time");
  ASSERT_FALSE(d.unexplained[0].correction.empty());
  const CorrectionTerm& term = d.unexplained[0].correction.front();
  EXPECT_NEAR(term.frequency_hz, 1.3, 0.05);
  EXPECT_NEAR(term.coefficient, 0.2, 0.05);
  EXPECT_EQ(term.unit, "N");
}

TEST(Dictionary, AForceThatGrowsWithHeightDependsOnIt) {
  const vehicle::Vehicle v = test::omnimorph();
  const test::Flown f = flown(2);
  const auto r =
      with_force(v, f, [](double, const Vec3& p, const Vec3&) { return Vec3(1.0 * (p.z() - 0.7), 0, 0); });
  const Diagnosis d = judged(r, v, f);
  EXPECT_EQ(d.verdict, Verdict::unexplained);
  ASSERT_FALSE(d.unexplained.empty());
  EXPECT_EQ(d.unexplained[0].channel, "Fx");
  EXPECT_EQ(d.unexplained[0].depends_on.front(), "height");
  EXPECT_EQ(d.unexplained[0].frame, "world");
  ASSERT_FALSE(d.unexplained[0].correction.empty());
  const CorrectionTerm& term = d.unexplained[0].correction.front();
  // within one metre its square does as well
  const bool square = term.words == "height squared";
  EXPECT_TRUE(square || term.words == "height") << term.words;
  EXPECT_EQ(term.unit, square ? "N/m2" : "N/m");
  EXPECT_NEAR(square ? 2 * 0.7 * term.coefficient : term.coefficient, 1.0, 0.2);
  EXPECT_NE(d.summary.find(" " + term.unit + " times " + term.words), std::string::npos) << d.summary;

  // as a model: what is left of Fx shrinks where it was fitted and where it was not, and the file has it
  const auto of = [](const std::vector<ChannelFit>& all) {
    double before = 0, after = 0;
    for (const ChannelFit& c : all)
      if (c.channel == "Fx") before += c.rms_before, after += c.rms_after;
    return after / before;
  };
  EXPECT_LT(of(d.fit.in_sample), 0.7);
  EXPECT_LT(of(d.fit.held_out), 0.8);
  ASSERT_FALSE(d.model.empty());
  EXPECT_TRUE(physics::is_correction(d.model.back()));
  EXPECT_NE(model_yaml(d).find("corrections:\n  - channel: Fx\n    axes: world\n    follows: [height"),
            std::string::npos)
      << model_yaml(d);
}

}  // namespace
}  // namespace omniflight::diagnosis
