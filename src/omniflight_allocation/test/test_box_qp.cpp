#include "omniflight_allocation/box_qp.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "omniflight_core/random.hpp"

namespace omniflight::allocation {
namespace {

struct Qp {
  QpMatrix H;
  QpVector g, lower, upper;
  double cost(const QpVector& u) const { return 0.5 * u.dot(H * u) + g.dot(u); }
};

Qp random_qp(Random& rng, int n, int rank, double regularisation, double g_scale) {
  Eigen::MatrixXd A(rank, n);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < rank; ++i) A(i, j) = rng.normal();
  Qp qp{A.transpose() * A + regularisation * Eigen::MatrixXd::Identity(n, n), QpVector(n), QpVector(n),
        QpVector(n)};
  for (int i = 0; i < n; ++i) {
    qp.g[i] = g_scale * rng.normal();
    qp.lower[i] = -rng.uniform(0.0, 2.0);
    qp.upper[i] = qp.lower[i] + rng.uniform(0.0, 3.0);
  }
  return qp;
}

// The best over all 3^n sets of active bounds whose free part stays inside.
double enumerated_cost(const Qp& qp) {
  const int n = static_cast<int>(qp.g.size());
  int sets = 1;
  for (int i = 0; i < n; ++i) sets *= 3;
  double best = std::numeric_limits<double>::infinity();
  for (int set = 0; set < sets; ++set) {
    QpVector u = QpVector::Zero(n);
    std::vector<int> free;
    for (int i = 0, rest = set; i < n; ++i, rest /= 3) {
      if (rest % 3 == 0)
        free.push_back(i);
      else
        u[i] = rest % 3 == 1 ? qp.lower[i] : qp.upper[i];
    }
    if (!free.empty()) {
      const Eigen::MatrixXd H = qp.H(free, free);
      const Eigen::VectorXd rhs = -(qp.g + qp.H * u)(free);
      const Eigen::VectorXd x = H.ldlt().solve(rhs);
      u(free) = x;
    }
    const bool inside = (u - qp.lower).minCoeff() >= -1e-9 && (qp.upper - u).minCoeff() >= -1e-9;
    if (inside) best = std::min(best, qp.cost(u));
  }
  return best;
}

TEST(BoxQp, FindsTheBestOfAllActiveSets) {
  Random rng(11);
  int saturated = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const int n = 1 + trial % 6;
    const Qp qp = random_qp(rng, n, std::max(1, n - 1), 1e-3, 1.5);
    const BoxQpSolution s = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper);
    ASSERT_EQ(s.status, QpStatus::solved);
    ASSERT_LT(s.kkt_residual, 1e-12);
    const double expected = enumerated_cost(qp);
    ASSERT_NEAR(qp.cost(s.u), expected, 1e-9 * (1 + std::abs(expected)));
    saturated += s.active_bounds > 0;
  }
  EXPECT_GT(saturated, 200);
}

TEST(BoxQp, EverySizeMeetsItsConditionsAndItsBounds) {
  Random rng(12);
  for (int trial = 0; trial < 4000; ++trial) {
    const int n = 1 + trial % kMaxInputs;
    const Qp qp =
        random_qp(rng, n, std::max(1, n - 2), std::pow(10.0, rng.uniform(-11, 0)), rng.uniform(0.1, 20));
    const BoxQpSolution s = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper);
    ASSERT_EQ(s.status, QpStatus::solved);
    for (int i = 0; i < n; ++i) ASSERT_TRUE(s.u[i] >= qp.lower[i] && s.u[i] <= qp.upper[i]);
    // the conditions again, written independently of the solver
    const QpVector gradient = qp.H * s.u + qp.g;
    const double scale = 1 + gradient.cwiseAbs().maxCoeff() + qp.H.cwiseAbs().maxCoeff();
    for (int i = 0; i < n; ++i) {
      if (qp.lower[i] == qp.upper[i]) continue;
      if (s.u[i] > qp.lower[i]) {
        ASSERT_LE(gradient[i], 1e-11 * scale);
      }
      if (s.u[i] < qp.upper[i]) {
        ASSERT_GE(gradient[i], -1e-11 * scale);
      }
    }
  }
}

