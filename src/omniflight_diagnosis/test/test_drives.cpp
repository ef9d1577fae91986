// What alters the drives between a command and a speed, by the evidence of both; and a clock that is no
// delay.
#include <gtest/gtest.h>

#include <cstdlib>

#include "../src/drive/drive_inference.hpp"
#include "../src/report/other_stages.hpp"
#include "omniflight_core/random.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kPeriod = 0.008, kDuration = 40;

using test::omnimorph;

/// What a rotor makes of its command, apart from its lag. Everything is nothing by default.
struct Drive {
  int board = -1;       ///< that is late; -1: all
  double delay = 0;     ///< s
  double clock = 0;     ///< s, that speeds are stamped late
  double step = 0;      ///< rad/s, of commands
  double slew = 1e9;    ///< rad/s^2
  double slows_by = 1;  ///< lag when it slows down over that when it speeds up
  double reading = 0;   ///< rad/s, steps of the telemetry
  double noise = 0.1;   ///< rad/s
  double swing = 60;    ///< rad/s, of commands, beside a random walk of 20
};

/// Commands held for 8 ms, by drives that are integrated in steps of 0.1 ms.
recording::Recording answers(const vehicle::Vehicle& v, const Drive& d) {
  recording::Recording r;
  recording::Signal &u = r.signals["rotor_command"], &w = r.signals["rotor_speed"];
  u.name = "rotor_command";
  w.name = "rotor_speed";
  const int n = static_cast<int>(kDuration / kPeriod);
  const Eigen::Index rotors = v.rotor_count();
  u.values.resize(n, rotors);
  w.values.resize(n, rotors);
  for (int i = 0; i < n; ++i) {
    u.t_s.push_back(i * kPeriod);
    w.t_s.push_back(i * kPeriod + d.clock);
  }
  Random random(3, "drives");
  for (Eigen::Index k = 0; k < rotors; ++k) {
    double walk = 0;
    for (int i = 0; i < n; ++i) {
      walk = 0.9 * walk + 10 * random.normal();
      u.values(i, k) = 600 + d.swing * std::sin(0.8 * i * kPeriod + static_cast<double>(k)) + walk;
    }
    const vehicle::Rotor& rotor = v.rotors[static_cast<std::size_t>(k)];
    const double late = d.board < 0 || rotor.board == d.board ? d.delay : 0;
    constexpr int fine = 80;
    double speed = u.values(0, k);
    for (int i = 0; i < n; ++i) {
      w.values(i, k) = speed + d.noise * random.normal();
      if (d.reading > 0) w.values(i, k) = d.reading * std::round(w.values(i, k) / d.reading);
      for (int j = 0; j < fine; ++j) {
        const double t = i * kPeriod + j * kPeriod / fine - late + 1e-9, h = kPeriod / fine;
        double wanted = u.values(std::max(0, static_cast<int>(t / kPeriod)), k);
        if (d.step > 0) wanted = d.step * std::round(wanted / d.step);
        const double tau = rotor.time_constant * (wanted < speed ? d.slows_by : 1);
        const double next = wanted + (speed - wanted) * std::exp(-h / tau);
        speed = std::clamp(next, speed - d.slew * h, speed + d.slew * h);
      }
    }
  }
  return r;
}

Flight whole() {
  Flight f;
  f.rate_hz = 100;
  for (int i = 0; i < static_cast<int>(kDuration * 100); ++i) f.t.push_back(0.01 * i);
  f.segments.push_back({50, static_cast<int>(f.t.size()) - 50});
  return f;
}

struct Judged {
  DriveInference inference;
  Diagnosis said;  ///< with probabilities
  std::string names;
};

Judged judged(const recording::Recording& r, const vehicle::Vehicle& v, const Flight& f) {
  Judged out;
  out.inference = infer_drives({&r}, {&f}, v, {});
  Diagnosis stage;
  add_drives(out.inference, v, {}, stage);
  add_judged(stage, v, {}, out.said);
  for (const Finding& finding : out.said.findings) out.names += finding.effect + " ";
  return out;
}

TEST(Drives, HeldCommandsOfANominalRotorShowNothing) {
  const vehicle::Vehicle v = omnimorph();
  const Judged j = judged(answers(v, {}), v, whole());
  ASSERT_FALSE(j.inference.empty());
  EXPECT_EQ(j.names, "");
  EXPECT_LT(j.inference.rms_left, 0.5) << "rad/s: noise of 0.1, and commands that change between two steps";
  EXPECT_EQ(on_shared_delay(j.inference), "");
  EXPECT_EQ(j.said.decisions.size(), j.inference.asked.size()) << "what became of each";
  EXPECT_GE(j.inference.asked.size(), 5u);
}

/// Thrusts that pass zero, asked 500 times a second and recorded fifty times: a speed goes with the root of
/// its thrust, so that nobody knows from the samples when a rotor turned round.
recording::Recording reversing(const vehicle::Vehicle& v) {
  constexpr double kFine = 0.002;
  constexpr int kEvery = 10;
  const auto rotors = static_cast<Eigen::Index>(v.rotors.size());
  const int n = static_cast<int>(kDuration / kFine);
  recording::Recording r;
  recording::Signal &u = r.signals["rotor_command"], &w = r.signals["rotor_speed"];
  u.name = "rotor_command";
  w.name = "rotor_speed";
  for (recording::Signal* s : {&u, &w}) s->values.resize(n / kEvery, rotors);
  for (int i = 0; i < n / kEvery; ++i)
    for (recording::Signal* s : {&u, &w}) s->t_s.push_back(i * kEvery * kFine);
  Random random(5, "reversing drives");
  for (Eigen::Index k = 0; k < rotors; ++k) {
    const vehicle::Rotor& rotor = v.rotors[static_cast<std::size_t>(k)];
    double quick = 0, speed = 0;
    for (int i = 0; i < n; ++i) {
      quick = 0.97 * quick + 0.05 * random.normal();
      const double thrust = 2 * std::sin(0.9 * i * kFine + static_cast<double>(k)) + quick;
      const double wanted = std::copysign(std::sqrt(std::abs(thrust) / rotor.thrust_coefficient), thrust);
      if (i % kEvery == 0) {
        u.values(i / kEvery, k) = wanted;
        w.values(i / kEvery, k) = speed + 0.5 * random.normal();
      }
      speed = wanted + (speed - wanted) * std::exp(-kFine / rotor.time_constant);
    }
  }
  return r;
}

