// Evidence of sets of hypotheses against what it is by definition.
#include <cmath>
#include <set>

#include "../src/evidence/first_stage.hpp"
#include "../src/evidence/tolerances.hpp"
#include "../src/search/inference.hpp"

#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::find_effect;

/// One short flight in a world, conditioned for the posterior.
Flight flown(const vehicle::Vehicle& v, const Options& o, const std::vector<physics::ActiveEffect>& world,
             double duration_s) {
  test::Flown f;
  f.duration_s = duration_s;
  f.sway = 0.2;
  f.damped = false;  // known defect: with it the rotor askew of `Tolerances` has log odds of 1 only
  auto flight = prepare_flight(test::fly(v, world, f), v, o);
  EXPECT_TRUE(flight);
  return *flight;
}

struct Setting {
  vehicle::Vehicle vehicle = test::omnimorph();
  Options options;
  Flight flight;
  std::unique_ptr<RegressionProblem> problem;
  std::unique_ptr<NoiseModel> noise;
  std::vector<Hypothesis> hypotheses;

  Setting(const std::vector<std::string>& ids, const std::vector<physics::ActiveEffect>& world,
          double duration_s = 8, Options told = {})
      : options(std::move(told)) {
    flight = flown(vehicle, options, world, duration_s);
    const Flight* one[] = {&flight};
    problem = std::make_unique<RegressionProblem>(one, vehicle, options, Horizon{0.15});
    std::vector<const physics::Effect*> effects;
    for (const std::string& id : ids) effects.push_back(find_effect(id));
    noise = estimate_noise(*problem, slow_columns(*problem), Eigen::VectorXd::Zero(problem->rows()), 1);
    problem->scale_calibration(first_stages(noise->apply(problem->calibration().columns),
                                            noise->apply(problem->calibration().measured)));
    hypotheses = make_hypotheses(*problem, *noise, effects, options);
  }
};

/// Tolerances as they are assumed.
Eigen::VectorXd assumed(const RegressionProblem& problem) {
  return Eigen::VectorXd::Ones(problem.calibration().settled.size());
}

/// ln N(z; 0, I + X X^T), up to the constant of N(0, I).
double log_density(const Eigen::VectorXd& z, const Eigen::MatrixXd& X) {
  const Eigen::MatrixXd C = Eigen::MatrixXd::Identity(z.size(), z.size()) + X * X.transpose();
  const Eigen::LLT<Eigen::MatrixXd> factor(C);
  return -0.5 * z.dot(factor.solve(z)) - factor.matrixLLT().diagonal().array().log().sum();
}

TEST(Evidence, OfALinearEffectIsTheMarginalDensityOfTheData) {
  const Setting s({"com_offset"}, {{find_effect("com_offset"), {0.004, 0, 0.003}}});
  const Evidence evidence(*s.problem, *s.noise, s.hypotheses, 0, assumed(*s.problem));
  const Eigen::VectorXd z = s.noise->apply(s.problem->residual());
  const Eigen::MatrixXd B = s.noise->apply(s.problem->calibration().columns);
  const SetFit nothing = evidence.fit({});
  EXPECT_NEAR(nothing.log_evidence, log_density(z, B), 1e-6 * std::abs(nothing.log_evidence));

  const SetFit one = evidence.fit({evidence.member_at(0, 0, Vec3(1, -1, 0.5))});  // from anywhere
  Eigen::MatrixXd X(z.size(), B.cols() + 3);
  X << B, s.hypotheses[0].points[0].columns;
  EXPECT_NEAR(one.log_evidence, log_density(z, X), 1e-6 * std::abs(one.log_evidence));
}

/// A laboratory that told how well thrust carries the weight, and how small force and torque of hover are.
Options totals_told() {
  Options o;
  o.tolerance.told = {"thrust_scale", "torque_trim", "world_force"};
  o.tolerance.thrust_scale = o.tolerance.torque_trim = o.tolerance.world_force = 1e-3;
  return o;
}

