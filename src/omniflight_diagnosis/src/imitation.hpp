// How well one law can do what another does.
#pragma once

#include "fit.hpp"

namespace omniflight::diagnosis {

/// Whitened columns of the last effect of a fit.
Eigen::MatrixXd last_columns(const Problem& problem, const Whitening& noise, const Fit& fit);

/// Whitened columns without what is in proportion to a thrust whose scale comes from the flight: that says
/// nothing. As they are where the scale is known.
Eigen::MatrixXd without_free_scale(const Problem& problem, Eigen::MatrixXd columns);

/// How well columns imitate directions: sqrt of the share of a direction that they explain.
class Imitator {
 public:
  explicit Imitator(const Eigen::MatrixXd& columns);
  double cosine(const Eigen::VectorXd& direction) const;

 private:
  Eigen::MatrixXd Z_;
  Eigen::LDLT<Eigen::MatrixXd> solver_;
};

/// Of one direction v by columns X.
inline double cosine_of(const Eigen::MatrixXd& X, const Eigen::VectorXd& v) { return Imitator(X).cosine(v); }

}  // namespace omniflight::diagnosis
