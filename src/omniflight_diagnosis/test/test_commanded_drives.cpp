// Drives of a flight whose rotor speeds are not recorded: what alters them is seen in the wrench that they do
// not give.
#include <gtest/gtest.h>

#include "../src/regression/regression_problem.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using test::omnimorph;

/// Replaces the speeds by the commands that give them through the lag of the vehicle file and `more` seconds
/// of it, `delay` seconds late.
void only_commands(recording::Recording& r, const vehicle::Vehicle& v, double more, double delay) {
  recording::Signal command = r.signals["rotor_speed"];
  const recording::Signal speed = command;
  command.name = "rotor_command";
  const Eigen::Index last = speed.size() - 1;
  const double period = speed.t_s[1] - speed.t_s[0];
  for (Eigen::Index k = 0; k < speed.width(); ++k)
    for (Eigen::Index i = 0; i <= last; ++i) {
      const double lag = v.rotors[static_cast<std::size_t>(k)].time_constant + more;
      const auto at = [&](double index) {
        const double x = std::clamp(index, 0.0, static_cast<double>(last));
        const auto j = std::min(static_cast<Eigen::Index>(x), last - 1);
        return speed.values(j, k) +
               (x - static_cast<double>(j)) * (speed.values(j + 1, k) - speed.values(j, k));
      };
      const double now = static_cast<double>(i) + delay / period;
      command.values(i, k) = at(now) + lag * (at(now + 1) - at(now - 1)) / (2 * period);
    }
  r.signals.erase("rotor_speed");
  r.signals["rotor_command"] = command;
}

test::Flown lively() {
  test::Flown out;
  out.sway = 0.1;
  out.wanders = true;  // a force that pulsates would explain one sinusoid as well
  out.speed_noise = 0;
  out.force_noise_N = 0.03;
  out.torque_noise_Nm = 0.005;
  return out;
}

/// Of a flight with commands alone, whose drives are as told.
RegressionProblem of_nominal_drives(double horizon_s) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = test::fly(v, {}, lively());
  only_commands(r, v, 0, 0);
  const Options o;
  const auto flight = prepare_flight(r, v, o);
  EXPECT_TRUE(flight) << flight.error().text();
  const Flight* one[] = {&*flight};
  return RegressionProblem(one, v, o, Horizon{horizon_s});
}

const Finding* find(const Diagnosis& d, const std::string& id) {
  for (const Finding& f : d.findings)
    if (f.effect == id) return &f;
  return nullptr;
}

TEST(CommandedDrives, NothingIsNamedWhereTheDrivesAreAsTold) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = test::fly(v, {}, lively());
  only_commands(r, v, 0, 0);
  const auto d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(d->verdict, Verdict::nothing_missing) << d->summary;
}

TEST(CommandedDrives, ADelayWithinItsToleranceIsNoMotorLag) {
  const vehicle::Vehicle v = omnimorph();
  for (const double delay_s : {0.004, -0.004}) {
    recording::Recording r = test::fly(v, {}, lively());
    only_commands(r, v, 0, delay_s);
    const auto d = diagnose(std::span(&r, 1), {}, v);
    ASSERT_TRUE(d) << d.error().text();
    EXPECT_EQ(d->verdict, Verdict::nothing_missing) << delay_s << ": " << d->summary;
  }
}

/// Cosine between two columns.
double alike(const Eigen::VectorXd& x, const Eigen::VectorXd& y) { return x.dot(y) / (x.norm() * y.norm()); }

TEST(CommandedDrives, CommandsPredictWhatTheirDelayDoes) {
  const RegressionProblem problem = of_nominal_drives(0.05);
  const auto& names = problem.calibration().names;
  for (const char* name : {"rotor_clock_force", "rotor_clock_torque"}) {
    const auto at = std::find(names.begin(), names.end(), name);
    ASSERT_NE(at, names.end()) << name;
    const Eigen::Index k = at - names.begin();
    EXPECT_GT(alike(problem.calibration().columns.col(k), problem.calibration().measured.col(k)), 0.8)
        << name;
  }
}

TEST(CommandedDrives, SlowerMotorsAreNamedWithTheirLag) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = test::fly(v, {}, lively());
  only_commands(r, v, 0.06, 0);
  const auto d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(d) << d.error().text();
  const Finding* lag = find(*d, "motor_lag");
  const Finding* found = lag ? lag : find(*d, "transport_delay");
  ASSERT_TRUE(found) << d->summary;
  if (lag) {
    EXPECT_NEAR(lag->parameters[0].value, 0.06, 0.02);
  }
  const auto& alike = found->cannot_be_told_apart_from;
  EXPECT_TRUE(lag || std::find(alike.begin(), alike.end(), "motor_lag") != alike.end()) << d->summary;
  EXPECT_EQ(found->stage, physics::Stage::actuation);
}

TEST(CommandedDrives, TheWrenchOfADelayIsThatOfLaterThrust) {
  const RegressionProblem problem = of_nominal_drives(0.1);
  const physics::Effect* delay = physics::find_effect("transport_delay");
  ASSERT_TRUE(delay);
  Eigen::VectorXd value;
  Eigen::MatrixXd by_theta;
  problem.wrench_of({delay, {0, 0}, {}}, value, &by_theta, nullptr, States::measured);
  EXPECT_EQ(value.norm(), 0);
  problem.wrench_of({delay, {0.02, 0.02}, {}}, value, &by_theta, nullptr, States::measured);
  // to first order minus 20 ms times the rate of the rotors' force
  const int n = problem.samples();
  double error = 0, size = 0;
  for (int i = 1; i + 1 < n; ++i) {
    const double rate = (physics::rotor_wrench(problem.measured(i + 1))[2] -
                         physics::rotor_wrench(problem.measured(i - 1))[2]) /
                        (2 * problem.period());
    error += std::pow(value[2 * n + i] + 0.02 * rate, 2);
    size += std::pow(0.02 * rate, 2);
  }
  EXPECT_LT(error, 0.05 * size);
  // both boards together make the whole
  EXPECT_LT((by_theta.rowwise().sum() * 0.02 - value).norm(), 0.2 * value.norm());
}

}  // namespace
}  // namespace omniflight::diagnosis
