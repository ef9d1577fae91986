#include "omniflight_allocation/gap_qp.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "omniflight_core/random.hpp"

namespace omniflight::allocation {
namespace {

struct Qp {
  QpMatrix H;
  QpVector g, lower, upper, gap;
  double cost(const QpVector& u) const { return 0.5 * u.dot(H * u) + g.dot(u); }
};

Qp random_qp(Random& rng, int n) {
  Eigen::MatrixXd A(std::max(1, n - 2), n);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < A.rows(); ++i) A(i, j) = rng.normal();
  Qp qp{A.transpose() * A + 1e-2 * Eigen::MatrixXd::Identity(n, n), QpVector(n), QpVector(n), QpVector(n),
        QpVector(n)};
  for (int i = 0; i < n; ++i) {
    qp.g[i] = rng.normal();
    qp.gap[i] = i % 5 == 4 ? 0.0 : rng.uniform(0.2, 0.69);
    qp.lower[i] = -rng.uniform(0.7, 1.5);
    qp.upper[i] = rng.uniform(0.7, 1.5);
    if (i % 7 == 5) qp.lower[i] = 0.3;  // one side only
  }
  return qp;
}

// The best of all sign patterns, each a box of its own: 2^n quadratic programs.
double enumerated_cost(const Qp& qp) {
  const int n = static_cast<int>(qp.g.size());
  double best = std::numeric_limits<double>::infinity();
  for (int pattern = 0; pattern < (1 << n); ++pattern) {
    QpVector lower = qp.lower, upper = qp.upper;
    for (int i = 0; i < n; ++i) {
      if ((pattern >> i & 1) != 0)
        lower[i] = std::max(lower[i], qp.gap[i]);
      else
        upper[i] = std::min(upper[i], -qp.gap[i]);
    }
    if ((upper - lower).minCoeff() < 0) continue;
    const BoxQpSolution s = solve_box_qp(qp.H, qp.g, lower, upper);
    if (s.status == QpStatus::solved) best = std::min(best, qp.cost(s.u));
  }
  return best;
}

TEST(GapQp, FindsTheBestOfAllSignPatterns) {
  Random rng(31);
  int branched = 0, most = 0;
  for (int trial = 0; trial < 600; ++trial) {
    const int n = 1 + trial % 8;
    const Qp qp = random_qp(rng, n);
    const GapQpSolution s = solve_gap_qp(qp.H, qp.g, qp.lower, qp.upper, qp.gap);
    ASSERT_EQ(s.best.status, QpStatus::solved);
    ASSERT_TRUE(s.proven);
    ASSERT_LT(s.best.kkt_residual, 1e-12);
    for (int i = 0; i < n; ++i) {
      ASSERT_GE(std::abs(s.best.u[i]), qp.gap[i]);
      ASSERT_TRUE(s.best.u[i] >= qp.lower[i] && s.best.u[i] <= qp.upper[i]);
    }
    const double expected = enumerated_cost(qp);
    ASSERT_NEAR(qp.cost(s.best.u), expected, 1e-11 * (1 + std::abs(expected))) << n;
    branched += s.nodes > 1;
    most = std::max(most, s.nodes);
    ASSERT_LT(s.nodes, 2 << n);
  }
  EXPECT_GT(branched, 300);
  EXPECT_GT(most, 15);  // some of these are hard
}

TEST(GapQp, WithoutGapsItIsTheBoxProgram) {
  Random rng(32);
  for (int trial = 0; trial < 200; ++trial) {
    const Qp qp = random_qp(rng, 8);
    const BoxQpSolution box = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper);
    const GapQpSolution s = solve_gap_qp(qp.H, qp.g, qp.lower, qp.upper, QpVector::Zero(8));
    EXPECT_EQ(s.nodes, 1);
    EXPECT_TRUE(s.proven);
    EXPECT_EQ(s.best.u, box.u);
  }
}

TEST(GapQp, TellsTheSidesApartWhereTheCostsAlmostCancel) {
  // a stiff part that both sides satisfy equally, and an economy eleven orders smaller that decides
  QpMatrix H(2, 2);
  H << 1, 1, 1, 1;
  H *= 1e6;
  H.diagonal().array() += 1e-5;
  QpVector g(2);
  g << -2e-6, 0;  // pulls u_0 a little to the right; u_0 + u_1 = 0 costs nothing
  const QpVector bound = QpVector::Constant(2, 5), gap = QpVector::Constant(2, 0.15);
  const GapQpSolution right = solve_gap_qp(H, g, -bound, bound, gap);
  EXPECT_NEAR(right.best.u[0], 0.15, 1e-9);
  EXPECT_NEAR(right.best.u[1], -0.15, 1e-9);
  const GapQpSolution left = solve_gap_qp(H, -g, -bound, bound, gap);
  EXPECT_NEAR(left.best.u[0], -0.15, 1e-9);
  EXPECT_NEAR(left.best.u[1], 0.15, 1e-9);
}

TEST(GapQp, SaysWhenTheSearchWasCutOff) {
  Random rng(33);
  bool cut = false, empty = false;
  for (int trial = 0; trial < 200; ++trial) {
    const Qp qp = random_qp(rng, 8);
    const GapQpSolution whole = solve_gap_qp(qp.H, qp.g, qp.lower, qp.upper, qp.gap);
    const GapQpSolution s = solve_gap_qp(qp.H, qp.g, qp.lower, qp.upper, qp.gap, {}, 3);
    ASSERT_LE(s.nodes, 3);
    if (s.proven) {
      ASSERT_EQ(s.best.u, whole.best.u);
    }
    if (s.best.status == QpStatus::solved) {
      cut = cut || !s.proven;
      for (int i = 0; i < 8; ++i) ASSERT_GE(std::abs(s.best.u[i]), qp.gap[i]);
      ASSERT_GE(qp.cost(s.best.u), qp.cost(whole.best.u) - 1e-12);
    } else {
      ASSERT_EQ(s.best.status, QpStatus::iteration_limit);
      ASSERT_FALSE(s.proven);
      empty = true;
    }
  }
  EXPECT_TRUE(cut && empty);
}

TEST(GapQp, RefusesWhatHasNoAnswer) {
  const QpMatrix H = QpMatrix::Identity(2, 2);
  const QpVector zero = QpVector::Zero(2), one = QpVector::Ones(2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(solve_gap_qp(H, zero, -one, one, -one).best.status, QpStatus::bad_bounds);
  EXPECT_EQ(solve_gap_qp(H, zero, -one, one, 2 * one).best.status, QpStatus::bad_bounds);
  EXPECT_EQ(solve_gap_qp(H, zero, -one, one, one * HUGE_VAL).best.status, QpStatus::bad_bounds);
  EXPECT_EQ(solve_gap_qp(H, zero, -one, one, one * nan).best.status, QpStatus::not_finite);
  EXPECT_EQ(solve_gap_qp(H, zero, -one, one, QpVector::Ones(3)).best.status, QpStatus::bad_size);
  EXPECT_EQ(solve_gap_qp(QpMatrix::Ones(2, 2), one, -one, one, 0.1 * one).best.status, QpStatus::not_convex);
  EXPECT_EQ(solve_gap_qp(H, zero, one, -one, 0.1 * one).best.status, QpStatus::bad_bounds);
}

}  // namespace
}  // namespace omniflight::allocation
