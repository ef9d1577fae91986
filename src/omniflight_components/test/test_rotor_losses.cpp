// Rotors that are lost in flight, as the allocator's component sees them.
#include <gtest/gtest.h>

#include <cstdlib>

#include "../src/lost_rotors_message.hpp"
#include "../src/rotor_losses.hpp"

namespace omniflight::components {
namespace {

constexpr double kPeriod = 0.002;  // s

vehicle::Vehicle load(const char* name) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  return vehicle::load_vehicle(name).value();
}

/// Commands of half the largest speed to every rotor; the one of the index turns not from loss_s on.
struct Flight {
  vehicle::Vehicle v;
  RotorLosses losses{v};
  allocation::Allocator allocator =
      allocation::Allocator::create(v, allocation::AllocatorConfig::case_a()).value();
  std::string words = {};
  double told_s = -1;

  void fly(int rotor, double loss_s, double until_s, bool moves = true) {
    std::vector<double> command;
    for (const auto& r : v.rotors) command.push_back(0.5 * r.max_speed());
    for (double t = 0; t < until_s; t += kPeriod) {
      std::vector<double> speed = command;
      if (t >= loss_s) speed[static_cast<std::size_t>(rotor)] = 0;
      losses.measured(t, speed);
      losses.commanded(command, to_radians(30));
      const std::string now = losses.update(t, moves ? t : 0.0, Quat::Identity(), allocator);
      if (!now.empty()) words += now, told_s = t;
    }
  }
};

TEST(RotorLosses, OneIsSaidOnceAndLeftOut) {
  Flight f{load("omnimorph")};
  f.fly(2, 2.0, 4.0);
  EXPECT_EQ(f.losses.lost(), 4u);
  EXPECT_NE(f.words.find("rotor 3 does not turn as commanded and is left out; the others need "),
            std::string::npos)
      << f.words;
  EXPECT_NEAR(f.told_s, 2.0 + 0.05 + 0.015 + 0.01, 0.005);
  EXPECT_GT(f.losses.hover_load(), 0.3);
  EXPECT_LT(f.losses.hover_load(), 0.97);
  EXPECT_EQ(f.allocator.allocate({})->u[2], 0);
}

TEST(RotorLosses, NothingIsLostOnTheGroundOrWhileRotorsWindDown) {
  Flight held{load("omnimorph")};
  held.fly(2, 0.0, 4.0, false);
  EXPECT_EQ(held.losses.lost(), 0u);
  Flight ended{load("omnimorph")};
  ended.losses.wind_down();
  ended.fly(2, 2.0, 4.0);
  EXPECT_EQ(ended.losses.lost(), 0u);
}

/// The controller stands still for silent_s: the gate slows the rotors down to nothing in 0.5 s, lets
/// commands through again when they come, and the rotors follow with a lag. The missed ticks are answered all
/// at once. stands: a rotor that is lost meanwhile, or -1.
void stand_still(Flight& f, double from_s, double silent_s, int stands = -1) {
  std::vector<double> command, speed;
  for (const auto& r : f.v.rotors) command.push_back(0.5 * r.max_speed());
  speed = command;
  const double back_s = from_s + silent_s;
  const auto answer = [&](double t) {
    f.losses.commanded(command, to_radians(30));
    const std::string now = f.losses.update(t, t, Quat::Identity(), f.allocator);
    if (!now.empty()) f.words += now, f.told_s = t;
  };
  f.losses.gate(from_s + 0.015, false);
  for (double t = from_s; t < back_s + 1; t += kPeriod) {
    const double share = t < back_s ? std::max(0.0, 1 - (t - from_s) / 0.5) : 1;
    for (std::size_t i = 0; i < speed.size(); ++i)
      speed[i] += (share * command[i] - speed[i]) * -std::expm1(-kPeriod / f.v.rotors[i].time_constant);
    if (stands >= 0 && t > from_s) speed[static_cast<std::size_t>(stands)] = 0;
    f.losses.measured(t, speed);
    if (t < back_s) continue;
    if (t < back_s + kPeriod) {
      for (double missed = from_s; missed < t; missed += kPeriod) answer(missed);
      f.losses.gate(t, true);
    }
    answer(t);
  }
}

TEST(RotorLosses, RotorsThatGetNoCommandsAreNotLost) {
  for (const double silent_s : {0.05, 0.2, 0.4, 0.48}) {
    Flight f{load("omnimorph")};
    f.fly(0, HUGE_VAL, 3.0);
    stand_still(f, 3.0, silent_s);
    EXPECT_EQ(f.losses.lost(), 0u) << silent_s << " s: " << f.words;
  }
}

TEST(RotorLosses, OneThatIsLostWhileItGotNoCommandsIsSaidAfterwards) {
  for (const double silent_s : {0.05, 0.2, 0.4}) {
    Flight f{load("omnimorph")};
    f.fly(0, HUGE_VAL, 3.0);
    stand_still(f, 3.0, silent_s, 2);
    EXPECT_EQ(f.losses.lost(), 4u) << silent_s << " s: " << f.words;
    // from when commands get through: what a loss takes, and a reversal that could be one
    EXPECT_LT(f.told_s, 3.0 + silent_s + 0.05 + 0.015 + 0.01 + 0.05 + 0.01);
  }
}

TEST(RotorLosses, AGateThatFadesForAMomentHidesNoLoss) {
  Flight f{load("omnimorph")};
  std::vector<double> command, speed;
  for (const auto& r : f.v.rotors) command.push_back(0.5 * r.max_speed());
  speed = command;
  int k = 0;
  for (double t = 0; t < 4; t += kPeriod, ++k) {
    if (t >= 2) speed[2] = 0;
    f.losses.measured(t, speed);
    f.losses.gate(t, k % 10 > 1);  // as on a loaded machine: every 20 ms a command is late
    f.losses.commanded(command, to_radians(30));
    const std::string now = f.losses.update(t, t, Quat::Identity(), f.allocator);
    if (!now.empty()) f.words += now, f.told_s = t;
  }
  EXPECT_EQ(f.losses.lost(), 4u);
  EXPECT_NEAR(f.told_s, 2.0 + 0.05 + 0.015 + 0.01, 0.005);
}

TEST(RotorLosses, WhoCanHoverWithoutOne) {
  const Quat level = Quat::Identity();
  const auto load_without = [&](const char* name, double alpha_deg) {
    return hover_load_without(load(name), 1u, to_radians(alpha_deg), level);
  };
  EXPECT_LT(load_without("omnimorph", 30), 0.97);
  EXPECT_LT(load_without("coaxial_x8", 0), 0.97);
  EXPECT_LT(load_without("omnicopter", 0), 0.97);
  EXPECT_TRUE(std::isinf(load_without("quadrotor_1200g", 0)));
  EXPECT_GT(load_without("hexarotor_2300g", 0), 0.97);
  EXPECT_TRUE(std::isinf(hover_load_without(load("quadrotor_1200g"), 15u, 0, level))) << "none is left";
}

TEST(LostRotorsMessage, TellsTheLoadAndRefusesWhatIsNoneOfOurs) {
  for (const double load : {0.6, 1.2, HUGE_VAL}) {
    bus::Message<msgs::diagnostic_msgs::DiagnosticArray> m;
    fill_lost_rotors(*m, {}, 4, load, "rotor 3");
    ASSERT_TRUE(hover_load_in(*m));
    EXPECT_EQ(*hover_load_in(*m), load);
    EXPECT_EQ(bus::view(m->status)[0].level, load > 1 ? 2 : 1);
    for (const char* bad : {"", "nan", "-1", "0.5x", "1e999"}) {
      bus::set_text(bus::view(bus::view(m->status)[0].values)[1].value, bad);
      EXPECT_FALSE(hover_load_in(*m)) << bad;
    }
  }
  bus::Message<msgs::diagnostic_msgs::DiagnosticArray> empty;
  EXPECT_FALSE(hover_load_in(*empty));
}

}  // namespace
}  // namespace omniflight::components
