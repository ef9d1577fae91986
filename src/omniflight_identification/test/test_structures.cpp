// Parameters of known systems are found within their own uncertainty, in every structure.
#include <gtest/gtest.h>

#include "known_systems.hpp"
#include "omniflight_identification/residual_tests.hpp"
#include "omniflight_identification/selection.hpp"

namespace omniflight::identification {
namespace {

using testing::data_of;
using testing::known_system;

constexpr int kDraws = 100;

class EveryStructure : public ::testing::TestWithParam<Structure> {};

TEST_P(EveryStructure, FindsItsParametersWithinThreeSigmaIn95Of100Draws) {
  const PolynomialModel truth = known_system(GetParam());
  const Eigen::VectorXd expected = truth.parameters();
  int within = 0, white = 0, independent = 0;
  double squares = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Random random(static_cast<std::uint64_t>(draw) + 1, name_of(GetParam()));
    const Dataset data = data_of(truth, 0.5, 2000, random);
    const auto fitted = fit(GetParam(), truth.orders(), data);
    ASSERT_TRUE(fitted) << fitted.error().text();
    const Eigen::VectorXd z =
        (fitted->model.parameters() - expected).array() / fitted->covariance.diagonal().array().sqrt();
    within += z.cwiseAbs().maxCoeff() <= 3.0;
    squares += z.squaredNorm() / static_cast<double>(z.size());
    white += whiteness(fitted->model, data, {}).passed;
    independent += independence(fitted->model, data, 0, {}).passed;
  }
  EXPECT_GE(within, 95) << name_of(GetParam());
  EXPECT_GT(squares / kDraws, 0.7);  // the covariance is not too large either
  EXPECT_LT(squares / kDraws, 1.4);
  EXPECT_GE(white, 93);
  EXPECT_GE(independent, 93);
  RecordProperty("within", within);
}

INSTANTIATE_TEST_SUITE_P(All, EveryStructure, ::testing::ValuesIn(all_structures()), [](const auto& chosen) {
  std::string name = name_of(chosen.param);
  std::erase_if(name, [](char c) { return c == '-' || c == ' '; });
  return name;
});

TEST(Structures, OutputErrorAndBoxJenkinsAreBestWhereTheNoiseIsOutputNoise) {
  PolynomialModel truth = known_system(Structure::output_error);
  truth.d = Eigen::VectorXd::Constant(1, -0.7);  // output noise, coloured
  double error[5] = {};
  for (int draw = 0; draw < 30; ++draw) {
    Random random(static_cast<std::uint64_t>(draw) + 1, "output noise");
    const Dataset data = data_of(truth, 0.8, 1500, random);
    const Dataset quiet = data_of(truth, 0.0, 1500, random);
    for (std::size_t k = 0; k < all_structures().size(); ++k) {
      Orders orders = orders_of(all_structures()[k], 2, 1, {2});
      const auto fitted = fit(all_structures()[k], orders, data);
      ASSERT_TRUE(fitted) << fitted.error().text();
      error[k] += (100.0 - fit_percent(fitted->model, quiet)) / 30;
    }
  }
  const double arx = error[0], armax = error[1], oe = error[2], bj = error[3], ss = error[4];
  for (const double other : {arx, armax, ss}) {
    EXPECT_LT(oe, other);
    EXPECT_LT(bj, other);
  }
  EXPECT_GT(arx, 3 * oe);  // the bias of ARX by output noise
}

TEST(Structures, TestsOfResidualsFindAModelThatIsTooSmall) {
  const PolynomialModel truth = known_system(Structure::output_error);
  Random random(5);
  const Dataset data = data_of(truth, 0.2, 2000, random);
  const auto small = fit(Structure::output_error, orders_of(Structure::output_error, 1, 0, {2}), data);
  ASSERT_TRUE(small);
  EXPECT_FALSE(whiteness(small->model, data, {}).passed);
  EXPECT_FALSE(independence(small->model, data, 0, {}).passed);
  EXPECT_TRUE(small->correlated_residuals);
}

TEST(Structures, CoverageHoldsWhereTheNoiseIsNotOfTheStructure) {
  PolynomialModel truth = known_system(Structure::output_error);
  PolynomialModel noisy = truth;
  noisy.d = Eigen::VectorXd::Constant(1, -0.9);
  int within = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Random random(static_cast<std::uint64_t>(draw) + 1, "coloured");
    const Dataset data = data_of(noisy, 0.5, 2000, random);
    const auto fitted = fit(Structure::output_error, truth.orders(), data);
    ASSERT_TRUE(fitted) << fitted.error().text();
    const Eigen::VectorXd z = (fitted->model.parameters() - truth.parameters()).array() /
                              fitted->covariance.diagonal().array().sqrt();
    within += z.cwiseAbs().maxCoeff() <= 3.0;
  }
  EXPECT_GE(within, 95);
}

