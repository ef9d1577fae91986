// Every effect of the library flown: it stays finite, moves the channels it declares, repeats to the bit, and
// nothing is allocated.
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

#include "counted_malloc.hpp"
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

/// Values of ordinary size; a parameter whose ordinary value is zero gets a tenth of its bound.
std::vector<double> ordinary(const physics::Effect& e) {
  std::vector<double> theta;
  for (const auto& p : e.info().parameters) theta.push_back(p.typical != 0 ? p.typical : 0.1 * p.upper);
  return theta;
}

Plant make(const vehicle::Vehicle& v, const physics::Model& m, const PlantConfig& c) {
  auto p = Plant::create(v, m, c);
  if (!p) throw std::runtime_error(p.error().text());
  return *p;
}

PlantConfig start(bool climbing) {
  PlantConfig c;
  c.initial_alpha = 0.4;
  c.initial.p_WB = climbing ? Vec3(0.2, -0.1, 0.3) : Vec3(-0.4, 0.3, 9);
  c.initial.v_WB_W = climbing ? Vec3(0.4, 0.3, 1.2) : Vec3(0.5, -0.2, -4);
  c.initial.q_WB = exp_rotation(Vec3(0.15, -0.1, 0.3));
  c.neighbours = {{{0.0}, {c.initial.p_WB + Vec3(0.2, 0.1, 4.0)}}};
  return c;
}

/// Speeds near hover with a different wobble on each rotor; rotors 4 and 2 reverse for a tenth of a second
/// each.
std::vector<double> command(const vehicle::Vehicle& v, double t) {
  std::vector<double> out;
  const double hover = v.rotors[0].speed(v.mass * kGravity / (8 * std::cos(0.4)));
  for (std::size_t i = 0; i < v.rotors.size(); ++i)
    out.push_back(hover *
                  (1 + 0.1 * std::sin((15 + 2 * static_cast<double>(i)) * t + static_cast<double>(i))));
  if (t > 1 && t < 1.1) out[3] = -300;
  if (t > 1.2 && t < 1.3) out[1] = -300;
  return out;
}

struct Trace {
  std::map<std::string, std::vector<double>> of;
  Status status;
};

