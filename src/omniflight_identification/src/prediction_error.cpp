#include "prediction_error.hpp"

namespace omniflight::identification {
namespace {

const Eigen::VectorXd kOne = Eigen::VectorXd::Ones(1);

/// Column `k` of J: factor * x(t - late) for the counted samples.
void put(Eigen::MatrixXd& J, Eigen::Index row, Eigen::Index k, const Eigen::VectorXd& x, Eigen::Index late,
         Eigen::Index skip, double factor) {
  const Eigen::Index n = x.size() - skip;
  for (Eigen::Index t = 0; t < n; ++t) {
    const Eigen::Index from = t + skip - late;
    J(row + t, k) = from >= 0 ? factor * x[from] : 0.0;
  }
}

}  // namespace

PredictionError::PredictionError(PolynomialModel model, const Dataset& data, Eigen::Index skip, double scale)
    : model_(std::move(model)), data_(data), skip_(skip), scale_(scale) {
  for (const Experiment& e : data.experiments) count_ += e.y.size() - skip;
  set_num_residuals(static_cast<int>(count_));
  mutable_parameter_block_sizes()->push_back(static_cast<int>(model_.parameters().size()));
}

bool PredictionError::evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd& e, Eigen::MatrixXd* J) const {
  PolynomialModel m = model_;
  m.set_parameters(theta);
  if (!theta.allFinite() || !schur_stable(m.c) || !schur_stable(m.f)) return false;
  e.resize(count_);
  if (J != nullptr) J->resize(count_, theta.size());
  const Eigen::VectorXd A = monic(m.a), C = monic(m.c), D = monic(m.d), F = monic(m.f);
  const double s = 1.0 / scale_;
  Eigen::Index row = 0;
  for (const Experiment& x : data_.experiments) {
    const Eigen::Index n = x.y.size() - skip_, inputs = m.b.cols();
    // w = B / F u, v = A y - w, error = (D / C) v
    Eigen::VectorXd driven = Eigen::VectorXd::Zero(x.y.size());
    for (Eigen::Index i = 0; i < inputs; ++i) {
      const Eigen::VectorXd bu = filtered(m.b.col(i), kOne, x.u.col(i));
      const Eigen::Index late = m.delay[static_cast<std::size_t>(i)];
      driven.tail(bu.size() - late) += bu.head(bu.size() - late);
    }
    const Eigen::VectorXd w = filtered(kOne, F, driven), v = filtered(A, kOne, x.y) - w;
    const Eigen::VectorXd error = filtered(D, C, v);
    e.segment(row, n) = s * error.tail(n);
    if (J != nullptr) {
      Eigen::Index k = 0;
      if (m.a.size() > 0) {
        const Eigen::VectorXd z = filtered(D, C, x.y);
        for (Eigen::Index i = 1; i <= m.a.size(); ++i) put(*J, row, k++, z, i, skip_, s);
      }
      for (Eigen::Index j = 0; j < inputs; ++j) {
        const Eigen::VectorXd z = filtered(kOne, F, filtered(D, C, x.u.col(j)));
        for (Eigen::Index i = 0; i < m.b.rows(); ++i)
          put(*J, row, k++, z, m.delay[static_cast<std::size_t>(j)] + i, skip_, -s);
      }
      if (m.c.size() > 0) {
        const Eigen::VectorXd z = filtered(kOne, C, error);
        for (Eigen::Index i = 1; i <= m.c.size(); ++i) put(*J, row, k++, z, i, skip_, -s);
      }
      if (m.d.size() > 0) {
        const Eigen::VectorXd z = filtered(kOne, C, v);
        for (Eigen::Index i = 1; i <= m.d.size(); ++i) put(*J, row, k++, z, i, skip_, s);
      }
      if (m.f.size() > 0) {
        const Eigen::VectorXd z = filtered(kOne, F, filtered(D, C, w));
        for (Eigen::Index i = 1; i <= m.f.size(); ++i) put(*J, row, k++, z, i, skip_, s);
      }
    }
    row += n;
  }
  return e.allFinite() && (J == nullptr || J->allFinite());
}

bool PredictionError::Evaluate(double const* const* parameters, double* out, double** jacobians) const {
  const Eigen::VectorXd theta = Eigen::Map<const Eigen::VectorXd>(parameters[0], parameter_block_sizes()[0]);
  Eigen::VectorXd e;
  Eigen::MatrixXd J;
  const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
  if (!evaluate(theta, e, wanted ? &J : nullptr)) return false;
  Eigen::Map<Eigen::VectorXd>(out, e.size()) = e;
  if (wanted)
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(jacobians[0], J.rows(),
                                                                                       J.cols()) = J;
  return true;
}

}  // namespace omniflight::identification
