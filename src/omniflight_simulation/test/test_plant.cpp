// The plant obeys mechanics: free fall, momentum, energy, order of the integrator, delays, determinism.
#include <gtest/gtest.h>

#include <cstdlib>

#include "omniflight_simulation/plant.hpp"
#include "omniflight_simulation/sensors.hpp"

namespace omniflight::simulation {
namespace {

vehicle::Vehicle omnimorph() {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  auto v = vehicle::load_vehicle("omnimorph");
  if (!v) throw std::runtime_error(v.error().text());
  return *v;
}

physics::Model with(const std::string& id, std::vector<double> theta) {
  physics::Model m;
  m.effects.push_back({physics::find_effect(id), std::move(theta)});
  return m;
}

Plant make(const vehicle::Vehicle& v, const physics::Model& m, const PlantConfig& c) {
  auto p = Plant::create(v, m, c);
  if (!p) throw std::runtime_error(p.error().text());
  return *p;
}

TEST(Plant, FallsFreely) {
  PlantConfig c;
  c.initial.p_WB.z() = 10;
  Plant plant = make(omnimorph(), {}, c);
  for (int k = 0; k < 1000; ++k) ASSERT_TRUE(plant.step());
  EXPECT_NEAR(plant.body().p_WB.z(), 10 - 0.5 * kGravity, 1e-10);
  EXPECT_LT(plant.specific_force().norm(), 1e-12);
}

TEST(Plant, HoversAtTheSpeedThatCarriesItsWeight) {
  const auto v = omnimorph();
  PlantConfig c;
  c.initial_alpha = to_radians(30);
  Plant plant = make(v, {}, c);
  const double thrust = v.mass * kGravity / (8 * std::cos(c.initial_alpha));
  const std::vector<double> speed(8, v.rotors[0].speed(thrust));
  plant.set_command(speed, c.initial_alpha);
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(plant.step(true));
  for (int k = 0; k < 1000; ++k) ASSERT_TRUE(plant.step());
  EXPECT_LT(plant.body().p_WB.norm(), 1e-6);
  EXPECT_NEAR(plant.specific_force().z(), kGravity, 1e-9);
}

TEST(Plant, KeepsAngularMomentumAndEnergyOfATumblingBody) {
  auto v = omnimorph();
  v.inertia = Vec3(0.010, 0.014, 0.019).asDiagonal();
  PlantConfig c;
  c.initial.w_WB_B = Vec3(3, 9, -4);
  c.environment.gravity = 0;
  Plant plant = make(v, {}, c);
  const Vec3 L0 = plant.body().q_WB * (v.inertia * plant.body().w_WB_B);
  const double E0 = plant.body().w_WB_B.dot(v.inertia * plant.body().w_WB_B);
  for (int k = 0; k < 3000; ++k) ASSERT_TRUE(plant.step());
  EXPECT_LT((plant.body().q_WB * (v.inertia * plant.body().w_WB_B) - L0).norm() / L0.norm(), 1e-8);
  EXPECT_NEAR(plant.body().w_WB_B.dot(v.inertia * plant.body().w_WB_B) / E0, 1.0, 1e-8);
}

TEST(Plant, RungeKuttaIsOfFourthOrder) {
  // error after 0.32 s of powered tumbling against a much finer run
  const auto run = [](double step) {
    PlantConfig c;
    c.step = step;
    c.initial.w_WB_B = Vec3(3, 5, -4);
    c.initial_alpha = 0.5;
    Plant plant = make(omnimorph(), with("rotor_drag", {1e-4}), c);
    const std::vector<double> speed{900, 700, 800, 650, 720, 810, 640, 905};
    plant.set_command(speed, 0.5);
    const int n = static_cast<int>(std::lround(0.32 / step));
    for (int k = 0; k < n; ++k) EXPECT_TRUE(plant.step());
    return plant.body();
  };
  const RigidState exact = run(0.00025);
  const double coarse = (run(0.008).p_WB - exact.p_WB).norm(), fine = (run(0.004).p_WB - exact.p_WB).norm();
  EXPECT_GT(std::log2(coarse / fine), 3.6);
  EXPECT_LT(std::log2(coarse / fine), 4.6);
}

TEST(Plant, PayloadIsMoreMass) {
  // a plant with payload equals a plant of the greater mass (at the origin, so inertia is the same)
  auto heavy = omnimorph();
  heavy.mass += 0.3;
  PlantConfig c;
  c.initial_alpha = 0.5;
  Plant a = make(omnimorph(), with("payload_mass", {0.3}), c), b = make(heavy, {}, c);
  const std::vector<double> speed{900, 700, 800, 650, 720, 810, 640, 905};
  a.set_command(speed, 0.5);
  b.set_command(speed, 0.5);
  for (int k = 0; k < 500; ++k) {
    ASSERT_TRUE(a.step());
    ASSERT_TRUE(b.step());
  }
  EXPECT_LT((a.body().p_WB - b.body().p_WB).norm(), 1e-9);
}

TEST(Plant, DelayIsExactToTheStep) {
  auto v = omnimorph();
  for (auto& r : v.rotors) r.time_constant = 0;
  Plant plant = make(v, with("transport_delay", {0.005, 0.012}), {});
  plant.set_command(std::vector<double>(8, 500.0), 0);
  for (int k = 1; k <= 20; ++k) {
    ASSERT_TRUE(plant.step(true));
    EXPECT_EQ(plant.rotor_speed()[0], k > 5 ? 500.0 : 0.0) << k;
    EXPECT_EQ(plant.rotor_speed()[7], k > 12 ? 500.0 : 0.0) << k;
  }
}

TEST(Plant, TiltFollowsTheServoOfTheVehicleFile) {
  auto v = omnimorph();
  v.tilt.rate = 0;
  v.tilt.time_constant = 0.08;
  const std::vector<double> still(8, 0.0);
  const double from = to_radians(20), to = to_radians(30);
  PlantConfig c;
  c.initial_alpha = from;
  Plant lag = make(v, {}, c);
  lag.set_command(still, to);
  for (int k = 0; k < 80; ++k) ASSERT_TRUE(lag.step(true));
  EXPECT_NEAR((lag.alpha() - from) / (to - from), 1 - std::exp(-1.0), 1e-12)
      << "63 % after its time constant";
  v.tilt.time_constant = 0;
  v.tilt.backlash = to_radians(1.0);
  Plant play = make(v, {}, c);
  const auto settles_at = [&](double command_deg) {
    play.set_command(still, to_radians(command_deg));
    EXPECT_TRUE(play.step(true));
    return to_degrees(play.alpha());
  };
  EXPECT_NEAR(settles_at(20.4), 20.0, 1e-9) << "within the dead band nothing moves";
  EXPECT_NEAR(settles_at(30), 29.5, 1e-9);
  EXPECT_NEAR(settles_at(29.1), 29.5, 1e-9);
  EXPECT_NEAR(settles_at(25), 25.5, 1e-9) << "the other side of the play";
}

TEST(Plant, AHiddenLagOfTheTiltAddsToTheToldOne) {
  auto v = omnimorph();
  v.tilt.rate = 0;
  v.tilt.time_constant = 0.05;
  Plant plant = make(v, with("tilt_servo_lag", {0.03, 0}), {});
  plant.set_command(std::vector<double>(8, 0.0), 0.5);
  for (int k = 0; k < 80; ++k) ASSERT_TRUE(plant.step(true));
  EXPECT_NEAR(plant.alpha(), 0.5 * (1 - std::exp(-1.0)), 1e-12);
}

TEST(Plant, RefusesWhatIsNotPhysicalAndStopsWhatExplodes) {
  const auto v = omnimorph();
  EXPECT_FALSE(Plant::create(v, with("payload_mass", {-1.4}), {}));
  EXPECT_FALSE(Plant::create(v, with("payload_mass", {std::nan("")}), {}));
  PlantConfig c;
  c.step = 0.5;
  EXPECT_FALSE(Plant::create(v, {}, c));
  c = {};
  c.initial.p_WB.x() = std::nan("");
  EXPECT_FALSE(Plant::create(v, {}, c));
  Plant plant = make(v, {}, {});
  EXPECT_FALSE(plant.set_command(std::vector<double>(8, std::nan("")), 0));
  EXPECT_FALSE(plant.set_command(std::vector<double>(7, 0.0), 0));
  Status status;
  for (int k = 0; k < 100000 && status; ++k) status = plant.step();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().text().find("every reasonable range"), std::string::npos);
}

std::string refusal(const physics::Model& model, const PlantConfig& config = {},
                    const vehicle::Vehicle& vehicle = omnimorph()) {
  const auto made = Plant::create(vehicle, model, config);
  return made ? std::string("accepted") : made.error().text();
}

void expect_words(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* w : words) EXPECT_NE(text.find(w), std::string::npos) << "no '" << w << "' in: " << text;
}