TEST(Evidence, IsThatOfPartsWhoseTotalsAreTold) {
  const Setting s({}, {}, 8, totals_told());
  const Evidence evidence(*s.problem, *s.noise, s.hypotheses, 0, assumed(*s.problem));
  const Calibration& c = s.problem->calibration();
  const Eigen::MatrixXd& H = c.totals;
  const Eigen::MatrixXd P = (Eigen::MatrixXd::Identity(H.cols(), H.cols()) + H.transpose() * H).inverse();
  const Eigen::MatrixXd B = s.noise->apply(c.columns) * Eigen::MatrixXd(P.llt().matrixL());
  const SetFit nothing = evidence.fit({});
  EXPECT_NEAR(nothing.log_evidence, log_density(s.noise->apply(s.problem->residual()), B),
              1e-6 * std::abs(nothing.log_evidence));

  // rotors as wrong as is assumed would miss the weight and turn the vehicle by more than was told
  const Eigen::VectorXd assumed_totals = (H * H.transpose()).diagonal().cwiseSqrt(),
                        known_totals = (H * P * H.transpose()).diagonal().cwiseSqrt();
  for (int k = 2; k < 5; ++k) EXPECT_GT(assumed_totals[k], 3) << k;
  EXPECT_LT(known_totals.maxCoeff(), 1);
  const auto one = std::find(c.names.begin(), c.names.end(), "rotor_scale_1") - c.names.begin();
  EXPECT_GT(P(one, one), 0.3) << "one by itself may still be wrong";
}

TEST(Evidence, ASignThatPhysicsGivesHalvesThePriorAndKeepsTheRightHalf) {
  const Setting s({"rotor_drag"}, {});
  const Evidence evidence(*s.problem, *s.noise, s.hypotheses, 0, assumed(*s.problem));
  const SetFit one = evidence.fit({evidence.member_at(0, 0, Eigen::VectorXd::Ones(1))});
  // by quadrature over u >= 0 of the density 2 N(u; 0, 1)
  const Eigen::VectorXd z = s.noise->apply(s.problem->residual());
  const Eigen::MatrixXd B = s.noise->apply(s.problem->calibration().columns);
  const Eigen::VectorXd x = s.hypotheses[0].points[0].columns.col(0);
  const double base = log_density(z, B);
  const Eigen::MatrixXd C = Eigen::MatrixXd::Identity(z.size(), z.size()) + B * B.transpose();
  const Eigen::LLT<Eigen::MatrixXd> factor(C);
  const Eigen::VectorXd by_z = factor.solve(z), by_x = factor.solve(x);
  double sum = 0;
  constexpr double kStep = 0.0005;
  for (double u = kStep / 2; u < 4; u += kStep)  // ln N(z - u x) - ln N(z) is a parabola in u
    sum +=
        kStep * 2 / std::sqrt(2 * kPi) * std::exp(-0.5 * u * u + u * x.dot(by_z) - 0.5 * u * u * x.dot(by_x));
  EXPECT_NEAR(one.log_evidence - base, std::log(sum), 0.02);
}

/// Two effects that look alike, and of which the residual is the opposite: both are held at nothing.
TEST(Evidence, OfTwoAtTheirBoundsPromisesNothing) {
  const Setting s({"rotor_drag", "parasitic_drag"}, {{find_effect("rotor_drag"), {-6e-4}}}, 20);
  const Evidence evidence(*s.problem, *s.noise, s.hypotheses, 0, assumed(*s.problem));
  const double nothing = evidence.fit({}).log_evidence;
  const SetFit both = evidence.fit({evidence.member_at(0, 0, Eigen::VectorXd::Ones(1)),
                                    evidence.member_at(1, 0, Eigen::VectorXd::Ones(1))});
  EXPECT_LT(both.log_evidence, nothing);
}

/// A vehicle that was measured well, of which nothing is told, or totals.
class Tolerances : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Told, Tolerances, testing::Bool());

TEST_P(Tolerances, AreThoseUnderWhichTheFlightIsLikeliest) {
  const Setting s({"rotor_axis_misalignment"}, {}, 8, GetParam() ? totals_told() : Options{});
  const Calibration& c = s.problem->calibration();
  const SetFit nothing = Evidence(*s.problem, *s.noise, s.hypotheses, 0, assumed(*s.problem)).fit({});
  const Eigen::VectorXd found = likeliest_tolerances(c, nothing, assumed(*s.problem));
  const auto evidence_with = [&](const Eigen::VectorXd& tolerances) {
    return Evidence(*s.problem, *s.noise, s.hypotheses, 0, tolerances).fit({}).log_evidence +
           log_prior_of_tolerances(c, tolerances);
  };
  const double best = evidence_with(found);
  EXPECT_GT(best, evidence_with(assumed(*s.problem)) + 5);
  const std::set<std::string> kinds(c.kinds.begin(), c.kinds.end());
  for (const std::string& kind : kinds)
    for (const double factor : {2.0, 1.0, 0.5, 0.25, 0.125, 0.0625}) {
      Eigen::VectorXd other = found;
      for (std::size_t k = 0; k < c.kinds.size(); ++k)
        if (c.kinds[k] == kind && c.settled[static_cast<Eigen::Index>(k)] < 1)
          other[static_cast<Eigen::Index>(k)] = factor;
      EXPECT_LT(evidence_with(other), best + 1e-6) << kind << " times " << factor;
    }
}