TEST(BoxQp, AWarmStartChangesTheWorkAndNotTheAnswer) {
  Random rng(13);
  long cold = 0, warm = 0;
  for (int trial = 0; trial < 300; ++trial) {
    Qp qp = random_qp(rng, 8, 6, 1e-4, 5.0);
    const BoxQpSolution first = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper);
    qp.g *= 1.001;
    const BoxQpSolution a = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper);
    const BoxQpSolution b = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper, first.active_set);
    ASSERT_LT((a.u - b.u).norm(), 1e-9);
    cold += a.iterations;
    warm += b.iterations;
  }
  EXPECT_LT(warm, cold / 2);
}

TEST(BoxQp, AStaleStartDoesNotHoldAVariableThatAWeakTermWantsFree) {
  // Tracking twelve orders stiffer than economy: two opposed rotors that a stale start holds at their limits
  // cost nothing there but the economy, which must still bring them back to zero.
  QpMatrix H(2, 2);
  H << 1, 1, 1, 1;
  H *= 3e6;
  H.diagonal().array() += 1e-6;
  const QpVector g = QpVector::Zero(2), bound = QpVector::Constant(2, 6.25);
  ActiveSet stale{};
  stale[0] = 1;
  stale[1] = -1;
  const BoxQpSolution s = solve_box_qp(H, g, -bound, bound, stale);
  ASSERT_EQ(s.status, QpStatus::solved);
  EXPECT_EQ(s.active_bounds, 0);
  EXPECT_LT(s.u.norm(), 1e-3);
}

TEST(BoxQp, InfiniteAndEqualBounds) {
  QpMatrix H = QpMatrix::Identity(2, 2);
  QpVector g(2), lower(2), upper(2);
  g << -3, 5;
  lower << -HUGE_VAL, 0.25;
  upper << HUGE_VAL, 0.25;
  const BoxQpSolution s = solve_box_qp(H, g, lower, upper);
  ASSERT_EQ(s.status, QpStatus::solved);
  EXPECT_EQ(s.u[0], 3.0);
  EXPECT_EQ(s.u[1], 0.25);
}

TEST(BoxQp, RefusesWhatHasNoAnswer) {
  const QpMatrix H = QpMatrix::Identity(3, 3);
  const QpVector zero = QpVector::Zero(3), one = QpVector::Ones(3);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 3; ++i) {
    QpVector bad = one;
    bad[i] = nan;
    QpMatrix bad_H = H;
    bad_H(2, i) = nan;
    EXPECT_EQ(solve_box_qp(bad_H, zero, -one, one).status, QpStatus::not_finite);
    EXPECT_EQ(solve_box_qp(H, bad, -one, one).status, QpStatus::not_finite);
    EXPECT_EQ(solve_box_qp(H, zero, -bad, one).status, QpStatus::not_finite);
    EXPECT_EQ(solve_box_qp(H, zero, -one, bad).status, QpStatus::not_finite);
  }
  EXPECT_EQ(solve_box_qp(H, one * HUGE_VAL, -one, one).status, QpStatus::not_finite);
  EXPECT_EQ(solve_box_qp(H, zero, one, -one).status, QpStatus::bad_bounds);
  EXPECT_EQ(solve_box_qp(-H, zero, -one, one).status, QpStatus::not_convex);
  EXPECT_EQ(solve_box_qp(QpMatrix::Ones(3, 3), one, -one, one).status, QpStatus::not_convex);
  EXPECT_EQ(solve_box_qp(H, QpVector::Zero(2), -one, one).status, QpStatus::bad_size);
  EXPECT_EQ(solve_box_qp(QpMatrix(0, 0), QpVector(0), QpVector(0), QpVector(0)).status, QpStatus::bad_size);
}

}  // namespace
}  // namespace omniflight::allocation
