// Whatever numbers come, control laws and estimators answer finite ones, and what they refuse leaves no
// trace: a twin that was never given it answers the same bits.
#include "hostile_numbers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <span>

#include "omniflight_control/error_state_filter.hpp"
#include "omniflight_control/estimator.hpp"
#include "omniflight_control/law.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::control {
namespace {

using hostile::any_number;

Vec3 sound_vector(Random& random, double size) {
  return size * Vec3(random.normal(), random.normal(), random.normal());
}
Quat sound_attitude(Random& random) {
  return Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
}

/// One call of a law: sound where nothing else is said.
struct Call {
  Reference r;
  RigidState s;
  double dt = 0.002;
  Vec6 unachieved = Vec6::Zero();
};

Call sound_call(Random& random) {
  Call c;
  c.r.p_WB = sound_vector(random, 1.0);
  c.r.q_WB = sound_attitude(random);
  c.r.v_WB_W = sound_vector(random, 1.0);
  c.r.w_WB_B = sound_vector(random, 1.0);
  c.r.a_WB_W = sound_vector(random, 1.0);
  c.r.dw_WB_B = sound_vector(random, 5.0);
  c.s = {sound_vector(random, 1.0), sound_attitude(random), sound_vector(random, 1.0),
         sound_vector(random, 1.0)};
  c.unachieved.head<3>() = sound_vector(random, 1.0);
  c.unachieved.tail<3>() = sound_vector(random, 5.0);
  return c;
}

/// Puts any number in one place, sometimes in several.
void spoil(Call& c, Random& random) {
  const auto of = [](auto& v) { return std::span(v.data(), 3); };
  const std::span<double> places[] = {of(c.r.p_WB),
                                      of(c.r.v_WB_W),
                                      of(c.r.w_WB_B),
                                      of(c.r.a_WB_W),
                                      of(c.r.dw_WB_B),
                                      of(c.s.p_WB),
                                      of(c.s.v_WB_W),
                                      of(c.s.w_WB_B),
                                      std::span(c.unachieved.data(), 6),
                                      std::span(c.r.q_WB.coeffs().data(), 4),
                                      std::span(c.s.q_WB.coeffs().data(), 4),
                                      std::span(&c.dt, 1)};
  do {
    const auto place = places[static_cast<std::size_t>(random.uniform() * std::size(places))];
    place[static_cast<std::size_t>(random.uniform() * static_cast<double>(place.size()))] =
        any_number(random);
  } while (random.uniform() < 0.3);
}

/// The widest demand that a law may answer: feedback at its bounds, what it has learnt, the reference's own.
bool within_bounds(const Vec6& demand, const Call& c, const ControllerConfig& g) {
  if (!demand.allFinite()) return false;
  const double leaning = kGravity;  // the lean limit lifts a demand to a fall of 0.7 g at most
  const double most = g.max_acceleration + g.max_integral_acceleration + c.r.a_WB_W.norm() + leaning;
  return demand.head<3>().cwiseAbs().maxCoeff() <= 2.0 * most;
}

/// Bits of two demands.
bool equal(const Vec6& a, const Vec6& b) { return (a.array() == b.array()).all(); }

class HostileLaws : public ::testing::TestWithParam<std::tuple<std::string, bool>> {};

TEST_P(HostileLaws, AnswerFiniteDemandsAndForgetWhatTheyRefused) {
  const auto& [name, leans] = GetParam();
  LawConfig config;
  if (leans) config.thrust_axis_B = Vec3::UnitZ();
  const auto law = make_law(name, config).value(), twin = make_law(name, config).value();
  Random random(7);
  long refused = 0, unsound = 0, traces = 0, answered = 0;
  const long calls = hostile::samples();
  for (long k = 0; k < calls; ++k) {
    Call c = sound_call(random);
    if (random.uniform() < 0.5) spoil(c, random);
    const unsigned long before = law->refused();
    const Vec6 demand = law->update(c.r, c.s, c.dt, c.unachieved);
    if (!demand.allFinite()) ++unsound;
    if (law->refused() > before) {
      ++refused;
      continue;
    }
    ++answered;
    unsound += !within_bounds(demand, c, config.gains);
    traces += !equal(demand, twin->update(c.r, c.s, c.dt, c.unachieved));
    unsound += !law->integral_action().allFinite();
  }
  std::printf(
      "%ld hostile inputs to the law %s%s: %ld refused, %ld out of bounds, %ld traces of refused ones\n",
      calls, name.c_str(), leans ? ", leaning" : "", refused, unsound, traces);
  EXPECT_EQ(unsound, 0);
  EXPECT_EQ(traces, 0);
  EXPECT_EQ(twin->refused(), 0u);
  EXPECT_GT(refused, calls / 20);
  EXPECT_GT(answered, calls / 2);
}

INSTANTIATE_TEST_SUITE_P(Laws, HostileLaws,
                         ::testing::Values(std::tuple("full_pose", false), std::tuple("thrust_vector", true),
                                           std::tuple("cascaded", false), std::tuple("cascaded", true),
                                           std::tuple("incremental", false),
                                           std::tuple("incremental", true)));

TEST(HostileLaws, ARefusedInputRepeatsTheLastDemand) {
  for (const char* name : {"full_pose", "cascaded", "incremental"}) {
    const auto law = make_law(name, {}).value();
    Random random(1);
    Call c = sound_call(random);
    const Vec6 before = law->update(c.r, c.s, c.dt, c.unachieved);
    c.s.p_WB.x() = NAN;
    EXPECT_TRUE(equal(law->update(c.r, c.s, c.dt, c.unachieved), before)) << name;
    EXPECT_EQ(law->refused(), 1u) << name;
    law->reset();
    EXPECT_TRUE(law->update(c.r, c.s, c.dt, c.unachieved).isZero()) << name << ": nothing was asked before";
  }
}

/// A vehicle at rest whose sensors tell the truth, between samples that no sensor has.
template <class EstimatorUnderTest, class Config>
void feed(const char* name) {
  EstimatorUnderTest estimator{Config{}}, twin{Config{}};
  Random random(11);
  const Vec3 still(0, 0, kGravity), at(1, 2, 3);
  long hostile_ones = 0, unsound = 0, traces = 0;
  const long steps = hostile::samples() / 4;
  double t = 0.0;
  const auto state_is_sound = [](const StateEstimator& e) {
    const RigidState& s = e.state();
    return s.p_WB.allFinite() && s.v_WB_W.allFinite() && s.w_WB_B.allFinite() &&
           std::abs(s.q_WB.norm() - 1.0) < 1e-6;
  };
  const auto vector = [&] { return Vec3(any_number(random), any_number(random), any_number(random)); };
  const auto attitude = [&] {
    return Quat(any_number(random), any_number(random), any_number(random), any_number(random));
  };
  for (long k = 0; k < steps; ++k) {
    t += 0.002;
    estimator.add_imu(t, still, Vec3::Zero());
    twin.add_imu(t, still, Vec3::Zero());
    if (k % 5 == 0) {
      estimator.add_mocap(t, at, Quat::Identity());
      twin.add_mocap(t, at, Quat::Identity());
    }
    // of the next period, broken in one number at least, or sound and too late: none may leave a trace
    const double roll = random.uniform();
    const unsigned long before = estimator.refused();
    if (roll < 0.4) {
      Vec3 f = vector();
      f[static_cast<int>(random.uniform() * 3.0)] = random.uniform() < 0.5 ? NAN : 1e308;
      estimator.add_imu(t + 0.001, random.uniform() < 0.5 ? f : still, f);
    } else if (roll < 0.8) {
      Vec3 p = vector();
      p[static_cast<int>(random.uniform() * 3.0)] = random.uniform() < 0.5 ? -HUGE_VAL : 1e7;
      estimator.add_mocap(t + 0.001, p, attitude());
    } else if (roll < 0.9) {
      const double times[] = {NAN, HUGE_VAL, -HUGE_VAL, 1e308, t - 0.5, t};
      estimator.add_imu(times[static_cast<std::size_t>(random.uniform() * 6.0)], still, Vec3::Zero());
    } else {
      const double lengths[] = {0.0, 1e-300, 1e154, NAN, 3.0};
      Quat q = Quat::Identity();
      q.coeffs() *= lengths[static_cast<std::size_t>(random.uniform() * 5.0)];
      estimator.add_mocap(t + 0.001, at, q);
    }
    hostile_ones += estimator.refused() - before;
    unsound += !state_is_sound(estimator);
    traces +=
        !(estimator.state().p_WB == twin.state().p_WB && estimator.state().v_WB_W == twin.state().v_WB_W &&
          estimator.state().q_WB.coeffs() == twin.state().q_WB.coeffs());
  }
  std::printf("%ld hostile inputs to the estimator %s: all refused: %s, %ld unsound, %ld traces\n", steps,
              name, hostile_ones == steps ? "yes" : "no", unsound, traces);
  EXPECT_EQ(hostile_ones, steps);
  EXPECT_EQ(unsound, 0);
  EXPECT_EQ(traces, 0);
  EXPECT_LT((estimator.state().p_WB - at).norm(), 1e-3);
}

TEST(HostileEstimators, TheObserverRefusesThem) { feed<Estimator, EstimatorConfig>("fixed_gain"); }
TEST(HostileEstimators, TheErrorStateFilterRefusesThem) {
  feed<ErrorStateFilter, ErrorStateConfig>("error_state");
}

/// Numbers at the limits of what is taken, every sample another: wild, and nothing overflows.
template <class EstimatorUnderTest, class Config>
void feed_wild() {
  EstimatorUnderTest estimator{Config{}};
  Random random(13);
  double t = 0.0;
  const long steps = hostile::samples() / 10;
  for (long k = 0; k < steps; ++k) {
    t += random.uniform() < 0.01 ? 1e4 : 0.002;
    const auto extreme = [&](double most) -> Vec3 {
      return most * Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    };
    estimator.add_imu(t, extreme(SensorLimits::specific_force), extreme(SensorLimits::rate));
    if (k % 3 == 0)
      estimator.add_mocap(t - 0.01 * random.uniform(), extreme(SensorLimits::position),
                          sound_attitude(random));
    const RigidState& s = estimator.state();
    ASSERT_TRUE(s.p_WB.allFinite() && s.v_WB_W.allFinite() && s.w_WB_B.allFinite() &&
                s.q_WB.coeffs().allFinite())
        << "after " << k << " steps";
  }
  EXPECT_TRUE(estimator.ready());
}

TEST(HostileEstimators, TheObserverStaysFiniteAtTheLimits) { feed_wild<Estimator, EstimatorConfig>(); }
TEST(HostileEstimators, TheErrorStateFilterStaysFiniteAtTheLimits) {
  feed_wild<ErrorStateFilter, ErrorStateConfig>();
}

}  // namespace
}  // namespace omniflight::control
