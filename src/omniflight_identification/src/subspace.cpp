#include <Eigen/SVD>

#include "omniflight_identification/fit.hpp"
#include "starts.hpp"

namespace omniflight::identification {
namespace {

constexpr int kSpareRows = 4;  // future and past reach this much further than twice the order

/// Lower triangular L of a covariance: x = L n with n white. Ridge of 1e-10 of the mean variance.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance) {
  const double ridge = 1e-10 * covariance.trace() / static_cast<double>(covariance.rows()) + 1e-300;
  return Eigen::LLT<Eigen::MatrixXd>(covariance +
                                     ridge * Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()))
      .matrixL();
}

}  // namespace

Result<Eigen::VectorXd> subspace_denominator(int order, const std::vector<int>& delay, const Dataset& data) {
  if (auto ok = check(data); !ok) return Failure(ok.error());
  const Eigen::Index m = data.inputs(), h = 2 * order + kSpareRows;
  const Eigen::Index past = h * (1 + m), future_u = h * m, all = past + future_u + h;
  // moments of [past outputs and inputs, future inputs, future outputs]
  Eigen::MatrixXd moments = Eigen::MatrixXd::Zero(all, all);
  Eigen::VectorXd row(all);
  for (const Experiment& e : data.experiments) {
    const auto u = [&](Eigen::Index i, Eigen::Index t) {
      const Eigen::Index late = t - delay[static_cast<std::size_t>(i)] + 1;
      return late >= 0 ? e.u(late, i) : 0.0;
    };
    for (Eigen::Index t = h; t + h <= e.y.size(); ++t) {
      Eigen::Index k = 0;
      for (Eigen::Index j = 1; j <= h; ++j) {
        row[k++] = e.y[t - j];
        for (Eigen::Index i = 0; i < m; ++i) row[k++] = u(i, t - j);
      }
      for (Eigen::Index j = 0; j < h; ++j)
        for (Eigen::Index i = 0; i < m; ++i) row[k++] = u(i, t + j);
      for (Eigen::Index j = 0; j < h; ++j) row[k++] = e.y[t + j];
      moments.selfadjointView<Eigen::Lower>().rankUpdate(row);
    }
  }
  moments = Eigen::MatrixXd(moments.selfadjointView<Eigen::Lower>());
  // what past and future outputs have in common beside the future inputs
  const auto Pp = moments.topLeftCorner(past, past), Pu = moments.block(0, past, past, future_u),
             Py = moments.topRightCorner(past, h);
  const Eigen::MatrixXd Uu = moments.block(past, past, future_u, future_u),
                        Uy = moments.block(past, past + future_u, future_u, h);
  const Eigen::LDLT<Eigen::MatrixXd> solver(Uu + 1e-10 * Uu.trace() / static_cast<double>(future_u) *
                                                     Eigen::MatrixXd::Identity(future_u, future_u));
  const Eigen::MatrixXd pp = Pp - Pu * solver.solve(Pu.transpose()), py = Py - Pu * solver.solve(Uy);
  const Eigen::MatrixXd yy = moments.bottomRightCorner(h, h) - Uy.transpose() * solver.solve(Uy);
  const Eigen::MatrixXd Lp = root_of(pp), Ly = root_of(yy);
  const Eigen::MatrixXd left = Ly.triangularView<Eigen::Lower>().solve(py.transpose());
  const Eigen::MatrixXd canonical = Lp.triangularView<Eigen::Lower>().solve(left.transpose()).transpose();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(canonical, Eigen::ComputeThinU);
  if (!canonical.allFinite() || svd.singularValues().size() < order)
    return bad_input("the inputs do not excite a model of order " + std::to_string(order), "excitation",
                     "Record a command that moves at more frequencies, or choose a lower order");
  const Eigen::MatrixXd observability = Ly * svd.matrixU().leftCols(order);
  const Eigen::MatrixXd A =
      observability.topRows(h - 1).colPivHouseholderQr().solve(observability.bottomRows(h - 1));
  // the characteristic polynomial from its eigenvalues
  Eigen::VectorXcd polynomial = Eigen::VectorXcd::Ones(1);
  const Eigen::VectorXcd values = A.eigenvalues();
  for (const std::complex<double>& value : values) {
    Eigen::VectorXcd next = Eigen::VectorXcd::Zero(polynomial.size() + 1);
    next.head(polynomial.size()) = polynomial;
    next.tail(polynomial.size()) -= value * polynomial;
    polynomial = next;
  }
  return Eigen::VectorXd(polynomial.tail(order).real());
}

}  // namespace omniflight::identification