TEST(Tolerances, ThatAreToldStay) {
  const vehicle::Vehicle v = test::omnimorph();
  Options o;
  o.tolerance.told = {"torque_trim"};
  const Flight flight = flown(v, o, {}, 8);
  const Flight* one[] = {&flight};
  const RegressionProblem problem(one, v, o, Horizon{0.15});
  const auto noise = estimate_noise(problem, slow_columns(problem), Eigen::VectorXd::Zero(problem.rows()), 1);
  const SetFit nothing = Evidence(problem, *noise, {}, 0, assumed(problem)).fit({});
  const Eigen::VectorXd found = likeliest_tolerances(problem.calibration(), nothing, assumed(problem));
  for (std::size_t k = 0; k < problem.calibration().kinds.size(); ++k) {
    if (problem.calibration().kinds[k] != "torque_trim") continue;
    EXPECT_EQ(found[static_cast<Eigen::Index>(k)], 1) << problem.calibration().names[k];
  }
}

/// One rotor that is mounted askew by 5.2 degrees among seven that are not, of a vehicle that hovers without
/// trim.
TEST(Tolerances, OneRotorAmongManyIsNoTolerance) {
  const vehicle::Vehicle v = test::omnimorph();
  const physics::Effect* askew = find_effect("rotor_axis_misalignment");
  std::vector<double> theta(static_cast<std::size_t>(askew->parameter_count()), 0.0);
  theta[1] = 0.09;
  Options o;
  o.tolerance.torque_trim = 0.002;
  o.tolerance.told = {"torque_trim"};
  const Flight flight = flown(v, o, {{askew, theta}}, 40);
  const Flight* one[] = {&flight};
  const auto log_odds = [&](const Options& options) {
    const Inference in = infer(one, v, {askew}, options);
    double with = -1e300, without = -1e300;
    for (const SetPosterior& set : in.posterior.sets) {
      double& best = set.hypotheses.empty() ? without : with;
      best = std::max(best, set.log_joint);
    }
    return with - without;
  };
  const double adapted = log_odds(o);
  o.tolerance.told = {"rotor_axis", "rotor_scale", "torque_trim", "center_of_mass", "drag_torque", "inertia"};
  const double as_assumed = log_odds(o);
  std::printf("log odds that a rotor is askew: %.1f; with tolerances as assumed %.1f\n", adapted, as_assumed);
  EXPECT_GT(adapted, 3);
  EXPECT_GT(as_assumed, 3);
  EXPECT_GT(adapted, as_assumed - 3);  // what is learned of fifteen axes does not take the other one away
}

TEST(FirstStage, IsTheRegressionOnThePrediction) {
  Eigen::VectorXd predicted(400), other(400);
  for (Eigen::Index k = 0; k < predicted.size(); ++k) {
    predicted[k] = std::sin(0.1 * static_cast<double>(k));
    other[k] = std::sin(0.17 * static_cast<double>(k) + 1);
  }
  other -= predicted * (predicted.dot(other) / predicted.squaredNorm());
  EXPECT_NEAR(first_stage(predicted, 1.4 * predicted + 2 * other), 1.4, 1e-12);
  EXPECT_NEAR(first_stage(predicted, predicted), 1.0, 1e-12);
  EXPECT_EQ(first_stage(predicted, 0.1 * predicted + other), 0.0) << "F of about 4 is a weak instrument";
  EXPECT_EQ(first_stage(Eigen::VectorXd::Zero(400), other), 0.0);
}

/// In the noise that is left when the effect is known: beside a biased estimate noise keeps a part of it.
TEST(Evidence, ACoefficientDoesNotShrinkWithTheHorizonOfPrediction) {
  const vehicle::Vehicle v = test::omnimorph();
  Options o;
  const physics::Effect* drag = find_effect("rotor_drag");
  const double flown_drag = 2e-4;
  const Flight flight = flown(v, o, {{drag, {flown_drag}}}, 60);
  const Flight* one[] = {&flight};
  for (const double horizon_s : {0.15, 0.3}) {
    RegressionProblem problem(one, v, o, Horizon{horizon_s});
    Eigen::VectorXd known;
    problem.wrench_of({drag, {flown_drag}, {}}, known, nullptr, nullptr, States::measured);
    const auto noise = estimate_noise(problem, slow_columns(problem), known, 1);
    problem.scale_calibration(first_stages(noise->apply(problem.calibration().columns),
                                           noise->apply(problem.calibration().measured)));
    const auto hypotheses = make_hypotheses(problem, *noise, {drag}, o);
    const SetFit fit = Evidence(problem, *noise, hypotheses, 0, assumed(problem))
                           .fit({SetMember{0, {flown_drag / 2}, {}, {}}});
    std::printf("horizon %.2f s: rotor drag %.3g +- %.2g (flown %.3g), first stage %.3f\n", horizon_s,
                fit.members[0].theta[0], fit.theta_deviation[0], flown_drag, hypotheses[0].first_stage[0]);
    EXPECT_LT(hypotheses[0].first_stage[0], 0.8) << "predictions that tell everything show nothing";
    EXPECT_NEAR(fit.members[0].theta[0], flown_drag, 3 * fit.theta_deviation[0]) << horizon_s;
  }
}

