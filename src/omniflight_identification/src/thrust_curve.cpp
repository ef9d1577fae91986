#include "omniflight_identification/thrust_curve.hpp"

#include <ceres/ceres.h>

#include "robust_covariance.hpp"

namespace omniflight::identification {
namespace {

constexpr double kLeastSpan = 0.2;  // of the fastest speed

/// scale' (sum (speed / reference)^exponent) + offset' - load, over the largest load; all parameters about 1.
struct Row {
  Eigen::VectorXd share;  ///< speeds over the reference
  double load;
  template <class T>
  bool operator()(const T* p, T* out) const {
    using std::pow;
    T sum = T(0);
    for (const double s : share) sum += pow(T(s), p[1]);
    out[0] = p[0] * sum + p[2] - load;
    return true;
  }
};

struct Data {
  Eigen::MatrixXd speed;
  Eigen::VectorXd load;
};

Result<RotorCurve> fit_curve(const Data& data, const char* what) {
  const double reference = data.speed.maxCoeff(), full = data.load.cwiseAbs().maxCoeff();
  if (!(full > 0)) return bad_input("is 0 everywhere", what, "Look at the stand's columns");
  const Eigen::Index n = data.load.size();
  double p[3] = {1.0 / static_cast<double>(data.speed.cols()), 2.0, 0.0};
  ceres::Problem problem;
  for (Eigen::Index k = 0; k < n; ++k)
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Row, 1, 3>(
                                 new Row{data.speed.row(k).transpose() / reference, data.load[k] / full}),
                             nullptr, p);
  problem.SetParameterLowerBound(p, 1, 0.5);
  problem.SetParameterUpperBound(p, 1, 4.0);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 100;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable() || summary.termination_type != ceres::CONVERGENCE || p[1] < 0.51 ||
      p[1] > 3.99)
    return bad_input("follows no power of the speed between 0.5 and 4", what,
                     "Look whether speed and load belong together, sweep a wider range");
  Eigen::VectorXd e(n);
  Eigen::MatrixXd J(n, 3), square(n, 2);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::ArrayXd share = data.speed.row(k).transpose().array() / reference;
    const double sum = share.pow(p[1]).sum();
    e[k] = p[0] * sum + p[2] - data.load[k] / full;
    J.row(k) << sum, p[0] * (share.pow(p[1]) * share.max(1e-9).log()).sum(), 1.0;
    square.row(k) << share.square().sum(), 1.0;
  }
  const Eigen::Index window = correlation_window(n, 1);
  const Eigen::Matrix3d C = robust_covariance(J, e, window);
  RotorCurve out;
  const double to_scale = full * std::pow(reference, -p[1]);
  out.exponent = {p[1], std::sqrt(C(1, 1))};
  // scale = full scale' reference^-exponent: both parameters err
  const Eigen::Vector3d gradient(to_scale, -p[0] * to_scale * std::log(reference), 0);
  out.scale = {p[0] * to_scale, std::sqrt(std::max(0.0, gradient.dot(C * gradient)))};
  out.offset = {p[2] * full, std::sqrt(C(2, 2)) * full};
  out.rms = full * std::sqrt(e.squaredNorm() / static_cast<double>(n));
  const Eigen::Vector2d q = square.colPivHouseholderQr().solve(data.load / full);
  const Eigen::Matrix2d Q = robust_covariance(square, square * q - data.load / full, window);
  const double to_coefficient = full / (reference * reference);
  out.coefficient = {q[0] * to_coefficient, std::sqrt(Q(0, 0)) * to_coefficient};
  out.slowest = data.speed.minCoeff();
  out.fastest = reference;
  return out;
}

}  // namespace

Result<ThrustCurves> fit_thrust_curves(const std::vector<BenchSweep>& sweeps) {
  Eigen::Index n = 0;
  bool torque = true;
  for (const BenchSweep& s : sweeps) {
    n += s.thrust_N.size();
    torque = torque && s.torque_Nm.size() > 0;
    if (s.speed_radps.cols() != sweeps.front().speed_radps.cols())
      return bad_input("has another number of rotors than " + sweeps.front().file, s.file,
                       "Fit stands of one kind together");
  }
  if (n == 0) return bad_input("there is no sweep", "sweeps", "Give at least one CSV of a thrust stand");
  Data thrust{Eigen::MatrixXd(n, sweeps.front().speed_radps.cols()), Eigen::VectorXd(n)};
  Eigen::VectorXd moment(n);
  Eigen::Index at = 0;
  for (const BenchSweep& s : sweeps) {
    thrust.speed.middleRows(at, s.thrust_N.size()) = s.speed_radps;
    thrust.load.segment(at, s.thrust_N.size()) = s.thrust_N;
    if (torque) moment.segment(at, s.thrust_N.size()) = s.torque_Nm;
    at += s.thrust_N.size();
  }
  const double span = thrust.speed.maxCoeff() - thrust.speed.minCoeff();
  if (span < kLeastSpan * thrust.speed.maxCoeff())
    return bad_input("speeds span " + std::to_string(static_cast<int>(100 * span / thrust.speed.maxCoeff())) +
                         " % of the fastest, a curve needs 20 % or more",
                     sweeps.front().file, "Sweep from idle to full throttle");
  ThrustCurves out;
  out.rows = n;
  auto curve = fit_curve(thrust, "thrust");
  if (!curve) return Failure(curve.error());
  out.thrust = *curve;
  if (!torque) return out;
  auto of_torque = fit_curve({thrust.speed, moment}, "torque");
  if (!of_torque) return Failure(of_torque.error());
  out.has_torque = true;
  out.torque = *of_torque;
  const Estimate &f = out.thrust.coefficient, &q = out.torque.coefficient;
  const double ratio = q.value / f.value;
  out.drag_ratio = {ratio, std::abs(ratio) * std::hypot(f.sigma / f.value, q.sigma / q.value)};
  return out;
}

double load_at(const RotorCurve& curve, double speed) {
  return curve.scale.value * std::pow(speed, curve.exponent.value);
}

}  // namespace omniflight::identification