TEST(Drives, RotorsThatReverseBetweenSamplesShowNothing) {
  const vehicle::Vehicle v = omnimorph();
  const Judged j = judged(reversing(v), v, whole());
  ASSERT_FALSE(j.inference.empty());
  EXPECT_EQ(j.names, "");
}

TEST(Drives, TelemetryThatReadsInStepsIsNoQuantisedCommand) {
  const vehicle::Vehicle v = omnimorph();
  EXPECT_EQ(judged(answers(v, {.reading = 8}), v, whole()).names, "");
}

TEST(Drives, ADelayOfAllBoardsIsSaidAndNotClaimed) {
  const vehicle::Vehicle v = omnimorph();
  const Judged j = judged(answers(v, {.delay = 0.006}), v, whole());
  EXPECT_NEAR(j.inference.offset_s, 0.006, 0.0005);
  EXPECT_EQ(j.names, "");
  EXPECT_NE(on_shared_delay(j.inference).find("6 ms later"), std::string::npos)
      << on_shared_delay(j.inference);
}

TEST(Drives, OneLateBoardIsFound) {
  const vehicle::Vehicle v = omnimorph();
  const Judged j = judged(answers(v, {.board = 1, .delay = 0.011}), v, whole());
  ASSERT_EQ(j.names, "transport_delay ");
  EXPECT_LT(j.said.findings[0].parameters[0].value, 0.0008);
  EXPECT_NEAR(j.said.findings[0].parameters[1].value, 0.011, 0.0008);
  EXPECT_GT(j.said.findings[0].probability, 0.95);
}

TEST(Drives, AQuickerMotorThanTheFileSaysIsFound) {
  const vehicle::Vehicle v = omnimorph();
  vehicle::Vehicle told = v;
  const double tau = v.rotors[0].time_constant;
  for (vehicle::Rotor& r : told.rotors) r.time_constant = tau + 0.02;
  const Judged j = judged(answers(v, {}), told, whole());
  ASSERT_EQ(j.names, "motor_lag ");
  const ParameterValue& lag = j.said.findings[0].parameters[0];
  EXPECT_NEAR(lag.value, -0.02, 0.002);
  EXPECT_LT(lag.low, -0.02);
  EXPECT_GT(lag.high, -0.02);
  ASSERT_EQ(j.said.model.size(), 1u);
  physics::Actuation a;
  a.time_constant.assign(told.rotors.size(), told.rotors[0].time_constant);
  j.said.model[0].effect->alter_actuation(told, j.said.model[0].theta.data(), a);
  EXPECT_NEAR(a.time_constant[0], tau, 0.002) << "s, as the simulator would fly the model";
}

/// Speeds hardly ever rest where commands move as here, and tell of no step by themselves.
TEST(Drives, CommandsInStepsAreFoundThroughTheLag) {
  const vehicle::Vehicle v = omnimorph();
  const Judged j = judged(answers(v, {.step = 21}), v, whole());
  ASSERT_EQ(j.names, "command_quantisation ");
  EXPECT_NEAR(j.said.findings[0].parameters[1].value, 21, 0.3);
  EXPECT_GT(j.said.findings[0].probability, 0.95);
}

TEST(Drives, ALimitedAccelerationIsFound) {
  const vehicle::Vehicle v = omnimorph();
  const Judged j = judged(answers(v, {.slew = 400, .swing = 150}), v, whole());
  ASSERT_EQ(j.names, "actuator_saturation ");
  EXPECT_NEAR(j.said.findings[0].parameters[1].value, 400, 40);
}

/// No law of the library: the nearest is named, and what it leaves is no further effect.
TEST(Drives, MotorsThatSlowDownByTheirDragAreSlowMotors) {
  const vehicle::Vehicle v = omnimorph();
  EXPECT_EQ(judged(answers(v, {.slows_by = 2.5}), v, whole()).names, "motor_lag ");
}

TEST(Drives, AnotherClockIsNoDelay) {
  const vehicle::Vehicle v = omnimorph();
  Flight f = whole();
  f.alignment.push_back({"gyro", "attitude", 0.0003, 1e-4, 0, 1e-6, 0.99});
  const recording::Recording r = answers(v, {.clock = 0.015});
  EXPECT_EQ(judged(r, v, f).names, "transport_delay ") << "of clocks that are said to agree";
  f.alignment[0].lag_s = -0.015;
  EXPECT_EQ(judged(r, v, f).names, "");
  f.alignment.clear();  // nothing tells whether the clocks agree
  EXPECT_EQ(judged(r, v, f).names, "");
  // a board that is later than the other shows through the clock
  const Judged late = judged(answers(v, {.board = 0, .delay = 0.011, .clock = 0.012}), v, f);
  ASSERT_EQ(late.names, "transport_delay ");
  EXPECT_NEAR(late.said.findings[0].parameters[0].value - late.said.findings[0].parameters[1].value, 0.011,
              0.001);
}

}  // namespace
}  // namespace omniflight::diagnosis
