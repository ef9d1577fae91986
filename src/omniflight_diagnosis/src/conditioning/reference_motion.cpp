#include "reference_motion.hpp"

#include <optional>

#include "attitude_rows.hpp"
#include "omniflight_diagnosis/filter.hpp"

namespace omniflight::diagnosis {
namespace {

/// Attitudes (rows w, x, y, z) with the heading of `asked` in which thrust along `axis_B` carries `specific`
/// [m/s^2, world axes].
Eigen::MatrixXd leaning(const Eigen::MatrixXd& asked, const Vec3& axis_B, const Eigen::MatrixXd& specific) {
  Eigen::MatrixXd out(asked.rows(), 4);
  for (Eigen::Index i = 0; i < asked.rows(); ++i) {
    const Quat heading = from_roll_pitch_yaw({0, 0, roll_pitch_yaw(quaternion(asked, i)).z()});
    const Vec3 thrust = specific.row(i).transpose();
    const Quat q = thrust.norm() > 0 ? shortest_rotation(heading * axis_B, thrust) * heading : heading;
    out.row(i) << q.w(), q.x(), q.y(), q.z();
  }
  make_continuous(out);
  return out;
}

}  // namespace

bool attitude_is_free(const vehicle::Vehicle& vehicle,
                      const std::vector<const recording::Recording*>& recordings) {
  constexpr double kParallel = 0.999;  // cosine of 2.6 deg: mounting errors are not counted; chosen
  const auto parallel_at = [&](double tilt) {
    for (int i = 1; i < vehicle.rotor_count(); ++i)
      if (std::abs(vehicle.rotor_axis(i, tilt).dot(vehicle.rotor_axis(0, tilt))) < kParallel) return false;
    return true;
  };
  bool tilts = false, tilted = false, known = !recordings.empty();
  for (const vehicle::Rotor& r : vehicle.rotors) tilts = tilts || r.tilts;
  if (!tilts) return !parallel_at(0.0);
  for (const recording::Recording* r : recordings) {
    const recording::Signal* alpha = r->find("alpha") ? r->find("alpha") : r->find("alpha_command");
    if (!alpha || alpha->empty() || alpha->width() != 1) {
      known = false;
      continue;
    }
    for (Eigen::Index i = 0; i < alpha->values.rows(); ++i)
      if (std::isfinite(alpha->values(i, 0)) && !parallel_at(alpha->values(i, 0))) tilted = true;
  }
  return !known || tilted;
}

Eigen::MatrixXd reference_motion(const recording::Recording& recording, const Grid& grid,
                                 const vehicle::Vehicle& vehicle, const Options& o) {
  const auto given = [&](const char* name) {
    const recording::Signal* s = recording.find(name);
    return s ? on_grid(*s, grid, o).x : Eigen::MatrixXd::Zero(grid.size(), 0);
  };
  const auto slope = [&](const Eigen::MatrixXd& x) { return differentiate(x, grid.rate_hz); };
  Eigen::MatrixXd v = given("ref_velocity"), a = given("ref_acceleration"), q = given("ref_attitude"),
                  w = given("ref_angular_velocity"), dw = given("ref_angular_acceleration");
  if (v.cols() == 0) v = slope(given("ref_position"));
  if (a.cols() == 0) a = slope(v);
  a.rowwise() += o.environment.gravity * Eigen::RowVector3d::UnitZ().leftCols(a.cols());
  if (!attitude_is_free(vehicle, {&recording})) {
    w = dw = Eigen::MatrixXd::Zero(grid.size(), 0);
    q = a.cols() == 3 && q.cols() == 4 ? leaning(q, vehicle.rotor_axis(0, 0), a)
                                       : Eigen::MatrixXd::Zero(grid.size(), 0);
  }
  if (w.cols() == 0 && q.cols() == 4) w = rate_from_attitude(q, grid.rate_hz);
  if (dw.cols() == 0) dw = slope(w);
  if (q.cols() == 4)
    for (Eigen::MatrixXd* x : {&v, &a})
      if (x->cols() == 3) turn_into_body(q, *x);
  Eigen::MatrixXd out(grid.size(), v.cols() + a.cols() + w.cols() + dw.cols());
  out << v, a, w, dw;
  return out;
}

}  // namespace omniflight::diagnosis
