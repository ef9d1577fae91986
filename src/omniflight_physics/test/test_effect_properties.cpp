// What effects state of themselves for engines that know none by its id.
#include <algorithm>

#include "effect_testing.hpp"
#include "omniflight_physics/prior.hpp"

namespace omniflight::physics::testing {
namespace {

bool has_parameter(const EffectInfo& info, const std::string& name) {
  return std::any_of(info.parameters.begin(), info.parameters.end(),
                     [&](const Parameter& p) { return p.name == name; });
}

std::vector<double> typical_of(const Effect& effect) {
  std::vector<double> out;
  for (const Parameter& p : effect.info().parameters) out.push_back(p.typical);
  return out;
}

TEST(EffectProperties, NameParametersThatThereAre) {
  for (const Effect* e : builtin_effects()) {
    const EffectInfo& info = e->info();
    for (const std::string& name : info.one_value) EXPECT_TRUE(has_parameter(info, name)) << info.id;
    for (const std::string& name : info.words.needs) EXPECT_TRUE(has_parameter(info, name)) << info.id;
  }
}

TEST(EffectProperties, ParametersOfARotorActThroughThatRotorAlone) {
  int by_rotor = 0;
  for (const Effect* e : builtin_effects()) {
    const int each = e->info().parameters_per_rotor;
    if (each == 0) continue;
    ++by_rotor;
    ASSERT_EQ(e->parameter_count() % each, 0) << e->info().id;
    for (int turning = 0; turning < 8; ++turning) {
      Situation s = six_states()[1];
      for (int r = 0; r < 8; ++r)
        if (r != turning) s.rotors[static_cast<std::size_t>(r)].thrust = 0;
      const std::vector<double> theta(static_cast<std::size_t>(e->parameter_count()), 0.0);
      Vec6 value;
      Eigen::Matrix<double, 6, Eigen::Dynamic> columns(6, e->parameter_count());
      e->wrench_with_jacobian(s, theta.data(), value.data(), columns.data());
      EXPECT_GT(columns.middleCols(turning * each, each).norm(), 0.0) << e->info().id;
      columns.middleCols(turning * each, each).setZero();
      EXPECT_EQ(columns.norm(), 0.0) << e->info().id << ", rotor " << turning + 1;
    }
  }
  EXPECT_EQ(by_rotor, 3) << "thrust, place and axis of single rotors";
}

TEST(EffectProperties, AnEffectThatTellsTheFloorDependsOnItsHeight) {
  int telling = 0;
  for (const Effect* e : builtin_effects()) {
    if (!e->info().tells_floor_height) continue;
    ++telling;
    Situation s = hover(0.2);
    const Vec6 above = wrench_of(e->info().id.c_str(), s, typical_of(*e));
    s.environment.floor_z -= 0.1;
    EXPECT_GT((above - wrench_of(e->info().id.c_str(), s, typical_of(*e))).norm(), 0.01 * above.norm());
  }
  EXPECT_GT(telling, 0);
}

TEST(EffectProperties, AWrenchThatNoMotionImpliesSaysWhatBecomesOfIt) {
  int asked_otherwise = 0;
  for (const Effect* e : builtin_effects()) {
    const bool not_asked = e->info().stage == Stage::wrench && !e->can_replay();
    EXPECT_EQ(not_asked, !e->info().not_asked_for.empty()) << e->info().id;
    asked_otherwise += not_asked;
  }
  EXPECT_GT(asked_otherwise, 0);
}

TEST(EffectProperties, AnUnrecordedFormStandsForItsEffectAndNeedsNoMoreThanItsRival) {
  int forms = 0;
  for (const Effect* e : builtin_effects()) {
    const Effect* form = e->unrecorded_form();
    if (!form) continue;
    ++forms;
    EXPECT_EQ(form->info().id, e->info().id);
    EXPECT_TRUE(form->can_replay()) << "it is asked of the wrench";
    EXPECT_EQ(e->unrecorded_form(), form) << "fits refer to effects by address";
    const std::vector<double> theta = typical_of(*form), whole = e->from_unrecorded_form(theta);
    EXPECT_EQ(static_cast<int>(whole.size()), e->parameter_count());
    ASSERT_FALSE(e->info().aliases.empty());
    const Effect* rival = find_effect(e->info().aliases.front());
    ASSERT_NE(rival, nullptr);
    for (const std::string& signal : form->info().signals)
      EXPECT_NE(std::find(rival->info().signals.begin(), rival->info().signals.end(), signal),
                rival->info().signals.end())
          << signal;
  }
  EXPECT_GT(forms, 0);
}

TEST(EffectProperties, WindIsAmplitudesAndAShape) {
  const auto& parameters = find_effect("wind")->info().parameters;
  EXPECT_TRUE(is_amplitude(parameters[0]));
  EXPECT_TRUE(is_amplitude(parameters[1]));
  EXPECT_FALSE(is_amplitude(parameters[2]));
}

TEST(EffectProperties, APilotIsToldWhatIsKnown) {
  const PilotWords& cable = find_effect("hung_cable")->info().words;
  EXPECT_EQ(say(cable, KnownValues({{"linear_density", 0.3}, {"start_height", 1.06}})),
            "a cable of 0.30 kg/m from 1.06 m up");
  EXPECT_EQ(say(cable, KnownValues({{"linear_density", 0.3}})), "a cable of 0.30 kg/m");
  EXPECT_EQ(say(cable, KnownValues({{"start_height", 1.06}})), "") << "how heavy it is, must be known";
  EXPECT_EQ(say(find_effect("rotor_drag")->info().words, KnownValues({{"coefficient", 1e-5}})), "");
  EXPECT_EQ(say(find_effect("mocap_offset")->info().words, KnownValues({{"x", 0.012}, {"yaw", 0.01}})),
            "the motion capture body is off by 12 mm and 0.57 deg");
}

TEST(EffectProperties, WhatCannotBeIsRefusedByTheEffect) {
  RigidState start;
  start.p_WB.z() = 1;
  const Effect& rope = *find_effect("overhead_rope");
  const double reaches[] = {0.05, 3.2, 2.3}, is_short[] = {0.05, 3.2, 2.0};
  EXPECT_TRUE(rope.check_feasible(cube(), start, reaches));
  const Status refused = rope.check_feasible(cube(), start, is_short);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "effects.overhead_rope.length");
  EXPECT_EQ(refused.error().message,
            "is 2 m, shorter than the 2.2 m from the vehicle at 1 m up to the anchor (anchor_height 3.2 m)");
  const Effect& sensor = *find_effect("rotor_speed_sensor_fault");
  std::vector<double> ninth = typical_of(sensor);
  ninth[0] = 9;
  const Status absent = sensor.check_feasible(cube(), start, ninth.data());
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().message, "is 9, and cube has 8 rotors");
}

}  // namespace
}  // namespace omniflight::physics::testing