TEST(Plant, NamesTheStateThatIsNotFinite) {
  PlantConfig c;
  c.initial.v_WB_W.y() = std::numeric_limits<double>::infinity();
  expect_words(refusal({}, c), {"simulator.initial: velocity y is inf m/s"});
  c.initial.p_WB.x() = std::nan("");
  expect_words(refusal({}, c), {"simulator.initial: position x is nan m"});
  c.initial = {};
  c.initial_alpha = std::nan("");
  expect_words(refusal({}, c), {"simulator.initial_alpha: is nan rad"});
}

TEST(Plant, NamesTheMassThatIsNotPositive) {
  auto light = omnimorph();
  light.mass = -1;
  expect_words(refusal({}, {}, light), {"mass: is -1.000000 kg, must be finite and above 0 kg"});
  light.mass = 0.4;
  expect_words(refusal(with("payload_mass", {-0.5}), {}, light),
               {"effects.payload_mass.mass: leaves a mass of -0.1 kg, must be above 0 kg"});
  EXPECT_EQ(refusal(with("payload_mass", {-0.3}), {}, light), "accepted");
}

TEST(Plant, RefusesAnInertiaThatNoBodyHas) {
  auto v = omnimorph();
  v.inertia = Vec3(0.010, 0.012, 0.018).asDiagonal();
  const auto of = [&v](const physics::Model& m) { return refusal(m, {}, v); };
  EXPECT_EQ(of(with("inertia_error", {0.001, -0.002, 0.0019})), "accepted");
  expect_words(of(with("inertia_error", {0.001, -0.013, 0.001})),
               {"effects.inertia_error.yy: is -0.013 kg m2",
                "moments of inertia of -0.001, 0.011 and 0.019 kg m2", "each must be above 0 kg m2"});
  expect_words(of(with("inertia_error", {0.001, 0, 0.006})),
               {"effects.inertia_error.zz: is 0.006 kg m2", "0.011, 0.012 and 0.024 kg m2",
                "the largest may be at most the sum of the others, 0.023 kg m2"});
  // an offset z takes m z^2 off two of the moments about the centre of mass, and both off the sum
  const double slack = 0.010 + 0.012 - 0.018, z = std::sqrt(slack / (2 * v.mass));
  EXPECT_EQ(of(with("com_offset", {0, 0, 0.99 * z})), "accepted");
  expect_words(of(with("com_offset", {0.001, 0, -1.01 * z})),
               {"effects.com_offset.z: is -0.039", " m and leaves", "at most the sum of the others"});
  expect_words(of(with("com_offset", {0, 0, 0.1})), {"effects.com_offset.z: is 0.1 m", "above 0 kg m2"});
  // each alone is possible, both are not
  physics::Model both = with("com_offset", {0, 0, 0.8 * z});
  EXPECT_EQ(of(both), "accepted");
  both.effects.push_back(with("inertia_error", {0, 0, 0.002}).effects[0]);
  EXPECT_EQ(of(with("inertia_error", {0, 0, 0.002})), "accepted");
  expect_words(of(both), {"effects.com_offset.z", "at most the sum of the others"});
  // a rod without thickness keeps the triangle inequality and cannot be turned about its axis
  v.inertia.diagonal() = Vec3(0.010, 0.012, 0.012);
  expect_words(of(with("inertia_error", {-0.010, 0, 0})),
               {"effects.inertia_error.xx: is -0.01 kg m2", "above 0"});
  v.inertia.diagonal() = Vec3(0.010, 0.012, 0.018);
  // about the centre of mass: a payload at the origin of a vehicle whose own centre is elsewhere makes it
  // larger
  v.center_of_mass.z() = 0.05;
  EXPECT_EQ(of({}), "accepted");
  EXPECT_EQ(of(with("payload_mass", {0.5})), "accepted");
}

