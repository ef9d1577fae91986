#include "attitude_rows.hpp"

namespace omniflight::diagnosis {

void make_continuous(Eigen::MatrixXd& q) {
  for (Eigen::Index i = 1; i < q.rows(); ++i)
    if (q.row(i).dot(q.row(i - 1)) < 0) q.row(i) = -q.row(i);
}

void turn_into_body(const Eigen::MatrixXd& q, Eigen::MatrixXd& x) {
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    x.row(i) = (quaternion(q, i).conjugate() * Vec3(x.row(i))).transpose();
}

void turn_into_world(const Eigen::MatrixXd& q, Eigen::MatrixXd& x) {
  for (Eigen::Index i = 0; i < x.rows(); ++i) x.row(i) = (quaternion(q, i) * Vec3(x.row(i))).transpose();
}

Eigen::MatrixXd rate_from_attitude(const Eigen::MatrixXd& q, double rate_hz) {
  Eigen::MatrixXd w = Eigen::MatrixXd::Zero(q.rows(), 3);
  for (Eigen::Index i = 1; i + 1 < q.rows(); ++i)
    w.row(i) =
        0.5 * rate_hz * log_rotation(quaternion(q, i - 1).conjugate() * quaternion(q, i + 1)).transpose();
  return w;
}

}  // namespace omniflight::diagnosis
