// Where no law is quite right, small errors are everywhere: they are no effect, and the flight shows their
// size.
#include <random>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_physics/correction.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

test::Flown flown() {
  test::Flown f;
  f.duration_s = 40;
  f.sway = 0.2;
  return f;
}

/// Every force follows every speed and rate: RMS about `share` of the weight each, signs and sizes by chance.
std::vector<physics::ActiveEffect> small_errors(const vehicle::Vehicle& v, double share) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<physics::ActiveEffect> out;
  for (int channel = 0; channel < 3; ++channel)
    for (const int quantity : {0, 1, 2, 6, 7, 8}) {
      physics::Correction c;
      c.channel = channel;
      c.feature.first = quantity;
      c.coefficient = share * v.mass * kGravity * normal(random) / 0.15;  // m/s and rad/s of this flight
      out.push_back(physics::as_effect(c));
    }
  return out;
}

double factor_of(const Diagnosis& d, const std::string& kind) {
  for (const Decision& decision : d.decisions)
    if (decision.about == "tolerance: " + kind) return decision.statistic;
  ADD_FAILURE() << kind << " is not among the decisions";
  return 0;
}

Diagnosis answer(const std::vector<physics::ActiveEffect>& world, double discrepancy) {
  const vehicle::Vehicle v = test::omnimorph();
  const recording::Recording r = test::fly(v, world, flown());
  Options o;
  o.threads = 2;
  o.tolerance.discrepancy = discrepancy;
  o.only = {"rotor_drag", "parasitic_drag", "axial_inflow", "wind", "cable_drag", "guide_friction"};
  auto d = diagnose(std::span(&r, 1), {}, v, o);
  EXPECT_TRUE(d) << d.error().text();
  return d ? *d : Diagnosis{};
}

TEST(Discrepancy, SmallErrorsEverywhereAreNoEffect) {
  const auto world = small_errors(test::omnimorph(), 0.006);
  const Diagnosis without = answer(world, 0), with = answer(world, Options{}.tolerance.discrepancy);
  std::printf("without: %s\nwith:    %s\n", without.summary.c_str(), with.summary.c_str());
  EXPECT_FALSE(without.findings.empty() && without.unexplained.empty());
  EXPECT_TRUE(with.findings.empty() && with.unexplained.empty());
  EXPECT_GE(factor_of(with, "force_discrepancy"), 0.25);
}

TEST(Discrepancy, IsNothingWhereTheLibraryIsRight) {
  const Diagnosis d = answer({{physics::find_effect("rotor_drag"), {3e-4}}}, Options{}.tolerance.discrepancy);
  EXPECT_LE(factor_of(d, "force_discrepancy"), 0.125);
  EXPECT_LE(factor_of(d, "torque_discrepancy"), 0.125);
  ASSERT_EQ(d.findings.size(), 1u) << d.summary;
  EXPECT_EQ(d.findings[0].effect, "rotor_drag");
}

}  // namespace
}  // namespace omniflight::diagnosis
