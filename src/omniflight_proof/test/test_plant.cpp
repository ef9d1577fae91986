// The nominal vehicle in MuJoCo obeys the laws of mechanics and refuses what is not physical.
#include <cmath>
#include <limits>

#include "fixture.hpp"

namespace omniflight::proof {
namespace {

TEST(Plant, FallsFreely) {
  MujocoPlant plant = make({}, {.p_WB = Vec3(0, 0, 3), .v_WB_W = Vec3(0.4, 0, 0)});
  run(plant, 0.5, false);
  expect_near(plant.body().p_WB, Vec3(0.2, 0, 3 - 0.5 * kGravity * 0.25), 1e-9, "position");
  expect_near(plant.specific_force(), Vec3::Zero(), 1e-9, "a falling accelerometer reads nothing");
}

TEST(Plant, TumblingWithoutTorqueKeepsAngularMomentumAndEnergy) {
  const Vec3 w(3, -2, 5);
  World world;
  world.body.inertia_scale = Vec3(1, 1.3, 1.6);  // no symmetry
  MujocoPlant plant = make(world, {.p_WB = Vec3(0, 0, 500), .w_WB_B = w});
  const Mat3 s = world.body.inertia_scale.cwiseSqrt().asDiagonal();
  const Mat3 J = s * plant.vehicle().inertia * s;
  const Vec3 before = J * w;
  run(plant, 2, false);
  const RigidState& b = plant.body();
  expect_near(b.q_WB * (J * b.w_WB_B), before, 0.01 * before.norm(), "angular momentum in the world");
  EXPECT_NEAR(b.w_WB_B.dot(J * b.w_WB_B), w.dot(before), 0.02 * w.dot(before));
  EXPECT_GT((b.w_WB_B - w).norm(), 0.5) << "it must have tumbled";
}

TEST(Plant, HoversOnTheThrustOfTheVehicleFile) {
  MujocoPlant plant = hovering({});
  expect_near(plant.acceleration(), Vec3::Zero(), 1e-6);
  EXPECT_LT(plant.unmodelled_wrench().norm(), 1e-9) << "nothing is left out of the nominal world";
  EXPECT_NEAR(plant.mechanical_power(),
              8 * 0.0165 * plant.vehicle().mass * kGravity / 8 * plant.rotor_speed()[0], 1e-6);
}

TEST(Plant, RotorWrenchIsThatOfTheGeometryAtAnyTilt) {
  for (const double alpha_deg : {0.0, 30.0, 54.7}) {
    const double alpha = to_radians(alpha_deg);
    const RigidState start{.p_WB = Vec3(0, 0, 5), .q_WB = from_roll_pitch_yaw(Vec3(0.4, -0.7, 1.1))};
    MujocoPlant plant = make({}, start, alpha);
    const std::vector<double> speeds{300, -500, 700, 200, 650, -800, 400, 900};
    plant.set_command(speeds, alpha);
    run(plant, 0.5, true);
    run(plant, 0.001, false);
    const auto& v = plant.vehicle();
    vehicle::RotorVector u(8);
    for (int i = 0; i < 8; ++i)
      u[i] = v.rotors[static_cast<std::size_t>(i)].thrust(speeds[static_cast<std::size_t>(i)]);
    const Vec6 wrench = v.allocation_matrix(alpha) * u;
    const Vec3 a = plant.body().q_WB * wrench.head<3>() / v.mass - kGravity * Vec3::UnitZ();
    expect_near(plant.acceleration(), a, 0.02, "linear");
    const Vec3 w = plant.body().w_WB_B;
    expect_near(v.inertia * plant.angular_acceleration() + w.cross(v.inertia * w), wrench.tail<3>(), 1e-6,
                "angular");
  }
}

TEST(Plant, MotorsFollowTheirTimeConstant) {
  MujocoPlant plant = make({});
  plant.set_command(std::vector<double>(8, 600.0), 0);
  run(plant, 0.015, true);
  EXPECT_NEAR(plant.rotor_speed()[3], 600 * (1 - std::exp(-1.0)), 1e-9);
}

TEST(Plant, CentreOfMassAndPayloadMoveAsHandFormulasSay) {
  World world;
  world.body.payload = 0.2;
  world.body.payload_p_B = Vec3(0.05, 0, -0.1);
  world.body.com_shift_B = Vec3(0.01, -0.004, 0);
  MujocoPlant plant = hovering(world);
  const double m = plant.vehicle().mass;
  const Quat world_to_body = plant.body().q_WB.conjugate();
  const Vec3 a = world_to_body * plant.acceleration(), g = world_to_body * Vec3(0, 0, -kGravity);
  const Vec3 dw = plant.angular_acceleration();
  const Vec3 w = plant.body().w_WB_B;
  const auto at = [&](const Vec3& p) { return Vec3(a + dw.cross(p) + w.cross(w.cross(p))); };
  // Newton for the two masses together
  const Vec3 total = m * (at(world.body.com_shift_B) - g) + 0.2 * (at(world.body.payload_p_B) - g);
  expect_near(total, Vec3(0, 0, m * kGravity), 1e-6);
  EXPECT_LT(plant.unmodelled_wrench()[2], -1.0) << "it carries the payload";
  EXPECT_GT(plant.unmodelled_wrench()[4], 0.05) << "a load in front turns the nose down";
}

TEST(Plant, SameCallsGiveTheSameBitsAndResetStartsAgain) {
  World world;
  world.turbulence = Turbulence{.force_rms = 0.3, .torque_rms = 0.01};
  MujocoPlant a = make(world), b = make(world);
  for (MujocoPlant* plant : {&a, &b}) {
    plant->set_command(hover_speeds(plant->vehicle()), 0);
    run(*plant, 1.0, false);
  }
  EXPECT_EQ(a.body().p_WB, b.body().p_WB);
  const Vec3 first = a.body().p_WB;
  a.reset(1);
  a.set_command(hover_speeds(a.vehicle()), 0);
  run(a, 1.0, false);
  EXPECT_EQ(a.body().p_WB, first);
  a.reset(2);
  a.set_command(hover_speeds(a.vehicle()), 0);
  run(a, 1.0, false);
  EXPECT_GT((a.body().p_WB - first).norm(), 1e-3) << "another seed is another wind";
}

TEST(Plant, StaysWhereItIsHeldAndFallsWhenReleased) {
  World world;
  world.slung_ball.emplace();
  MujocoPlant plant = make(world);
  run(plant, 0.3, true);
  EXPECT_EQ(plant.body().p_WB, Vec3(0, 0, 1.5));
  run(plant, 0.1, false);
  EXPECT_NEAR(plant.body().p_WB.z(), 1.5 - 0.5 * kGravity * 0.01, 1e-3);
}

TEST(Plant, RefusesWhatIsNotPhysicalByFieldAndUnit) {
  const vehicle::Vehicle v = omnimorph();
  const auto refusal = [&](const World& world, RigidState start = {.p_WB = Vec3(0, 0, 1)}) {
    const auto plant = MujocoPlant::create(v, world, {.initial = start});
    return plant ? std::string("accepted") : plant.error().text();
  };
  World world;
  world.body.payload = -0.5;
  EXPECT_NE(refusal(world).find("body.payload_kg: is -0.5 kg, outside [0, 100] kg"), std::string::npos)
      << refusal(world);
  world = {};
  world.body.com_shift_B.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(world).find("body.com_shift_m: is nan m"), std::string::npos) << refusal(world);
  world = {};
  world.flexible_arms = FlexibleArms{.pod_mass = 0.2};
  EXPECT_NE(refusal(world).find("flexible_arms.pod_mass_kg"), std::string::npos) << refusal(world);
  world = {};
  world.rotors.push_back({.rotor = 9});
  EXPECT_NE(refusal(world).find("omnimorph has 8 rotors"), std::string::npos) << refusal(world);
  world = {};
  world.timestep = 0.0007;
  EXPECT_NE(refusal(world).find("does not divide"), std::string::npos) << refusal(world);
  world = {};
  world.cable.emplace();
  EXPECT_NE(refusal(world, {.p_WB = Vec3(0, 0, 0.1)}).find("cable.attachment_m"), std::string::npos);
  world = {};
  world.overhead_rope = OverheadRope{.length = 1.0};
  EXPECT_NE(refusal(world).find("overhead_rope.length_m"), std::string::npos) << refusal(world);
  world = {};
  world.slung_ball = SlungBall{.length = 2};
  EXPECT_NE(refusal(world).find("below the floor"), std::string::npos) << refusal(world);
  EXPECT_NE(refusal({}, {.p_WB = Vec3(0, NAN, 1)}).find("initial: is not finite: position y is nan m"),
            std::string::npos)
      << refusal({}, {.p_WB = Vec3(0, NAN, 1)});
  EXPECT_NE(refusal({}, {.w_WB_B = Vec3(0, 0, INFINITY)}).find("angular velocity z is inf rad/s"),
            std::string::npos);
  EXPECT_NE(refusal({}, {.p_WB = Vec3(0, 0, 950)})
                .find("initial: is 950.000000 m from the origin, at most 900.000000 m"),
            std::string::npos)
      << refusal({}, {.p_WB = Vec3(0, 0, 950)});
  const auto tilted = MujocoPlant::create(v, {}, {.initial = {}, .initial_alpha = NAN});
  ASSERT_FALSE(tilted);
  EXPECT_NE(tilted.error().text().find("initial_alpha: is nan rad"), std::string::npos);
  vehicle::Vehicle light = v;
  light.mass = -1;
  const auto lifted = MujocoPlant::create(light, {}, {});
  ASSERT_FALSE(lifted);
  EXPECT_NE(lifted.error().text().find("mass: is -1.000000 kg, must be finite and above 0 kg"),
            std::string::npos)
      << lifted.error().text();
}

TEST(Plant, RefusesCommandsThatAreNoNumbers) {
  MujocoPlant plant = make({});
  std::vector<double> speeds(8, 500.0);
  EXPECT_TRUE(plant.set_command(speeds, 0));
  speeds[2] = std::nan("");
  EXPECT_FALSE(plant.set_command(speeds, 0));
  EXPECT_FALSE(plant.set_command(std::vector<double>(7, 1.0), 0));
  EXPECT_FALSE(plant.set_command(std::vector<double>(8, 1.0), INFINITY));
}

TEST(Plant, StopsWhenTheIntegrationExplodes) {
  World world;
  world.laws.push_back({.kind = Law::Kind::lift, .gain = 1000, .axis = Vec3::UnitX()});
  MujocoPlant plant = make(world, {.p_WB = Vec3(0, 0, 3), .v_WB_W = Vec3(0, 3, 3)});
  Status ok;
  for (int k = 0; k < 2000 && ok; ++k) ok = plant.step();
  ASSERT_FALSE(ok);
  const std::string text = ok.error().text();
  EXPECT_NE(text.find("left every reasonable range: "), std::string::npos) << text;
  EXPECT_NE(text.find(" is "), std::string::npos) << text;
  EXPECT_NE(text.find(" at t = "), std::string::npos) << text;
}

TEST(Plant, DoesNotStartAgainByItselfWhenARopeExplodes) {
  // mj_step, which integrates implicitly, answers a bad number by going back to the start of the flight
  World world;
  world.integrator = Integrator::implicit;
  world.timestep = 0.0005;
  world.cable = Cable{.length = 0.5, .links = 5};
  world.settle = 0.1;
  world.laws.push_back({.kind = Law::Kind::lift, .gain = 1000, .axis = Vec3::UnitX()});
  MujocoPlant plant = make(world, {.p_WB = Vec3(0.3, 0, 3), .v_WB_W = Vec3(0, 3, 3)});
  Status ok;
  int steps = 0;
  for (; steps < 3000 && ok; ++steps) ok = plant.step();
  ASSERT_FALSE(ok);
  EXPECT_LT(steps, 20) << ok.error().text();
  EXPECT_NE(ok.error().text().find("left every reasonable range"), std::string::npos) << ok.error().text();
  world.settle = 0;
  MujocoPlant shot = make(world, {.p_WB = Vec3(0.3, 0, 3), .v_WB_W = Vec3(0, 1e11, 0)});
  ok = shot.step();
  ASSERT_FALSE(ok);
  EXPECT_NE(ok.error().text().find("of joint coordinate "), std::string::npos) << ok.error().text();
}

TEST(Plant, VelocitiesBelongToTheTimeOfThePose) {
  // Rotors that change their speeds 2 Hz quick turn it. What the speeds of a moment give as angular velocity
  // in closed form, and attitude, are those of that moment: half a step late would be 0.6 % of the torque.
  MujocoPlant plant = make({}, {.p_WB = Vec3(0, 0, 500)});
  const auto& v = plant.vehicle();
  const double h = 0.001, rate = 2 * kPi * 2;
  Vec3 before, angle, torque_before, most, worst, worst_angle;
  for (Vec3* each : {&before, &angle, &torque_before, &most, &worst, &worst_angle}) each->setZero();
  for (int k = 0; k < 1000; ++k) {
    std::vector<double> speeds(8);
    for (std::size_t i = 0; i < 8; ++i)
      speeds[i] = 500 + 60 * std::sin(rate * k * h) * (v.rotors[i].p_BR.x() > 0 ? 1 : -1);
    plant.set_command(speeds, 0);
    ASSERT_TRUE(plant.step());
    vehicle::RotorVector u(8);
    for (int i = 0; i < 8; ++i)
      u[i] = v.rotors[static_cast<std::size_t>(i)].thrust(plant.rotor_speed()[static_cast<std::size_t>(i)]);
    const Vec3 torque = (v.allocation_matrix(0) * u).tail<3>();
    const Vec3 next = before + h * v.inertia.inverse() * 0.5 * (torque_before + torque);
    angle += 0.5 * h * (before + next);
    before = next;
    torque_before = torque;
    most = most.cwiseMax(next.cwiseAbs());
    worst = worst.cwiseMax((plant.body().w_WB_B - next).cwiseAbs());
    worst_angle = worst_angle.cwiseMax((log_rotation(plant.body().q_WB) - angle).cwiseAbs());
  }
  EXPECT_GT(most.y(), 0.2) << "it must have turned";
  EXPECT_LT(worst.y(), 1e-4 * most.y()) << "rad/s";
  EXPECT_LT(worst_angle.y(), 1e-4 * most.y()) << "rad; half a step of 1 ms would be 5e-4";
}

TEST(Plant, NamesTheStateThatLeavesItsRangeWithValueUnitAndRange) {
  const auto stopped = [](const RigidState& start) {
    MujocoPlant plant = make({}, start);
    Status ok;
    for (int k = 0; k < 20000 && ok; ++k) ok = plant.step();
    return ok ? std::string("flies on") : ok.error().text();
  };
  const auto expect = [](const std::string& text, const char* words) {
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  // it falls for ever; sideways fast; spins fast
  expect(stopped({.p_WB = Vec3(0, 0, 1)}), "the size of the position is 1000.");
  expect(stopped({.p_WB = Vec3(0, 0, 1)}), " m (reasonable: at most 1000 m) at t = 14.");
  expect(stopped({.p_WB = Vec3(0, 0, 1), .v_WB_W = Vec3(2000, 0, 0)}), "the size of the velocity is 2000.");
  expect(stopped({.p_WB = Vec3(0, 0, 1), .w_WB_B = Vec3(0, 0, 1500)}),
         "the size of the angular velocity is 1500.000000 rad/s (reasonable: at most 1000 rad/s)");
}

}  // namespace
}  // namespace omniflight::proof
