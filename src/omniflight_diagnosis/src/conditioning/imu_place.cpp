#include "imu_place.hpp"

#include <algorithm>

#include "omniflight_diagnosis/residual.hpp"

namespace omniflight::diagnosis {

recording::Recording at_origin(const recording::Recording& recording, const Vec3& p_BI) {
  constexpr double kGap = 0.05;  // s, longest gap of the gyro that is interpolated; chosen
  const recording::Signal *acc = recording.find("acc"), *gyro = recording.find("gyro");
  if (p_BI.isZero() || !acc || !gyro || acc->width() != 3 || gyro->width() != 3 || gyro->size() < 3)
    return recording;
  const double half = std::max(0.005, gyro->median_period_s());  // s
  recording::Recording out = recording;
  recording::Signal& moved = out.signals.at("acc");
  const auto rate = [&](double later) {
    std::vector<double> t = moved.t_s;
    for (double& x : t) x += later;
    return recording::resample(*gyro, t, kGap);
  };
  const Eigen::MatrixXd before = rate(-half), now = rate(0), after = rate(half);
  for (Eigen::Index i = 0; i < moved.size(); ++i) {
    const Vec3 w = now.row(i).transpose(), dw = (after.row(i) - before.row(i)).transpose() / (2 * half);
    const Vec3 beside = beside_origin(p_BI, w, dw);
    if (beside.allFinite()) moved.values.row(i) -= beside.transpose();
  }
  return out;
}

}  // namespace omniflight::diagnosis
