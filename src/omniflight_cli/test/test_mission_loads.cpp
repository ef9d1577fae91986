// A mission's payload and tether as effects of the plant, beside the vehicle that plans carry them with.
#include <gtest/gtest.h>

#include "../src/mission_loads.hpp"
#include "omniflight_simulation/plant.hpp"
#include "omniflight_vehicle/vehicle.hpp"

using namespace omniflight;
using namespace omniflight::cli;

namespace {

vehicle::Vehicle omnimorph() {
  return vehicle::load_vehicle(OMNIFLIGHT_SOURCE_ROOT "/configs/vehicles/omnimorph/omnimorph.yaml").value();
}

std::vector<TrajectoryKnot> at_height(double z) {
  TrajectoryKnot knot;
  knot.reference.p_WB = Vec3(0, 0, z);
  return {knot};
}

/// Where a vehicle is after 0.4 s of falling and turning with its rotors on.
RigidState flown(const vehicle::Vehicle& v, std::vector<physics::ActiveEffect> effects) {
  physics::Model model;
  model.effects = std::move(effects);
  simulation::PlantConfig config;
  config.initial.p_WB = Vec3(0, 0, 1.5);
  config.initial.q_WB = from_roll_pitch_yaw(Vec3(0.3, -0.2, 0.4));
  config.initial.w_WB_B = Vec3(0.5, -0.4, 0.8);
  config.initial_alpha = to_radians(30);
  auto plant = simulation::Plant::create(v, model, config).value();
  std::vector<double> speeds;
  for (const auto& rotor : v.rotors)
    speeds.push_back(std::sqrt(0.3 * rotor.max_thrust / rotor.thrust_coefficient) *
                     (1 + 0.1 * speeds.size()));
  EXPECT_TRUE(plant.set_command(speeds, to_radians(30)));
  for (int i = 0; i < 400; ++i) EXPECT_TRUE(plant.step());
  return plant.body();
}

TEST(MissionLoads, APayloadMovesThePlantAsItMovesTheVehicleOfThePlan) {
  planning::Mission mission;
  mission.payload = planning::Payload{.mass = 0.2, .p_B = Vec3(0, 0, -0.15)};
  const auto v = omnimorph();
  const auto effects = effects_of_loads(mission, v, at_height(1.5));
  ASSERT_TRUE(effects) << effects.error().text();
  const RigidState as_effects = flown(v, *effects), as_vehicle = flown(carrying(v, *mission.payload), {});
  EXPECT_LT((as_effects.p_WB - as_vehicle.p_WB).norm(), 1e-7);
  EXPECT_LT(as_effects.q_WB.angularDistance(as_vehicle.q_WB), 1e-6);
  EXPECT_GT((flown(v, {}).p_WB - as_vehicle.p_WB).norm(), 0.01) << "the payload is felt";
}

TEST(MissionLoads, ATetherIsHungFromBelowAndARopeFromAbove) {
  planning::Mission mission;
  mission.tether = planning::Tether{
      .anchor_W = Vec3(0, 0, 0.5), .attachment_B = Vec3(0, 0, -0.1), .length = 3.0, .linear_mass = 0.1};
  const auto below = effects_of_loads(mission, omnimorph(), at_height(1.5));
  ASSERT_TRUE(below) << below.error().text();
  ASSERT_EQ(below->size(), 2u);
  EXPECT_EQ((*below)[0].effect->info().id, "hung_cable");
  EXPECT_EQ((*below)[0].theta, (std::vector<double>{0.1, 0.5, 3.0}));
  EXPECT_EQ((*below)[1].effect->info().id, "attachment_torque");

  mission.tether->anchor_W.z() = 3.0;
  const auto above = effects_of_loads(mission, omnimorph(), at_height(1.5));
  ASSERT_TRUE(above) << above.error().text();
  EXPECT_EQ((*above)[0].effect->info().id, "overhead_rope");

  mission.tether->anchor_W.z() = 1.4;  // level with the attachment
  std::vector<TrajectoryKnot> past = at_height(1.4);
  past.push_back(at_height(1.6)[0]);
  const auto level = effects_of_loads(mission, omnimorph(), past);
  ASSERT_FALSE(level);
  EXPECT_NE(level.error().message.find("passes the height of the anchor (1.400 m)"), std::string::npos);
}

TEST(MissionLoads, ALoadBeyondTheEffectsIsRefusedWithItsNumbers) {
  planning::Mission mission;
  mission.file = "heavy.yaml";
  mission.payload = planning::Payload{.mass = 1.0, .p_B = Vec3(0.3, 0, 0)};
  const auto refused = effects_of_loads(mission, omnimorph(), at_height(1.5));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("com_offset with x = "), std::string::npos)
      << refused.error().message;
  EXPECT_EQ(refused.error().where, "heavy.yaml: payload");
}

TEST(MissionLoads, AMissionWithoutLoadsHasNone) {
  EXPECT_TRUE(effects_of_loads({}, omnimorph(), at_height(1)).value().empty());
}

}  // namespace
