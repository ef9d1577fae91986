// Fits of laws with kinks, where no Gauss-Newton step leads ahead, however short.
#include "../src/fit.hpp"

#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// A cable has two kinks, where it leaves the floor and where all of it is in the air; its lever, which is
/// not fitted, pulls at both.
TEST(Fit, ACableIsFoundAcrossItsKinks) {
  const vehicle::Vehicle v = test::omnimorph();
  const physics::Effect* cable = physics::find_effect("hung_cable");
  const physics::ActiveEffect lever{physics::find_effect("attachment_torque"), {0, 0, -0.012, 0.1}};
  test::Flown f;
  f.climb_m = 1.1, f.sway = 0.2;
  f.force_noise_N = 0.01, f.torque_noise_Nm = 0.001;
  const Options o;
  for (const double length : {0.6, 0.8}) {
    const physics::ActiveEffect truth{cable, {0.15, 0.5, length}};
    const auto flight = prepare_flight(test::fly(v, {truth, lever}, f), v, o);
    ASSERT_TRUE(flight) << flight.error().text();
    const Flight* one[] = {&*flight};
    const Problem problem(one, v, o);
    const Fit none = fit_effects(problem, {}, o), near = fit_effects(problem, {truth}, o),
              found = fit_with(problem, none, *cable, o);
    printf("%.4f kg/m from %.3f m on, %.3f m long; %.1f nats behind one that starts at the truth\n",
           found.effects[0].theta[0], found.effects[0].theta[1], found.effects[0].theta[2],
           near.log_likelihood - found.log_likelihood);
    EXPECT_GT(found.log_likelihood - none.log_likelihood, 10000);
    EXPECT_GT(found.log_likelihood, near.log_likelihood - 3);
  }
}

/// Its end on the floor, its length and where it is tied bend together.
TEST(Fit, ATautRopeIsFoundWhereverItsEndLies) {
  const vehicle::Vehicle v = test::omnimorph();
  const physics::Effect* rope = physics::find_effect("taut_rope");
  test::Flown f;
  f.climb_m = 1.1;
  f.force_noise_N = 0.01, f.torque_noise_Nm = 0.001;
  const Options o;
  for (const Vec3& end : {Vec3(0, 0, 0), Vec3(0.35, -0.2, 0.1)}) {
    const double length = (test::path(f.duration_s, f) - end).norm() - 0.15;
    const physics::ActiveEffect truth{rope, {60, 1, length, end.x(), end.y(), end.z(), 0}};
    const auto flight = prepare_flight(test::fly(v, {truth}, f), v, o);
    ASSERT_TRUE(flight) << flight.error().text();
    const Flight* one[] = {&*flight};
    const Problem problem(one, v, o);
    const Fit none = fit_effects(problem, {}, o), near = fit_effects(problem, {truth}, o),
              found = fit_with(problem, none, *rope, o);
    printf("%.1f N/m from %.3f m on for %.1f N/m from %.3f m; %.1f nats of %.1f behind one from the truth\n",
           found.effects[0].theta[0], found.effects[0].theta[2], 60.0, length,
           near.log_likelihood - found.log_likelihood, near.log_likelihood - none.log_likelihood);
    // a search that ends while it still creeps along the valley found 6.5 N/m, 12546 nats behind
    EXPECT_LT(near.log_likelihood - found.log_likelihood,
              3 + 1e-5 * (near.log_likelihood - none.log_likelihood));
    EXPECT_NEAR(found.effects[0].theta[0], 60, 1);
  }
}

/// On instruments a mass that moves as they say makes a law no less linear: its columns are known once and
/// for all. Held against the law itself.
TEST(Fit, LinearLawsWithMassAreLinearOnInstruments) {
  const vehicle::Vehicle v = test::omnimorph();
  test::Flown f;
  f.sway = 0.25;
  const Options o;
  auto flight = prepare_flight(test::fly(v, {}, f), v, o);
  ASSERT_TRUE(flight) << flight.error().text();
  const Flight* one[] = {&*flight};
  const Problem measured(one, v, o);
  flight->instrument = flight->smooth;
  const Problem problem(one, v, o);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem.offset_sigma().size());
  const int n = problem.samples();
  int asked = 0;
  for (const physics::Effect* effect : physics::builtin_effects()) {
    if (!adds_inertia(*effect) || !is_linear(*effect) || effect->memory_size().total() > 0) continue;
    ++asked;
    EXPECT_TRUE(problem.has_constant_columns(*effect)) << effect->info().id;
    EXPECT_FALSE(measured.has_constant_columns(*effect)) << effect->info().id;
    physics::ActiveEffect some{effect, {}};
    for (const physics::Parameter& p : effect->info().parameters)
      some.theta.push_back(p.neutral + 0.7 * (p.typical - p.neutral));
    Eigen::VectorXd before, after;
    problem.predict({}, none, before, nullptr);
    problem.predict({some}, none, after, nullptr);
    for (int i = 0; i < n; i += 50) {
      physics::Wrench own;
      effect->add_wrench(problem.situation(i), some.theta.data(), own);
      const Vec6 w = own.at(problem.situation(i));
      for (int c = 0; c < 6; ++c)
        ASSERT_NEAR(before[c * n + i] - after[c * n + i], w[c], 1e-9) << effect->info().id << " " << c;
    }
  }
  EXPECT_GE(asked, 3);
}

