#include "nested.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kExactly = 1e-6;  // share of a contribution that may be left
constexpr double kWouldShow = 3;   // sigma: 4.5 nats, and a rival is within 3

}  // namespace

bool contains_law(const physics::Effect& rich, const physics::Effect& named, const Eigen::MatrixXd& columns,
                  const Eigen::VectorXd& contribution) {
  if (rich.parameter_count() <= named.parameter_count() || !is_linear(rich) || !is_linear(named))
    return false;
  const Eigen::VectorXd left = contribution - columns * columns.colPivHouseholderQr().solve(contribution);
  return left.squaredNorm() <= kExactly * contribution.squaredNorm();
}

bool only_adds_freedom(const Problem& problem, const Fit& fit, std::size_t index, const Fit& swapped) {
  const physics::Effect &named = *fit.effects[index].effect, &rich = *swapped.effects.back().effect;
  const Eigen::Index width = rich.parameter_count();
  if (width <= named.parameter_count()) return false;
  const Eigen::VectorXd own = problem.noise().apply_vector(problem, contribution_of(problem, fit, index));
  const Eigen::MatrixXd all = problem.whitened(swapped.effects, jacobian_of(problem, swapped));
  const Eigen::Index behind = problem.offset_sigma().size(), before = all.cols() - behind - width;
  const Eigen::MatrixXd columns = all.middleCols(before, width);
  if (!contains_law(rich, named, columns, own)) return false;
  Eigen::MatrixXd rest(all.rows(), before + behind + 1);
  rest << all.leftCols(before), all.rightCols(behind), own;
  const auto solver = rest.colPivHouseholderQr();
  for (Eigen::Index k = 0; k < width; ++k) {
    const double size = columns.col(k).norm();
    if (!(size > 0)) continue;
    const Eigen::VectorXd as_much = columns.col(k) * (own.norm() / size);
    if ((as_much - rest * solver.solve(as_much)).norm() > kWouldShow) return true;
  }
  return false;
}

}  // namespace omniflight::diagnosis