TEST(Structures, SelectionFindsTheOrderAndTheDelay) {
  const PolynomialModel truth = known_system(Structure::output_error);
  Random random(9);
  const Dataset all = detrended(data_of(truth, 0.3, 4000, random), Trend::mean);
  const auto [first, second] = split(all, 0.5);
  for (const Structure structure : {Structure::output_error, Structure::box_jenkins}) {
    const auto chosen = select(structure, first, second, 2);
    ASSERT_TRUE(chosen) << chosen.error().text();
    EXPECT_EQ(chosen->fitted.model.poles().size(), 2u);
    EXPECT_GT(chosen->validation_percent, 80);
    EXPECT_LT(std::abs(chosen->fitted.model.static_gain(0) - 9.0), 0.3);
  }
}

TEST(Structures, ASearchEndsWhenItIsToldTo) {
  Random random(1);
  const Dataset data = data_of(known_system(Structure::box_jenkins), 0.5, 2000, random);
  FitOptions options;
  options.stop = [] { return true; };
  const auto fitted =
      fit(Structure::box_jenkins, known_system(Structure::box_jenkins).orders(), data, options);
  ASSERT_FALSE(fitted);
  EXPECT_EQ(fitted.error().code, ErrorCode::incomplete);
}

TEST(Structures, BadDataAndUnstableModelsAreToldWithFieldAndNextStep) {
  Random random(1);
  Dataset data = data_of(known_system(Structure::arx), 0.5, 500, random);
  const Orders orders = known_system(Structure::arx).orders();
  Dataset constant = data;
  constant.experiments[0].u.setConstant(0.4);
  const auto none = fit(Structure::arx, orders, constant);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().text().find("input 1: is constant"), std::string::npos) << none.error().text();
  data.experiments[0].y[3] = std::nan("");
  EXPECT_FALSE(fit(Structure::arx, orders, data));
  // y grows without bound: an integrator that is driven away
  Dataset growing = data_of(known_system(Structure::arx), 0.5, 500, random);
  for (Eigen::Index t = 1; t < 500; ++t)
    growing.experiments[0].y[t] = 1.02 * growing.experiments[0].y[t - 1] + growing.experiments[0].u(t - 1, 0);
  Orders first = orders_of(Structure::arx, 1, 0, {1});
  const auto unstable = fit(Structure::arx, first, growing);
  ASSERT_FALSE(unstable);
  EXPECT_NE(unstable.error().text().find("unstable"), std::string::npos) << unstable.error().text();
  EXPECT_FALSE(unstable.error().next_step.empty());
}

TEST(Structures, FitPercentIsThatOfMatlab) {
  Eigen::Vector4d y(1, 2, 3, 4);
  EXPECT_DOUBLE_EQ(fit_percent(y, y), 100.0);
  EXPECT_NEAR(fit_percent(y, Eigen::Vector4d::Constant(2.5)), 0.0, 1e-12);
  EXPECT_NEAR(fit_percent(y, Eigen::Vector4d(1, 2, 3, 5)), 100 * (1 - 1 / std::sqrt(5.0)), 1e-12);
}

TEST(Structures, StateSpaceHasTheSameResponse) {
  const PolynomialModel m = known_system(Structure::armax);
  const StateSpace s = state_space(m);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(s.A.rows());
  const Eigen::VectorXd expected = m.step(0, 40);
  for (Eigen::Index t = 0; t < 39; ++t) {
    // the delay of two samples is one of the model and one before it
    EXPECT_NEAR((s.C * x)(0), t == 0 ? 0.0 : expected[t], 1e-9);
    x = s.A * x + s.B * (t >= 1 ? 1.0 : 0.0);
  }
  const auto p = m.poles();
  Eigen::VectorXcd of_a = s.A.eigenvalues();
  for (const auto& pole : p) EXPECT_LT((of_a.array() - pole).abs().minCoeff(), 1e-9);
}

}  // namespace
}  // namespace omniflight::identification
