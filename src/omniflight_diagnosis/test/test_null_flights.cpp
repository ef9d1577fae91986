// What is named must stand out from what the same fits find where nothing is left out.
#include <gtest/gtest.h>

#include <cstdlib>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using test::omnimorph;

bool names(const Diagnosis& d, const std::string& id) {
  for (const Finding& f : d.findings)
    if (f.effect == id) return true;
  return false;
}

/// Diagnoses a flight with 0.25 kg too much, where the flights again carry `mass` kg too much.
Result<Diagnosis> diagnose_against(double mass, int& flown_again) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown flown;
  flown.duration_s = 15;
  const auto with = [&](double kg) {
    std::vector<physics::ActiveEffect> effects;
    if (kg > 0) effects.push_back({physics::find_effect("payload_mass"), {kg}});
    return test::fly(v, effects, flown);
  };
  const auto real = with(0.25);
  Options o;
  o.only = {"payload_mass", "rotor_drag"};
  o.rollouts = false;
  o.reflights = 5;
  o.refly = [&](const Eigen::MatrixXd& wrench, double, double rate_hz,
                std::uint64_t seed) -> Result<recording::Recording> {
    EXPECT_EQ(wrench.cols(), 6);
    EXPECT_TRUE(wrench.allFinite());
    EXPECT_NEAR(static_cast<double>(wrench.rows()), 15 * rate_hz, rate_hz);
    // as strong as what disturbed the flight
    EXPECT_NEAR(std::sqrt(wrench.col(0).squaredNorm() / static_cast<double>(wrench.rows())), 0.15, 0.08);
    ++flown_again;
    flown.seed = 100 + seed;
    return with(mass);
  };
  return diagnose({&real, 1}, {}, v, o);
}

TEST(NullFlights, AnEffectThatNominalFlightsDoNotShowStaysNamed) {
  int flown = 0;
  const auto d = diagnose_against(0, flown);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(flown, 5);
  EXPECT_TRUE(names(*d, "payload_mass")) << d->summary;
}

TEST(NullFlights, AnEffectThatFlightsShowWhereNothingIsLeftOutIsNotNamed) {
  int flown = 0;
  const auto d = diagnose_against(0.25, flown);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(flown, 5);
  EXPECT_FALSE(names(*d, "payload_mass")) << d->summary;
}

}  // namespace
}  // namespace omniflight::diagnosis
