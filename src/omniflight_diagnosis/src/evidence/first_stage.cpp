#include "first_stage.hpp"

namespace omniflight::diagnosis {

bool is_weak(const Eigen::Ref<const Eigen::VectorXd>& instrument, double coefficient,
             const Eigen::Ref<const Eigen::VectorXd>& left) {
  const double explained = coefficient * instrument.squaredNorm();
  return explained * explained < kWeakInstrument * instrument.cwiseProduct(left).squaredNorm();
}

double first_stage(const Eigen::Ref<const Eigen::VectorXd>& predicted,
                   const Eigen::Ref<const Eigen::VectorXd>& measured) {
  const double information = predicted.squaredNorm();
  if (!(information > 0)) return 0;
  const double coefficient = predicted.dot(measured) / information;
  return is_weak(predicted, coefficient, measured - coefficient * predicted) ? 0.0 : coefficient;
}

Eigen::VectorXd first_stages(const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& measured) {
  Eigen::VectorXd out(predicted.cols());
  for (Eigen::Index k = 0; k < out.size(); ++k) out[k] = first_stage(predicted.col(k), measured.col(k));
  return out;
}

}  // namespace omniflight::diagnosis
