#include "omniflight_report/flight_metrics.hpp"

namespace omniflight::report {
namespace {

using recording::Recording;
using recording::Signal;

/// From the first to the last motion of the reference; everything when it never moves.
std::pair<double, double> moving_window(const Recording& r) {
  const Signal* v = r.find("ref_velocity");
  const Signal* w = r.find("ref_angular_velocity");
  const Signal* p = r.find("ref_position");
  double from = p->t_s.front(), to = p->t_s.back();
  bool found = false;
  for (const Signal* s : {v, w}) {
    if (!s) continue;
    for (Eigen::Index i = 0; i < s->size(); ++i) {
      if (s->values.row(i).norm() < 1e-9) continue;
      const double t = s->t_s[static_cast<std::size_t>(i)];
      from = found ? std::min(from, t) : t;
      to = found ? std::max(to, t) : t;
      found = true;
    }
  }
  return {from, to};
}

Quat quaternion(const Eigen::MatrixXd& m, Eigen::Index i) { return Quat(m(i, 0), m(i, 1), m(i, 2), m(i, 3)); }

Tracking track(const Recording& r, const Signal& position, const Signal* attitude, double from, double to) {
  Tracking out;
  for (std::size_t i = 0; i < position.t_s.size(); ++i)
    if (position.t_s[i] >= from && position.t_s[i] <= to) out.t.push_back(position.t_s[i]);
  const auto n = static_cast<Eigen::Index>(out.t.size());
  out.error = Eigen::MatrixXd::Zero(n, 6);
  const Eigen::MatrixXd p = recording::resample(position, out.t),
                        p_ref = recording::resample(*r.find("ref_position"), out.t);
  out.error.leftCols(3) = p - p_ref;
  const Signal* ref = r.find("ref_attitude");
  if (attitude && ref) {
    const Eigen::MatrixXd q = recording::resample(*attitude, out.t), q_ref = recording::resample(*ref, out.t);
    for (Eigen::Index i = 0; i < n; ++i)
      out.error.row(i).tail(3) =
          log_rotation(quaternion(q_ref, i).conjugate() * quaternion(q, i)).transpose() * (180.0 / kPi);
  }
  Eigen::Array<double, 6, 1> sum = Eigen::Array<double, 6, 1>::Zero();
  Eigen::Index used = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!out.error.row(i).allFinite()) continue;
    sum += out.error.row(i).transpose().array().square();
    ++used;
    const double distance = out.error.row(i).head<3>().norm();
    const double angle = out.error.row(i).tail<3>().norm(), t = out.t[static_cast<std::size_t>(i)];
    if (distance > out.worst_position) out.worst_position = distance, out.worst_position_at = t;
    if (angle > out.worst_attitude) out.worst_attitude = angle, out.worst_attitude_at = t;
    if (distance > kLeftReference && !out.left_at) out.left_at = t;
  }
  if (used > 0) sum = (sum / static_cast<double>(used)).sqrt();
  out.position_rmse = sum.head<3>();
  out.attitude_rmse = sum.tail<3>();
  return out;
}

}  // namespace

PowerCurve mechanical_power(const Recording& r, const vehicle::Vehicle& vehicle) {
  PowerCurve out;
  const Signal* speed = r.find("rotor_speed");
  if (!speed) return out;
  out.t = speed->t_s;
  out.W.assign(out.t.size(), 0.0);
  const int rotors = std::min<int>(vehicle.rotor_count(), static_cast<int>(speed->width()));
  for (Eigen::Index i = 0; i < speed->size(); ++i)
    for (int k = 0; k < rotors; ++k) {
      const auto& rotor = vehicle.rotors[static_cast<std::size_t>(k)];
      const double w = std::abs(speed->values(i, k));
      out.W[static_cast<std::size_t>(i)] += rotor.drag_ratio * rotor.thrust_coefficient * w * w * w;
    }
  return out;
}

Result<FlightMetrics> assess(const Recording& r, const vehicle::Vehicle& vehicle) {
  if (auto ok = r.require("ref_position"); !ok) return Failure(ok.error());
  FlightMetrics m;
  std::tie(m.from, m.to) = moving_window(r);
  const Signal* position = r.find("position") ? r.find("position") : r.find("est_position");
  const Signal* attitude = r.find("position") ? r.find("attitude") : r.find("est_attitude");
  if (!position) return bad_input("neither position nor est_position was recorded", r.file);
  m.measured = track(r, *position, attitude, m.from, m.to);
  if (const Signal* truth = r.find("truth_position")) {
    m.has_truth = true;
    m.truth = track(r, *truth, r.find("truth_attitude"), m.from, m.to);
  }
  const PowerCurve power = mechanical_power(r, vehicle);
  std::size_t used = 0;
  for (std::size_t i = 0; i < power.t.size(); ++i) {
    if (power.t[i] < m.from || power.t[i] > m.to) continue;
    ++used;
    m.mean_power += power.W[i];
  }
  if (used > 0) m.mean_power /= static_cast<double>(used);
  m.thesis_power = m.mean_power / (2.0 * kPi);  // c_tau per Hz^2 times Hz^3 drops one factor of 2 pi
  if (const Signal* integral = r.find("integral")) {
    m.has_integral = true;
    const Signal part = recording::window(*integral, m.from, m.to);
    if (part.size() > 0) {
      m.mean_integral = part.values.colwise().mean().transpose();
      m.rms_integral =
          (part.values.colwise().squaredNorm() / static_cast<double>(part.size())).cwiseSqrt().transpose();
    }
  }
  return m;
}

std::vector<ComparedRow> compare(const FlightMetrics& a, const FlightMetrics& b) {
  std::vector<ComparedRow> rows;
  const char* const position[] = {"x", "y", "z"};
  const char* const attitude[] = {"roll", "pitch", "yaw"};
  for (int k = 0; k < 3; ++k)
    rows.push_back(
        {std::string("RMSE ") + position[k], "m", a.measured.position_rmse[k], b.measured.position_rmse[k]});
  for (int k = 0; k < 3; ++k)
    rows.push_back({std::string("RMSE ") + attitude[k], "deg", a.measured.attitude_rmse[k],
                    b.measured.attitude_rmse[k]});
  rows.push_back({"mean power", "W", a.mean_power, b.mean_power});
  rows.push_back({"mean power, thesis convention", "c_tau Hz^3", a.thesis_power, b.thesis_power});
  if (a.has_integral && b.has_integral)
    for (int k = 0; k < 3; ++k)
      rows.push_back({std::string("mean integral action ") + position[k], "m/s2", a.mean_integral[k],
                      b.mean_integral[k]});
  return rows;
}

}  // namespace omniflight::report
