// Which of several laws that do equally well is named.
#include "../src/costs.hpp"
#include "../src/members.hpp"
#include "../src/naming.hpp"

#include <algorithm>

#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;
using physics::find_effect;

/// What is named on a flight with these effects when only `ids` are offered, with its set.
std::vector<std::vector<std::string>> names(const std::vector<ActiveEffect>& world,
                                            const std::vector<std::string>& ids, const test::Flown& f) {
  const vehicle::Vehicle v = test::omnimorph();
  const Options o;
  const auto flight = prepare_flight(test::fly(v, world, f), v, o);
  EXPECT_TRUE(flight);
  if (!flight) return {};
  const Flight* one[] = {&*flight};
  const Problem problem(one, v, o);
  std::vector<const physics::Effect*> offered;
  for (const std::string& id : ids) offered.push_back(find_effect(id));
  Naming naming = name_effects(problem, offered, o);
  tell_rivals(problem, o, naming);
  std::vector<std::vector<std::string>> out;
  for (std::size_t k = 0; k < naming.named.size(); ++k) {
    out.push_back({naming.model.effects[k].effect->info().id});
    for (const Alternative& a : naming.named[k].set) out.back().push_back(a.effect);
  }
  std::sort(out.begin(), out.end());
  return out;
}

TEST(Naming, ATorqueBesideACableIsItsLeverWhereBothDoAsWell) {
  // on a flight that hardly climbs, the lever of the carried length and an offset centre of mass are one
  test::Flown level;
  level.climb_m = 0.05;
  level.sway = 0.2;
  const std::vector<ActiveEffect> lever{{find_effect("attachment_torque"), {0.02, 0, -0.05, 0.0}}};
  const std::vector<std::string> torques{"com_offset", "attachment_torque"};
  const auto alone = names(lever, torques, level);
  ASSERT_EQ(alone.size(), 1u);
  EXPECT_EQ(alone[0][0], "com_offset") << "the catalogue's first";

  test::Flown climbing = level;
  climbing.climb_m = 0.7;
  std::vector<ActiveEffect> both{{find_effect("hung_cable"), {0.25, 0.1, 2.0}},
                                 {find_effect("attachment_torque"), {0.004, 0, -0.006, 0.0}}};
  const auto beside = names(both, {"com_offset", "attachment_torque", "hung_cable"}, climbing);
  ASSERT_EQ(beside.size(), 2u);
  EXPECT_EQ(beside[0][0], "attachment_torque");
  EXPECT_EQ(beside[1][0], "hung_cable");
}

TEST(Naming, WhatALoadAddsToACableIsWhatTheCablesLawLacks) {
  Fit fit;
  for (const char* id : {"hung_cable", "attachment_torque", "slung_load", "payload_mass", "inertia_error"}) {
    const physics::Effect* e = find_effect(id);
    fit.effects.push_back({e, std::vector<double>(static_cast<std::size_t>(e->parameter_count()), 0.0)});
  }
  EXPECT_TRUE(mends_another(fit, 2, {200, 400, 149, 100, 9000})) << "a quarter of the cable with its lever";
  EXPECT_FALSE(mends_another(fit, 2, {200, 400, 151, 100, 9000}));
  EXPECT_FALSE(mends_another(fit, 2, {2, 3, 50, 100, 9000})) << "no matter how strong another kind is";
  for (std::size_t k : {0, 1, 3, 4})
    EXPECT_FALSE(mends_another(fit, k, std::vector<double>(5, k == 3 ? 1 : 1e3))) << k;
}

TEST(Naming, ATieIsSmallBesideWhatIsExplained) {
  EXPECT_EQ(tie(10, 0), 3) << "what noise can do";
  EXPECT_NEAR(tie(300, 3), 30, 1e-9) << "some for simplicity";
  EXPECT_NEAR(tie(300, 2), 3, 1e-9);
  EXPECT_LT(tie(50000, 3), 1000) << "an articulated cable on MuJoCo: a load in its place costs 2800 nats";
  double before = 0;
  for (double gain = 1; gain < 1e6; gain *= 1.5) {
    EXPECT_GE(tie(gain, 3), std::max(before, tie(gain, 2))) << gain;
    before = tie(gain, 3);
  }
}

}  // namespace
}  // namespace omniflight::diagnosis
