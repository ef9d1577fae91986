// A regression takes slow noise away with what it explains; the noise model must give it back.
#include <gtest/gtest.h>

#include "../src/problem.hpp"
#include "../src/whitening.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

TEST(Whitening, GivesBackWhatARegressionTakes) {
  const vehicle::Vehicle v = test::omnimorph();
  test::Flown f;
  f.duration_s = 60;
  const auto r = test::fly(v, {}, f);
  Options o;
  const auto flight = prepare_flight(r, v, o);
  ASSERT_TRUE(flight) << flight.error().text();
  const Flight* one[] = {&*flight};
  const Problem problem(one, v, o);
  const int n = problem.samples();
  ASSERT_GT(n, 2000);
  // noise of 0.3 s on a regression with twenty slow columns
  Eigen::MatrixXd X(n, 20);
  for (int k = 0; k < 20; ++k)
    for (int i = 0; i < n; ++i) X(i, k) = std::cos(kPi * k * (i + 0.5) / n);
  const Eigen::MatrixXd Q =
      Eigen::HouseholderQR<Eigen::MatrixXd>(X).householderQ() * Eigen::MatrixXd::Identity(n, 20);
  std::array<Eigen::MatrixXd, 6> columns;
  columns.fill(X);
  const double keep = std::exp(-1 / (o.grid_hz * 0.3)), kick = std::sqrt(1 - keep * keep);
  const double truth = kick / (1 - keep);  // level of the spectrum at zero frequency, per sample
  double plain = 0, given_back = 0;
  int count = 0;
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(6 * n);
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    Eigen::VectorXd left(6 * n);
    for (int c = 0; c < 6; ++c) {
      Eigen::VectorXd x(n);
      x[0] = random.normal();
      for (int i = 1; i < n; ++i) x[i] = keep * x[i - 1] + kick * random.normal();
      left.segment(c * n, n) = x - Q * (Q.transpose() * x);
    }
    const Whitening before = Whitening::autoregressive(problem, left, o.ar_order);
    const Whitening after = Whitening::autoregressive(problem, left, o.ar_order, columns);
    const Eigen::VectorXd a = before.apply_vector(problem, ones), b = after.apply_vector(problem, ones);
    for (int c = 0; c < 6; ++c, ++count) {
      plain += 1 / a[c * n + n / 2] / truth;
      given_back += 1 / b[c * n + n / 2] / truth;
    }
  }
  RecordProperty("plain", std::to_string(plain / count));
  RecordProperty("given_back", std::to_string(given_back / count));
  EXPECT_LT(plain / count, 0.9);
  EXPECT_NEAR(given_back / count, 1.0, 0.05);
}

}  // namespace
}  // namespace omniflight::diagnosis
