// The box program against every set of active bounds, on every instruction set, and with a matrix that stays.
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "counted_malloc.hpp"
#include "instruction_sets.hpp"
#include "omniflight_allocation/box_qp.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::allocation {
namespace {

struct Qp {
  QpMatrix H;
  QpVector g, lower, upper;
};

/// n variables, n - 2 stiff directions, the others 1e-4 to 1 of them: as allocation has it.
Qp random_qp(Random& rng, int n) {
  const int rank = std::max(1, n - 2);
  Eigen::MatrixXd A(rank, n);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < rank; ++i) A(i, j) = rng.normal();
  Qp qp{A.transpose() * A + std::pow(10.0, rng.uniform(-4, 0)) * Eigen::MatrixXd::Identity(n, n), QpVector(n),
        QpVector(n), QpVector(n)};
  const double pull = std::pow(10.0, rng.uniform(-1, 1.5));
  for (int i = 0; i < n; ++i) {
    qp.g[i] = pull * rng.normal();
    qp.lower[i] = -rng.uniform(0.1, 2.0);
    qp.upper[i] = rng.uniform(0.1, 2.0);
  }
  return qp;
}

/// The best over all 3^n sets of active bounds whose free part stays inside. A Cholesky factor of the free
/// part grows with the depth of the search, so that a set takes one solution.
class Enumeration {
 public:
  explicit Enumeration(const Qp& qp) : qp_(qp), n_(static_cast<int>(qp.g.size())) {}
  double best_cost() {
    descend(0, 0);
    return best_;
  }

 private:
  void descend(int i, int free) {
    if (i == n_) return judge(free);
    for (const double bound : {qp_.lower[i], qp_.upper[i]}) {
      held_[i] = true, u_[i] = bound;
      descend(i + 1, free);
    }
    held_[i] = false, u_[i] = 0, which_[free] = i;
    for (int k = 0; k <= free; ++k) {
      double sum = qp_.H(i, which_[k]);
      for (int m = 0; m < k; ++m) sum -= L_[free][m] * L_[k][m];
      L_[free][k] = k < free ? sum / L_[k][k] : std::sqrt(sum);
    }
    descend(i + 1, free + 1);
  }
  void judge(int free) {
    double x[8], u[8];
    for (int k = 0; k < n_; ++k) u[k] = u_[k];
    for (int k = 0; k < free; ++k) {
      const int i = which_[k];
      double sum = -qp_.g[i];
      for (int j = 0; j < n_; ++j)
        if (held_[j]) sum -= qp_.H(i, j) * u_[j];
      for (int m = 0; m < k; ++m) sum -= L_[k][m] * x[m];
      x[k] = sum / L_[k][k];
    }
    for (int k = free - 1; k >= 0; --k) {
      for (int m = k + 1; m < free; ++m) x[k] -= L_[m][k] * x[m];
      x[k] /= L_[k][k];
      const int i = which_[k];
      if (!(x[k] >= qp_.lower[i] - 1e-10 && x[k] <= qp_.upper[i] + 1e-10)) return;
      u[i] = x[k];
    }
    double cost = 0;
    for (int i = 0; i < n_; ++i) {
      double row = qp_.g[i];
      for (int j = 0; j < n_; ++j) row += 0.5 * qp_.H(i, j) * u[j];
      cost += u[i] * row;
    }
    best_ = std::min(best_, cost);
  }

  const Qp& qp_;
  int n_, which_[8] = {};
  bool held_[8] = {};
  double u_[8] = {}, L_[8][8] = {}, best_ = std::numeric_limits<double>::infinity();
};

double cost(const Qp& qp, const QpVector& u) { return 0.5 * u.dot(qp.H * u) + qp.g.dot(u); }

