// Laws that every effect of the library keeps, whatever it acts on.
#include <algorithm>
#include <set>

#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

std::vector<double> values(const Effect& e, double Parameter::*which) {
  std::vector<double> out;
  for (const Parameter& p : e.info().parameters) out.push_back(p.*which);
  return out;
}

std::vector<double> memory_of(const Effect& e, const Situation& s, const std::vector<double>& theta) {
  std::vector<double> memory(static_cast<std::size_t>(e.memory_size().total()));
  if (!memory.empty()) e.start_memory(s, theta.data(), memory.data());
  return memory;
}

/// An ideal drive of the cube: what alter_actuation starts from.
Actuation ideal_drive() {
  Actuation a;
  a.time_constant.assign(8, 0.02);
  a.delay.assign(8, 0.0);
  return a;
}

/// A motion that excites memories: the states of `six_states` are no motion, this one is smooth. It rises out
/// of a rope that carries it to the end of another, below a neighbour, one rotor reversed.
std::vector<Situation> smooth_motion(double period, int samples) {
  std::vector<Situation> out;
  for (int k = 0; k < samples; ++k) {
    const double t = period * k;
    RigidState body;
    body.p_WB = Vec3(0.1 * std::sin(5 * t), 0.05 * std::cos(4 * t), 1.4 - 0.55 * std::cos(10 * t));
    body.v_WB_W = Vec3(0.5 * std::cos(5 * t), -0.2 * std::sin(4 * t), 5.5 * std::sin(10 * t));
    body.q_WB = exp_rotation(Vec3(0.2 * std::sin(2 * t), 0.1, 0.3));
    std::vector<double> speed(8, 700 + 150 * std::sin(20 * t));
    speed[2] = -500;
    body.w_WB_B = Vec3(0.4 * std::cos(2 * t), 0.2, -0.3);
    out.push_back(situation(cube(), body, 0.3, speed));
    out.back().t = t;
    for (std::size_t i = 0; i < 8; ++i)
      out.back().rotors[i].acceleration = i == 2 ? 0 : 150 * 20 * std::cos(20 * t);
    out.back().a_WB_B = Vec3(2 * std::sin(6 * t), 1 - std::cos(5 * t), std::sin(4 * t));
    out.back().dw_WB_B = Vec3(std::sin(t), 0, std::cos(t));
    out.back().neighbour_count = 1;
    out.back().neighbours[0].p_WN = body.p_WB + Vec3(0.1, -0.05, 0.7);
  }
  return out;
}

TEST(Library, HasEveryIdOfTheContract) {
  for (const char* id : {"payload_mass",
                         "com_offset",
                         "inertia_error",
                         "rotor_axis_misalignment",
                         "tilt_offset",
                         "rotor_position_error",
                         "thrust_scale",
                         "rotor_thrust_scale",
                         "reverse_thrust_asymmetry",
                         "thrust_curve",
                         "drag_torque_scale",
                         "motor_lag",
                         "thrust_dead_zone",
                         "transport_delay",
                         "command_quantisation",
                         "battery_sag",
                         "actuator_saturation",
                         "rotor_inertia",
                         "tilt_servo_lag",
                         "tilt_efficiency",
                         "downwash_interference",
                         "rotor_drag",
                         "axial_inflow",
                         "parasitic_drag",
                         "blade_flapping",
                         "wind",
                         "gust",
                         "ground_effect",
                         "ceiling_effect",
                         "wall_effect",
                         "vortex_ring",
                         "dynamic_inflow",
                         "neighbour_downwash",
                         "hung_cable",
                         "constant_pull",
                         "overhead_rope",
                         "taut_rope",
                         "catenary",
                         "lateral_stiffness",
                         "slung_load",
                         "cable_drag",
                         "cable_torsion",
                         "attachment_torque",
                         "guide_friction",
                         "hanging_start",
                         "accelerometer_error",
                         "gyro_error",
                         "imu_lever_arm",
                         "mocap_tilt",
                         "mocap_offset",
                         "clock_offset",
                         "sensor_filter",
                         "vibration",
                         "structural_mode",
                         "rotor_speed_sensor_fault",
                         "battery_sensor_fault",
                         "controller_mismatch",
                         "stale_samples"})
    EXPECT_NE(find_effect(id), nullptr) << id;
}