TEST(NoiseModel, LeavesWhiteUnitVarianceOfItsOwnNoise) {
  const Setting s({"payload_mass"}, {}, 60);
  const Eigen::VectorXd white = s.noise->apply(s.problem->residual());
  EXPECT_NEAR(std::sqrt(white.squaredNorm() / static_cast<double>(white.size())), 1.0, 0.12);
}

std::vector<std::string> named(const std::vector<physics::ActiveEffect>& world, test::Flown f,
                               double* nothing = nullptr) {
  const vehicle::Vehicle v = test::omnimorph();
  Options o;
  const auto flight = prepare_flight(test::fly(v, world, f), v, o);
  EXPECT_TRUE(flight);
  const Flight* one[] = {&*flight};
  std::vector<const physics::Effect*> effects;
  for (const char* id : {"payload_mass", "com_offset", "thrust_scale", "hung_cable", "constant_pull",
                         "rotor_drag", "inertia_error", "drag_torque_scale", "lateral_stiffness"})
    effects.push_back(find_effect(id));
  const Inference in = infer(one, v, effects, o);
  std::vector<std::string> out;
  for (const SetMember& m : in.posterior.best.members) {
    const Hypothesis& h = in.hypotheses[static_cast<std::size_t>(m.hypothesis)];
    out.push_back(h.pattern ? "unknown " + std::to_string(h.pattern->channel) + " " + h.pattern->variable
                            : h.id);
  }
  std::sort(out.begin(), out.end());
  if (nothing) *nothing = in.posterior.probability_of_nothing;
  return out;
}

TEST(Search, NominalFlightsRaiseNoAlarm) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    test::Flown f;
    f.sway = 0.2;
    f.seed = seed;
    double nothing = 0;
    const auto likeliest = named({}, f, &nothing);
    std::printf("seed %d: probability of nothing %.3f, likeliest set has %zu members\n",
                static_cast<int>(seed), nothing, likeliest.size());
    EXPECT_GE(nothing, kAlarm) << seed;
  }
}

// An offset of the centre of mass is within what the torque trim may hide; drag of the rotors is not.
TEST(Search, TwoEffectsAreNamedTogether) {
  test::Flown f;
  f.duration_s = 60;
  f.sway = 0.3;
  const auto names =
      named({{find_effect("hung_cable"), {0.25, 0.9, 2.0}}, {find_effect("rotor_drag"), {1.6e-4}}}, f);
  EXPECT_EQ(names, (std::vector<std::string>{"hung_cable", "rotor_drag"}));
}

TEST(Tolerances, WhatALaboratoryTellsOfSomeSaysHowWellItKnowsTheOthers) {
  Calibration c;
  c.kinds = {"thrust_scale", "inertia", "inertia", "inertia"};
  c.settled = Eigen::Vector4d(1, 0, 0, 0);
  const auto prior = [&](double factor) {
    return log_prior_of_tolerances(c, Eigen::Vector4d(1, factor, factor, factor));
  };
  EXPECT_EQ(prior(2), 0) << "flat where nothing is told";
  c.told = {std::log(0.05)};  // thrust twenty times as well as is assumed
  // normal with mean ln 0.05 ln(4)^2/(ln(4)^2 + ln(3)^2), and a variance of ln(3)^2 more than the
  // laboratory's
  const double within = std::pow(std::log(3.0), 2), between = std::pow(std::log(4.0), 2);
  const double mean = std::log(0.05) * between / (between + within);
  const double variance = within + within * between / (within + between);
  const auto loss = [&](double factor) { return std::pow(std::log(factor) - mean, 2) / (2 * variance); };
  EXPECT_NEAR(prior(2) - prior(1), loss(1) - loss(2), 1e-12) << "once a kind, not once a column";
  EXPECT_LT(prior(2), prior(1));
  EXPECT_LT(prior(1), prior(0.25));
  c.told = {std::log(0.05), std::log(0.05), std::log(0.05)};
  EXPECT_LT(prior(2), -loss(2)) << "three numbers say it surer";
}

}  // namespace
}  // namespace omniflight::diagnosis