TEST(Plant, RefusesADownwashWithoutANeighbour) {
  const physics::Model wash = with("neighbour_downwash", {0.3, 0.114, 0.2});
  expect_words(refusal(wash), {"effects.neighbour_downwash", "'neighbour'", "--neighbour FILE"});
  PlantConfig c;
  c.neighbours = {{{-2.0, -1.0}, {Vec3(0, 0, 3), Vec3(0, 0, 3)}}};  // it has left when the simulation begins
  expect_words(refusal(wash, c), {"effects.neighbour_downwash", "0 s"});
  c.neighbours = {{{1.0, 2.0}, {Vec3(0, 0, 3), Vec3(0, 0, 3)}}};
  EXPECT_EQ(refusal(wash, c), "accepted");
  c.neighbours = {{{0.0}, {Vec3(0, 0, 3)}}};
  EXPECT_EQ(refusal(wash, c), "accepted");
}

TEST(Plant, RefusesAnOverheadRopeThatDoesNotReachTheStart) {
  PlantConfig c;
  c.initial.p_WB.z() = 1;
  expect_words(refusal(with("overhead_rope", {0.05, 3.2, 2}), c),
               {"effects.overhead_rope.length: is 2 m", "shorter than the 2.2 m", "anchor_height 3.2 m"});
  EXPECT_EQ(refusal(with("overhead_rope", {0.05, 3.2, 2.3}), c), "accepted");
  c.initial.p_WB.z() = 1.3;
  EXPECT_EQ(refusal(with("overhead_rope", {0.05, 3.2, 2}), c), "accepted");
}