TEST(Library, DeclaresChannelsBoundsAndAliasesThatExist) {
  const std::set<std::string> channels(known_channels().begin(), known_channels().end());
  for (const Effect* e : builtin_effects()) {
    const EffectInfo& info = e->info();
    for (const std::string& c : info.channels) EXPECT_TRUE(channels.count(c)) << info.id << " " << c;
    for (const std::string& a : info.aliases) {
      EXPECT_NE(find_effect(a), nullptr) << info.id << " is like " << a;
      EXPECT_NE(a, info.id);
      const auto back = aliases_of(find_effect(a)->info());
      EXPECT_TRUE(std::find(back.begin(), back.end(), info.id) != back.end()) << a << " is like " << info.id;
    }
    const auto all = aliases_of(info);
    EXPECT_EQ(std::set<std::string>(all.begin(), all.end()).size(), all.size()) << info.id;
    for (const Parameter& p : info.parameters) {
      EXPECT_LE(p.lower, p.neutral) << info.id << " " << p.name;
      EXPECT_GE(p.upper, p.neutral) << info.id << " " << p.name;
    }
  }
}

TEST(Library, MovesNoChannelThatItDoesNotDeclare) {
  const char* channels[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
  for (const Effect* e : builtin_effects()) {
    if (!e->acts_on_wrench() && e->memory_size().total() == 0) continue;
    const EffectInfo& info = e->info();
    const std::vector<double> theta = values(*e, &Parameter::typical);
    for (Situation s : six_states()) {  // tilted far: what is horizontal in the world is not so in the body
      s.neighbour_count = 1;
      s.neighbours[0].p_WN = s.body.p_WB + Vec3(0.05, 0, 0.6);
      std::vector<double> memory = memory_of(*e, s, theta);
      Random random(1);
      if (!memory.empty()) e->advance(s, theta.data(), 0.001, random, memory.data());
      Wrench w;
      if (e->acts_on_wrench()) e->add_wrench(s, theta.data(), w);
      if (!memory.empty()) e->add_memory_wrench(s, theta.data(), memory.data(), w);
      for (int k = 0; k < 6; ++k)
        if (std::find(info.channels.begin(), info.channels.end(), channels[k]) == info.channels.end()) {
          EXPECT_LT(std::abs(w.at(s)[k]), 1e-12) << info.id << " " << channels[k];
        }
    }
  }
}

TEST(Library, NeutralIsExactlyNothingAtEveryStage) {
  for (const Effect* e : builtin_effects()) {
    const std::vector<double> theta = values(*e, &Parameter::neutral);
    Actuation drive = ideal_drive();
    e->alter_actuation(cube(), theta.data(), drive);
    EXPECT_EQ(drive, ideal_drive()) << e->info().id;
    Sensing sensing;
    e->alter_sensing(theta.data(), sensing);
    EXPECT_EQ(sensing, Sensing{}) << e->info().id;
    for (const Situation& s : six_states()) {
      std::vector<double> memory = memory_of(*e, s, theta);
      Random random(1);
      if (!memory.empty()) e->advance(s, theta.data(), 0.001, random, memory.data());
      Wrench w;
      if (e->acts_on_wrench()) e->add_wrench(s, theta.data(), w);
      if (!memory.empty()) e->add_memory_wrench(s, theta.data(), memory.data(), w);
      EXPECT_EQ(w.at(s).norm(), 0.0) << e->info().id;
      EXPECT_EQ(e->shaft_power(s, theta.data()), 0.0) << e->info().id;
    }
  }
}

TEST(Library, TypicalIsSomethingAtTheStageItDeclares) {
  for (const Effect* e : builtin_effects()) {
    const EffectInfo& info = e->info();
    const std::vector<double> theta = values(*e, &Parameter::typical);
    Actuation drive = ideal_drive();
    e->alter_actuation(cube(), theta.data(), drive);
    Sensing sensing;
    e->alter_sensing(theta.data(), sensing);
    const bool wrench = e->acts_on_wrench() || e->memory_size().total() > 0;
    const bool acts = drive != ideal_drive(), senses = sensing != Sensing{};
    EXPECT_TRUE(wrench || acts || senses) << info.id;
    EXPECT_EQ(info.stage == Stage::wrench, wrench) << info.id;
    EXPECT_EQ(info.stage == Stage::actuation || info.stage == Stage::control, acts) << info.id;
    EXPECT_EQ(info.stage == Stage::sensing ||
                  std::find(info.also.begin(), info.also.end(), Stage::sensing) != info.also.end(),
              senses)
        << info.id;
  }
}

TEST(Library, ReplaysOfARecordedMotionHaveTheirExactDerivative) {
  const std::vector<Situation> motion = smooth_motion(0.005, 60);
  const std::size_t rows = 6 * motion.size();
  for (const Effect* e : builtin_effects()) {
    if (!e->can_replay()) continue;
    const std::vector<double> theta = values(*e, &Parameter::typical);
    std::vector<double> value(rows), up(rows), down(rows), jacobian(rows * theta.size());
    e->replay(motion, 0.005, theta.data(), value.data(), jacobian.data());
    EXPECT_GT(Eigen::Map<const Eigen::VectorXd>(value.data(), static_cast<Eigen::Index>(rows)).norm(), 1e-3)
        << e->info().id << " is nothing all along";
    for (std::size_t k = 0; k < theta.size(); ++k) {
      const double h = 1e-6 * std::max(0.1, std::abs(theta[k]));
      std::vector<double> more = theta, less = theta;
      more[k] += h;
      less[k] -= h;
      e->replay(motion, 0.005, more.data(), up.data(), nullptr);
      e->replay(motion, 0.005, less.data(), down.data(), nullptr);
      const Eigen::Map<const Eigen::VectorXd> a(up.data(), static_cast<Eigen::Index>(rows)),
          b(down.data(), static_cast<Eigen::Index>(rows)),
          exact(jacobian.data() + k * rows, static_cast<Eigen::Index>(rows));
      EXPECT_LT(((a - b) / (2 * h) - exact).lpNorm<Eigen::Infinity>(),
                1e-6 * (1 + exact.lpNorm<Eigen::Infinity>() + 1e-9 * a.lpNorm<Eigen::Infinity>() / h))
          << e->info().id << " " << e->info().parameters[k].name;
    }
  }
}

TEST(Library, PowerTakenIsThatOfTheWrench) {
  for (const Situation& s : six_states()) {
    const double k_d = 1e-4;
    Wrench w;
    find_effect("rotor_drag")->add_wrench(s, &k_d, w);
    const double power_of_drag = find_effect("rotor_drag")->power_taken(s, &k_d);
    EXPECT_GE(power_of_drag, 0.0);
    EXPECT_NEAR(power_of_drag, -w.force_B.dot(s.v_WB_B) - w.torque_B.dot(s.body.w_WB_B), 1e-12);
  }
  const double eps = 0.2;  // rotors that need a fifth more torque draw a fifth more power
  const Situation s = hover(1.0);
  double shaft = 0;
  for (const RotorSituation& r : s.all_rotors()) shaft += std::abs(r.drag_ratio * r.thrust * r.speed);
  EXPECT_NEAR(find_effect("drag_torque_scale")->shaft_power(s, &eps), 0.2 * shaft, 1e-12);
}

}  // namespace
}  // namespace omniflight::physics::testing