TEST(BoxQpEnumeration, FindsTheBestOfAllActiveSets) {
  const char* count = std::getenv("OMNIFLIGHT_REPETITIONS");
  const int trials = count != nullptr ? std::atoi(count) : 400;
  ASSERT_GT(trials, 0);
  Random rng(101);
  ActiveSet start{};
  int bounds[9] = {};
  double worst = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const int n = trial % 4 == 0 ? 1 + trial / 4 % 7 : 8;
    const Qp qp = random_qp(rng, n);
    // every other one starts at the active set of another program
    const BoxQpSolution s =
        solve_box_qp(qp.H, qp.g, qp.lower, qp.upper, trial % 2 == 0 ? ActiveSet{} : start);
    ASSERT_EQ(s.status, QpStatus::solved);
    ASSERT_LT(s.kkt_residual, 1e-12);
    const double expected = Enumeration(qp).best_cost();
    ASSERT_NEAR(cost(qp, s.u), expected, 1e-9 * (1 + std::abs(expected))) << trial;
    start = s.active_set;
    ++bounds[s.active_bounds];
    worst = std::max(worst, s.kkt_residual);
  }
  for (const int seen : bounds) EXPECT_GT(seen, 0);  // from none to all held
  std::printf("%d programs, worst KKT residual %.1e\n", trials, worst);
}

TEST(BoxQpEnumeration, EveryInstructionSetGivesTheSameBits) {
  const auto answers = [] {
    Random rng(102);
    std::vector<double> out;
    for (int trial = 0; trial < 600; ++trial) {
      const Qp qp = random_qp(rng, 1 + trial % kMaxInputs);
      const BoxQpSolution s = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper);
      out.insert(out.end(), s.u.begin(), s.u.end());
      out.push_back(s.kkt_residual);
      out.push_back(s.iterations);
    }
    return out;
  };
  const std::vector<double> best = answers();
  const int sets =
      test::for_each_instruction_set([&](const char* name) { EXPECT_EQ(answers(), best) << name; });
  EXPECT_GE(sets, 1);
}

TEST(BoxQpEnumeration, OnlyTheLowerTriangleIsRead) {
  Random rng(103);
  for (int n = 1; n <= kMaxInputs; ++n) {
    const Qp qp = random_qp(rng, n);
    QpMatrix half = qp.H;
    half.triangularView<Eigen::StrictlyUpper>().setConstant(std::numeric_limits<double>::quiet_NaN());
    EXPECT_EQ(solve_box_qp(half, qp.g, qp.lower, qp.upper).u, solve_box_qp(qp.H, qp.g, qp.lower, qp.upper).u);
  }
}

TEST(BoxQpSolver, KeepsItsPivotsAndAnswersAsIfAnew) {
  Random rng(104);
  for (const int n : {4, 6, 8, 12}) {
    const Qp qp = random_qp(rng, n);
    BoxQpSolver solver;
    EXPECT_EQ(solver.solve(qp.g, qp.lower, qp.upper).status, QpStatus::bad_size);  // no matrix yet
    ASSERT_EQ(solver.set_matrix(qp.H), QpStatus::solved);
    QpVector g = qp.g, lower = qp.lower, upper = qp.upper;
    ActiveSet start{};
    const long before = counted::allocations;
    for (int step = 0; step < 2000; ++step) {
      for (int i = 0; i < n; ++i) g[i] = 0.95 * g[i] + 0.6 * rng.normal();
      if (step % 50 == 0) lower = -rng.uniform(0.1, 1.0) * QpVector::Ones(n);
      const BoxQpSolution kept = solver.solve(g, lower, upper, start);
      const BoxQpSolution anew = solve_box_qp(qp.H, g, lower, upper);
      ASSERT_EQ(kept.status, QpStatus::solved);
      ASSERT_LT(kept.kkt_residual, 1e-12);
      ASSERT_LT((kept.u - anew.u).cwiseAbs().maxCoeff(), 1e-9);
      start = kept.active_set;
    }
    if (counted::works) {
      EXPECT_EQ(counted::allocations, before);
    }
  }
}

TEST(BoxQpSolver, RefusesAMatrixThatCannotBe) {
  BoxQpSolver solver;
  EXPECT_EQ(solver.set_matrix(QpMatrix(2, 3)), QpStatus::bad_size);
  EXPECT_EQ(solver.set_matrix(-QpMatrix::Identity(3, 3)), QpStatus::not_convex);
  const QpVector one = QpVector::Ones(3);
  EXPECT_EQ(solver.solve(one, -one, one).status, QpStatus::bad_size);
  ASSERT_EQ(solver.set_matrix(QpMatrix::Ones(3, 3)), QpStatus::solved);  // shows while solving
  EXPECT_EQ(solver.solve(one, -one, one).status, QpStatus::not_convex);
  EXPECT_EQ(solver.solve(one, -one, one).status, QpStatus::not_convex);
}

}  // namespace
}  // namespace omniflight::allocation