TEST(Plant, RefusesAnEffectListedTwiceWhereItsValuesCannotBothHold) {
  const auto twice = [](const char* id, std::vector<double> first, std::vector<double> second) {
    physics::Model m = with(id, std::move(first));
    m.effects.push_back(with(id, std::move(second)).effects[0]);
    return refusal(m);
  };
  expect_words(twice("structural_mode", {0.5, 20, 0.05}, {0.5, 35, 0.05}),
               {"effects.structural_mode.frequency: is 20 Hz", "35 Hz", "List the effect once"});
  expect_words(twice("sensor_filter", {0.005, 0, 0.7}, {0.002, 0, 1}),
               {"effects.sensor_filter.damping: is 0.7", " 1;"});
  expect_words(twice("rotor_speed_sensor_fault", {3, 0.05, 0, 1e6}, {4, 0.1, 0, 1e6}),
               {"effects.rotor_speed_sensor_fault.rotor: is 3", " 4;"});
  expect_words(twice("battery_sag", {0.05, 1e-4, 15, 1}, {0.05, 1e-4, 16, 1}),
               {"effects.battery_sag.", "is 15 V", "16 V"});
  // what adds up may be listed twice: two cables, two parts of one lag
  EXPECT_EQ(twice("hung_cable", {0.1, 0, 5}, {0.1, 0.5, 5}), "accepted");
  EXPECT_EQ(twice("structural_mode", {0.5, 20, 0.05}, {0.2, 20, 0.05}), "accepted");
  expect_words(refusal(with("rotor_speed_sensor_fault", {9, 0.05, 0, 1e6})),
               {"effects.rotor_speed_sensor_fault.rotor: is 9, and omnimorph has 8 rotors"});
}

TEST(Sensors, AreTheSameForASeedAndHonourRateAndLatency) {
  const auto v = omnimorph();
  Plant plant = make(v, {}, {});
  SensorConfig c;
  c.mocap_latency = 0.010;
  c.accelerometer_noise = 0.05;
  c.gyro_noise = 0.01;
  c.mocap_position_noise = 1e-3;
  SensorSuite a(c, {}, 0.001, 7), b(c, {}, 0.001, 7);
  int imu = 0, mocap = 0;
  for (int k = 0; k < 1000; ++k) {
    SensorFrame fa, fb;
    a.sample(plant, fa);
    b.sample(plant, fb);
    imu += fa.imu;
    if (fa.mocap) {
      ++mocap;
      EXPECT_NEAR(plant.time() - fa.mocap_sample.t, 0.010, 1e-9);
      EXPECT_EQ(fa.mocap_sample.p_WB, fb.mocap_sample.p_WB);
    }
    EXPECT_EQ(fa.imu_sample.specific_force_B, fb.imu_sample.specific_force_B);
    ASSERT_TRUE(plant.step(true));
  }
  EXPECT_EQ(imu, 1000);
  EXPECT_NEAR(mocap, 248, 1);
}

TEST(Sensors, RotorSpeedsComeInWholeMicrosecondsOfHalfAPeriodWhenAsked) {
  const auto v = omnimorph();
  Plant plant = make(v, {}, {});
  ASSERT_TRUE(plant.set_command(std::vector<double>(8, 2 * kPi * 120), 0));
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(plant.step(true));
  SensorConfig c;
  c.half_period_quantisation = true;
  SensorSuite suite(c, {}, 0.001, 7);
  SensorFrame frame;
  suite.sample(plant, frame);
  ASSERT_TRUE(frame.rotor);
  for (std::size_t i = 0; i < 8; ++i) {
    const double half_period_us = kPi * 1e6 / frame.rotor_sample.speed[i];
    EXPECT_NEAR(half_period_us, std::round(half_period_us), 1e-6);
    EXPECT_NEAR(frame.rotor_sample.speed[i], plant.rotor_speed()[i], 0.2);
    EXPECT_NE(frame.rotor_sample.speed[i], plant.rotor_speed()[i]);
  }
}

}  // namespace
}  // namespace omniflight::simulation