Trace fly(const physics::Model& model, bool climbing, std::uint64_t seed = 1) {
  static const vehicle::Vehicle v = omnimorph();
  PlantConfig c = start(climbing);
  c.seed = seed;
  Plant plant = make(v, model, c);
  SensorConfig ideal;
  ideal.battery_rate = 50;
  SensorSuite sensors(ideal, model, c.step, seed);
  SensorFrame f;
  Trace out;
  for (int k = 0; k < 2000 && out.status; ++k) {
    sensors.sample(plant, f);
    const double t = plant.time();
    plant.set_command(command(v, t), 0.4 + 0.2 * std::sin(3 * t));
    out.status = plant.step();
    static const char* const wrench[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
    for (int i = 0; i < 6; ++i) out.of[wrench[i]].push_back(plant.effect_wrench()[i]);
    const auto add = [&](const char* name, const auto& vector) {
      for (int i = 0; i < vector.size(); ++i) out.of[name].push_back(vector[i]);
    };
    if (f.imu) add("acc", f.imu_sample.specific_force_B), add("gyro", f.imu_sample.gyro_B);
    if (f.mocap) {
      add("position", f.mocap_sample.p_WB);
      add("attitude", f.mocap_sample.q_WB.coeffs());
      out.of["stamp"].push_back(f.mocap_sample.t);
    }
    if (f.rotor) {
      for (std::size_t i = 0; i < 8; ++i) out.of["rotor_speed"].push_back(f.rotor_sample.speed[i]);
      out.of["alpha"].push_back(f.rotor_sample.alpha);
    }
    if (f.battery) {
      out.of["voltage"].push_back(f.battery_sample.voltage);
      out.of["current"].push_back(f.battery_sample.current);
    }
  }
  return out;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = a.size() == b.size() ? 0 : 1e9;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

TEST(EveryEffect, StaysFiniteForTwoSecondsAndMovesTheChannelsItDeclares) {
  std::map<bool, Trace> nominal;
  for (const bool climbing : {true, false}) nominal[climbing] = fly({}, climbing);
  for (const physics::Effect* e : physics::builtin_effects()) {
    std::map<std::string, double> moved;
    for (const bool climbing : {true, false}) {
      const Trace flown = fly(with(e->info().id, ordinary(*e)), climbing);
      EXPECT_TRUE(flown.status) << e->info().id << ": " << flown.status.error().text();
      for (const auto& [channel, values] : flown.of) {
        for (const double v : values) ASSERT_TRUE(std::isfinite(v)) << e->info().id << " " << channel;
        moved[channel] = std::max(moved[channel], largest_difference(values, nominal[climbing].of[channel]));
      }
    }
    // what a sensing effect declares as a wrench is the wrench that its sensor pretends
    const bool senses = e->info().stage == physics::Stage::sensing;
    for (const std::string& channel : e->info().channels) {
      const bool pretended = senses && channel.size() == 2;
      EXPECT_GT(pretended ? 1.0 : moved[channel], 1e-7) << e->info().id << " " << channel;
    }
    // an effect on the plant must not touch how the sensors work: true stamps stay
    EXPECT_TRUE(senses || moved["stamp"] == 0.0) << e->info().id;
  }
}

physics::Model all_effects(double share) {
  physics::Model m;
  for (const physics::Effect* e : physics::builtin_effects()) {
    m.effects.push_back({e, {}});
    for (const auto& p : e->info().parameters)
      m.effects.back().theta.push_back(p.neutral == p.typical ? p.typical
                                                              : p.neutral + share * (p.typical - p.neutral));
  }
  return m;
}

TEST(EveryEffect, TogetherRepeatToTheBitForASeedOnly) {
  const physics::Model m = all_effects(0.02);
  const Trace a = fly(m, true, 7), b = fly(m, true, 7), c = fly(m, true, 8);
  ASSERT_TRUE(a.status) << a.status.error().text();
  EXPECT_EQ(a.of, b.of);
  EXPECT_NE(a.of, c.of) << "gusts depend on the seed";
}

TEST(EveryEffect, TogetherAllocateNothingInAStep) {
  const vehicle::Vehicle v = omnimorph();
  for (const Integrator integrator : {Integrator::rk4, Integrator::semi_implicit_euler}) {
    PlantConfig c = start(true);
    c.integrator = integrator;
    Plant plant = make(v, all_effects(0.02), c);
    const std::vector<double> speed = command(v, 0.0);
    const long before = counted::allocations;
    for (int k = 0; k < 200; ++k) {
      plant.set_command(speed, 0.4);
      ASSERT_TRUE(plant.step());
    }
    EXPECT_EQ(counted::allocations, before);
  }
}

TEST(SlungLoad, KeepsEnergyAndMomentumTogetherWithTheBody) {
  auto v = omnimorph();
  const double m_l = 0.4, length = 0.7;
  const Vec3 r(0.03, -0.02, -0.1);
  PlantConfig c;
  c.initial.p_WB.z() = 50;
  c.initial.w_WB_B = Vec3(1, -2, 0.5);
  c.initial.v_WB_W = Vec3(0.5, 0, 1);
  Plant plant = make(v, with("slung_load", {m_l, length, 0.0, r.x(), r.y(), r.z()}), c);
  const auto total = [&] {
    const RigidState& b = plant.body();
    const auto x = plant.memory("slung_load");
    const Vec3 q(x[0], x[1], x[2]), dq(x[3], x[4], x[5]);
    const Mat3 R = b.q_WB.toRotationMatrix();
    const Vec3 at = b.p_WB + R * r + length * q;
    const Vec3 vl = b.v_WB_W + R * b.w_WB_B.cross(r) + length * dq;
    Eigen::Vector4d out;
    out << v.mass * b.v_WB_W + m_l * vl,
        0.5 * v.mass * b.v_WB_W.squaredNorm() + 0.5 * b.w_WB_B.dot(v.inertia * b.w_WB_B) +
            0.5 * m_l * vl.squaredNorm() + kGravity * (v.mass * b.p_WB.z() + m_l * at.z());
    return out;
  };
  const Eigen::Vector4d before = total();
  for (int k = 0; k < 1000; ++k) ASSERT_TRUE(plant.step());
  const Eigen::Vector4d after = total();
  const double impulse = -(v.mass + m_l) * kGravity * 1.0;
  EXPECT_LT((after.head<3>() - before.head<3>() - Vec3(0, 0, impulse)).norm(), 1e-6);
  EXPECT_NEAR(after[3], before[3], 1e-6 * std::abs(before[3]));
}

TEST(SlungLoad, RubbingInItsJointLosesEnergyAndNoMomentum) {
  // far from the ground, without gravity: linear and angular momentum of body and load stay
  auto v = omnimorph();
  const double m_l = 0.4, length = 0.7;
  const Vec3 r(0.03, -0.02, -0.1);
  PlantConfig c;
  c.environment.gravity = 0;
  c.initial.w_WB_B = Vec3(1, -2, 0.5);
  c.initial.v_WB_W = Vec3(0.5, 0, 1);
  Plant plant = make(v, with("slung_load", {m_l, length, 0.8, r.x(), r.y(), r.z()}), c);
  struct Total {
    Vec3 linear, angular;
    double energy;
  };
  const auto total = [&] {
    const RigidState& b = plant.body();
    const auto x = plant.memory("slung_load");
    const Vec3 q(x[0], x[1], x[2]), dq(x[3], x[4], x[5]);
    const Mat3 R = b.q_WB.toRotationMatrix();
    const Vec3 at = b.p_WB + R * r + length * q, vl = b.v_WB_W + R * b.w_WB_B.cross(r) + length * dq;
    return Total{v.mass * b.v_WB_W + m_l * vl,
                 v.mass * b.p_WB.cross(b.v_WB_W) + R * (v.inertia * b.w_WB_B) + m_l * at.cross(vl),
                 0.5 * v.mass * b.v_WB_W.squaredNorm() + 0.5 * b.w_WB_B.dot(v.inertia * b.w_WB_B) +
                     0.5 * m_l * vl.squaredNorm()};
  };
  const Total before = total();
  for (int k = 0; k < 1000; ++k) ASSERT_TRUE(plant.step());
  const Total after = total();
  EXPECT_LT((after.linear - before.linear).norm(), 1e-6);
  EXPECT_LT((after.angular - before.angular).norm(), 1e-6);
  EXPECT_LT(after.energy, 0.999 * before.energy);
}

TEST(SlungLoad, SlackensFallsFreelyAndIsCaughtWithItsMomentum) {
  // reversed rotors press the vehicle down faster than the load falls, then lift it again
  const auto v = omnimorph();
  const double m_l = 0.3, length = 0.6;
  PlantConfig c;
  c.initial.p_WB.z() = 50;
  Plant plant = make(v, with("slung_load", {m_l, length, 0.0, 0, 0, 0}), c);
  ASSERT_TRUE(v.rotors[0].bidirectional);
  int slack_steps = 0, catches = 0;
  double momentum = 0, impulse = 0, longest = 0;
  Vec3 fallen_from = Vec3::Zero(), falling_with = Vec3::Zero();
  double since = 0;
  for (int k = 0; k < 3000; ++k) {
    const double lift = k < 400 ? -0.8 : 1.6;  // of the weight of the vehicle
    const double each = lift * v.mass * kGravity / 8;
    plant.set_command(std::vector<double>(8, v.rotors[0].speed(each)), 0);
    double thrust = 0;
    for (const auto& r : plant.situation().all_rotors()) thrust += r.thrust * r.n_B.z();
    ASSERT_TRUE(plant.step());
    double next = 0;
    for (const auto& r : plant.situation().all_rotors()) next += r.thrust * r.n_B.z();
    impulse += 0.5 * (thrust + next) * c.step - (v.mass + m_l) * kGravity * c.step;
    const auto x = plant.memory("slung_load");
    const Vec3 q(x[0], x[1], x[2]), dq(x[3], x[4], x[5]);
    const Vec3 at = plant.body().p_WB + length * q, velocity = plant.body().v_WB_W + length * dq;
    momentum = v.mass * plant.body().v_WB_W.z() + m_l * velocity.z();
    longest = std::max(longest, q.norm());
    const double push = -q.normalized().dot(plant.body().q_WB * plant.effect_wrench().head<3>());
    EXPECT_LT(push, 1e-9) << "the rope pulls the vehicle towards the load, never away, at " << plant.time();
    const bool slack = x[6] < 0.5;
    if (slack && slack_steps++ == 0) fallen_from = at, falling_with = velocity, since = plant.time();
    if (slack && catches == 0) {
      const double t = plant.time() - since;
      EXPECT_LT((at - fallen_from - t * falling_with + Vec3(0, 0, 0.5 * kGravity * t * t)).norm(), 1e-9);
      EXPECT_EQ(plant.effect_wrench(), Vec6(Vec6::Zero()));
    }
    if (!slack && slack_steps > 0 && catches == 0) catches = 1;
  }
  EXPECT_GT(slack_steps, 100);
  EXPECT_EQ(catches, 1);
  EXPECT_NEAR(momentum, impulse, 1e-3) << "what caught the load pulled the vehicle";
  EXPECT_LT(longest, 1.1);
  EXPECT_NEAR(plant.memory("slung_load")[2], -1.0, 0.02) << "and it hangs again";
}

TEST(Gust, TwoOfThemBlowForThemselves) {
  const auto v = omnimorph();
  const std::vector<double> theta{0.5, 0.1, 0.02};
  physics::Model twice = with("gust", theta);
  twice.effects.push_back(twice.effects[0]);
  PlantConfig c;
  c.environment.gravity = 0;
  Plant one = make(v, with("gust", theta), c), two = make(v, twice, c);
  double product = 0, first_square = 0, second_square = 0;
  for (int k = 0; k < 20000; ++k) {
    ASSERT_TRUE(one.step() && two.step());
    ASSERT_EQ(one.memory("gust")[0], two.memory("gust")[0]) << "the first blows as it does alone";
    physics::Wrench first;
    twice.effects[0].effect->add_memory_wrench(two.situation(), theta.data(), two.memory("gust").data(),
                                               first);
    const Vec3 second = two.effect_wrench().head<3>() - first.force_B;
    product += first.force_B.dot(second);
    first_square += first.force_B.squaredNorm();
    second_square += second.squaredNorm();
  }
  EXPECT_LT(std::abs(product), 0.3 * std::sqrt(first_square * second_square));
  EXPECT_NEAR(second_square / first_square, 1.0, 0.4);
}

TEST(Cables, OfThreeFidelitiesAgreeAtRestAndInASlowClimb) {
  // thrust that holds vehicle and cable at 1.2 m; then 2 % more
  const vehicle::Vehicle v = omnimorph();
  const double lambda = 0.25, height = 1.2;
  const std::map<std::string, std::vector<double>> cables{{"hung_cable", {lambda, 0, 2}},
                                                          {"cable_pendulum", {lambda, 0, 2, 0.05}},
                                                          {"cable_chain", {lambda, 2, 0, 0.5, 0.5}}};
  std::map<std::string, double> climbed, force;
  for (const auto& [id, theta] : cables) {
    PlantConfig c;
    c.initial.p_WB.z() = height;
    Plant plant = make(v, with(id, theta), c);
    const double weight = (v.mass + lambda * height) * kGravity;
    std::vector<double> speed(8, v.rotors[0].speed(weight / 8));
    plant.set_command(speed, 0);
    for (int k = 0; k < 1500; ++k) ASSERT_TRUE(plant.step(true));
    ASSERT_TRUE(plant.step());
    for (int k = 0; k < 300; ++k) ASSERT_TRUE(plant.step());
    EXPECT_NEAR(plant.effect_wrench()[2], -lambda * height * kGravity, 0.02 * lambda * height * kGravity)
        << id;
    EXPECT_NEAR(plant.body().p_WB.z(), height, 0.005) << id;
    EXPECT_LT(plant.body().p_WB.head<2>().norm(), 0.005) << id;
    for (double& s : speed) s *= std::sqrt(1.02);
    plant.set_command(speed, 0);
    for (int k = 0; k < 1000; ++k) ASSERT_TRUE(plant.step());
    climbed[id] = plant.body().p_WB.z() - height;
    force[id] = plant.effect_wrench()[2];
  }
  EXPECT_GT(climbed["hung_cable"], 0.04);
  EXPECT_NEAR(climbed["cable_pendulum"], climbed["hung_cable"], 1e-9);
  // within what 2 % of the cable's weight does in that second
  const double one_second = 0.5 * 0.02 * lambda * height * kGravity / (v.mass + lambda * height);
  EXPECT_NEAR(climbed["cable_chain"], climbed["hung_cable"], one_second);
}

TEST(Plant, NamesTheStateThatExplodesWithItsValue) {
  const vehicle::Vehicle v = omnimorph();
  PlantConfig c;
  c.step = 0.015;  // seven times the time constant of this inflow, whose force is switched off
  Plant inflow = make(v, with("dynamic_inflow", {0.0, 0.002}), c);
  inflow.set_command(std::vector<double>(8, 700.0), 0);
  Status status;
  for (int k = 0; k < 2000 && status; ++k) status = inflow.step(true);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("of effect dynamic_inflow is "), std::string::npos)
      << status.error().text();
  c.step = 0.02;
  c.initial.p_WB.z() = 3;
  c.initial.v_WB_W.z() = 5;
  auto stiff = v;
  for (auto& r : stiff.rotors) r.time_constant = 0;
  Plant rope = make(stiff, with("taut_rope", {100000, 1000, 1, 0, 0, 0, 0}), c);
  status = {};
  for (int k = 0; k < 2000 && status; ++k) status = rope.step();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("velocity z is "), std::string::npos) << status.error().text();
}

TEST(Plant, RefusesValuesOutsideTheirBoundsWithUnitAndBound) {
  const auto made = Plant::create(omnimorph(), with("hung_cable", {99, 0, 5}), {});
  ASSERT_FALSE(made);
  for (const char* part : {"hung_cable.linear_density", "99", "1.5", "kg/m"})
    EXPECT_NE(made.error().text().find(part), std::string::npos) << made.error().text();
}

}  // namespace
}  // namespace omniflight::simulation
