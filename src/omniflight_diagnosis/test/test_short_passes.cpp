// Effects that act in short bursts: a vehicle over which another one passes now and then.
#include <cmath>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_physics/neighbour_track.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr const char* kWash = "neighbour_downwash";

/// A flight of half a minute whose thrust is only modelled, and a neighbour that crosses six times 0.4 to 1 m
/// above it, half a second each; strength [N m2] of its wash.
recording::Recording passed_over(const vehicle::Vehicle& v, double strength, std::uint64_t seed) {
  test::Flown flown;
  flown.seed = seed;
  flown.alpha = 0.2;  // rotors nearly upright: what lifts is what they thrust
  recording::Recording r = test::fly(v, {}, flown);
  recording::Signal thrust = r.signals["rotor_speed"];
  thrust.name = "thrust_model";
  thrust.unit = "N";
  for (Eigen::Index i = 0; i < thrust.size(); ++i)
    for (Eigen::Index k = 0; k < thrust.width(); ++k)
      thrust.values(i, k) = v.rotors[static_cast<std::size_t>(k)].thrust(std::abs(thrust.values(i, k)));
  r.signals.erase("rotor_speed");
  r.signals["thrust_model"] = thrust;
  recording::Signal track = r.signals["position"];
  track.name = "neighbour1_position";
  Eigen::MatrixXd& acc = r.signals["acc"].values;
  const std::vector<double> theta{strength, 0.114, 0.2};
  for (Eigen::Index i = 0; i < acc.rows(); ++i) {
    const double t = track.t_s[static_cast<std::size_t>(i)];
    RigidState x;
    x.p_WB = test::path(t, flown);
    const Vec3 other =
        x.p_WB + Vec3(2 * std::sin(2 * kPi * t / 10), 0.1, 0.7 + 0.3 * std::sin(2 * kPi * t / 25));
    track.values.row(i) = other.transpose();
    physics::Situation s;
    physics::prepare(v, x, flown.alpha, std::vector<double>(v.rotors.size(), 300.0), {}, {}, s);
    physics::set_neighbours(std::vector<physics::NeighbourTrack>{{{t}, {other}}}, t, s);
    physics::Wrench w;
    physics::find_effect(kWash)->add_wrench(s, theta.data(), w);
    acc.row(i) += w.force_B.transpose() / v.mass;
  }
  r.signals["neighbour1_position"] = track;
  return r;
}

TEST(ShortPasses, TheWashIsNamedWithItsStrength) {
  const vehicle::Vehicle v = test::omnimorph();
  for (const std::uint64_t seed : {4u}) {
    const auto r = passed_over(v, 0.4, seed);
    const auto d = diagnose(std::span(&r, 1), {}, v);
    ASSERT_TRUE(d) << d.error().text();
    ASSERT_EQ(d->findings.size(), 1u) << d->summary;
    EXPECT_EQ(d->findings[0].effect, kWash);
    EXPECT_NEAR(d->findings[0].parameters[0].value, 0.4, 0.1) << d->summary;
    EXPECT_TRUE(d->unexplained.empty()) << d->summary;
  }
}

TEST(ShortPasses, ANeighbourWithoutAWashIsNoFinding) {
  const vehicle::Vehicle v = test::omnimorph();
  for (const std::uint64_t seed : {3u, 4u}) {
    const auto r = passed_over(v, 0.0, seed);
    const auto d = diagnose(std::span(&r, 1), {}, v);
    ASSERT_TRUE(d) << d.error().text();
    EXPECT_EQ(d->verdict, Verdict::nothing_missing) << seed << ": " << d->summary;
  }
}

}  // namespace
}  // namespace omniflight::diagnosis