/// A problem remembers what laws that bend did; asked again, among others and in another order, beside a load
/// that moves them or not, it answers as one that was never asked.
TEST(Fit, WhatIsRememberedIsWhatALawDoes) {
  const vehicle::Vehicle v = test::omnimorph();
  test::Flown f;
  f.climb_m = 1.1, f.sway = 0.2;
  const Options o;
  auto flight = prepare_flight(test::fly(v, {}, f), v, o);
  ASSERT_TRUE(flight) << flight.error().text();
  const physics::ActiveEffect cable{physics::find_effect("hung_cable"), {0.15, 0.5, 0.7}},
      longer{physics::find_effect("hung_cable"), {0.15, 0.5, 0.9}},
      slung{physics::find_effect("slung_load"), {0.05, 0.6, 0.1, 0.01, -0.01, 0.02}},
      load{physics::find_effect("payload_mass"), {0.1}};
  const std::vector<std::vector<physics::ActiveEffect>> models{{cable},         {longer},       {load, cable},
                                                               {cable, longer}, {slung, cable}, {cable},
                                                               {load, cable},   {longer, slung}};
  for (const bool instrumented : {false, true}) {
    if (instrumented) flight->instrument = flight->smooth;
    const Flight* one[] = {&*flight};
    const Problem asked(one, v, o);
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(asked.offset_sigma().size());
    for (const auto& model : models) {
      const Problem fresh(one, v, o);
      Eigen::VectorXd rest, again;
      Eigen::MatrixXd jacobian, same;
      fresh.predict(model, none, rest, &jacobian);
      asked.predict(model, none, again, &same);
      EXPECT_EQ(rest, again);
      EXPECT_EQ(jacobian, same);
      EXPECT_EQ(fresh.noise().apply(fresh, jacobian), asked.whitened(model, same));
      EXPECT_EQ(fresh.noise().apply(fresh, jacobian), asked.whitened(model, same)) << "whitened twice";
    }
  }
}

/// Bends that were found are found again near where they were, without the whole grid.
TEST(Fit, BendsAreFoundAgainNearWhereTheyWere) {
  const vehicle::Vehicle v = test::omnimorph();
  test::Flown f;
  f.climb_m = 1.1;
  f.force_noise_N = 0.01, f.torque_noise_Nm = 0.001;
  const Options o;
  const physics::Effect* cable = physics::find_effect("hung_cable");
  std::vector<double> found;
  for (const double start : {0.5, 0.53}) {  // much the same flight
    const auto flight = prepare_flight(test::fly(v, {{cable, {0.15, start, 0.6}}}, f), v, o);
    ASSERT_TRUE(flight) << flight.error().text();
    const Flight* one[] = {&*flight};
    const Problem problem(one, v, o);
    const Fit none = fit_effects(problem, {}, o);
    const Fit grid = fit_on_grid(problem, none, *cable, o);
    if (!found.empty()) {
      const Fit again = fit_on_grid(problem, none, *cable, o, &found);
      EXPECT_GT(again.log_likelihood, grid.log_likelihood - 1);
    }
    found = grid.effects[0].theta;
  }
}

/// Every fifth sample of each stretch, with what a law does there.
TEST(Fit, FewSamplesAreThoseOfTheWhole) {
  const vehicle::Vehicle v = test::omnimorph();
  test::Flown f;
  f.climb_m = 1.1;
  const Options o;
  f.force_noise_N = 0.01, f.torque_noise_Nm = 0.001;
  const double length = test::path(f.duration_s, f).norm() - 0.15;
  const physics::ActiveEffect rope{physics::find_effect("taut_rope"), {60, 1, length, 0, 0, 0, 0}};
  const auto flight = prepare_flight(test::fly(v, {rope}, f), v, o);
  ASSERT_TRUE(flight) << flight.error().text();
  const Flight* one[] = {&*flight};
  const Problem problem(one, v, o);
  constexpr int kEvery = 5;
  const Problem few = problem.thinned(problem.residual(), kEvery);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem.offset_sigma().size());
  Eigen::VectorXd rest, rest_of_few;
  problem.predict({rope}, none, rest, nullptr);
  few.predict({rope}, none, rest_of_few, nullptr);
  ASSERT_EQ(few.runs().size(), problem.runs().size());
  EXPECT_NEAR(few.samples(), problem.samples() / kEvery, static_cast<double>(few.runs().size()));
  for (std::size_t r = 0; r < few.runs().size(); ++r)
    for (int k = few.runs()[r].begin; k < few.runs()[r].end; ++k) {
      const int i = problem.runs()[r].begin + kEvery * (k - few.runs()[r].begin);
      for (int c = 0; c < 6; ++c)
        ASSERT_NEAR(rest_of_few[c * few.samples() + k], rest[c * problem.samples() + i], 1e-12);
    }
  const Fit with = fit_with(few, fit_effects(few, {}, o), *rope.effect, o);
  EXPECT_NEAR(with.effects[0].theta[0], 60, 6);
}

}  // namespace
}  // namespace omniflight::diagnosis
