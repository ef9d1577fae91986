#include "inverse_dynamics.hpp"

#include <algorithm>
#include <cmath>

#include "../conditioning/attitude_rows.hpp"
#include "../numerics/text.hpp"
#include "omniflight_diagnosis/filter.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

constexpr double
    kPoseRate = 100,
    kPoseCutoff = 6;  // Hz, grid and low pass; chosen: twice differentiated noise of a pose dominates above

const Signal* first_of(const Recording& r, const char* measured, const char* estimated) {
  return r.find(measured) ? r.find(measured) : r.find(estimated);
}

/// Resampled onto t, held through gaps, low-passed.
Eigen::MatrixXd smooth(const Signal& s, const std::vector<double>& t) {
  Eigen::MatrixXd x = recording::resample(s, t);
  for (Eigen::Index i = 1; i < x.rows(); ++i)
    if (!x.row(i).allFinite()) x.row(i) = x.row(i - 1);
  if (recording::is_attitude(s.name)) make_continuous(x);
  return low_pass(x, kPoseRate, kPoseCutoff);
}

/// Common axis of all rotors; empty where they tilt or are not parallel.
std::optional<Vec3> only_axis(const vehicle::Vehicle& v) {
  if (v.tilt.kind != vehicle::TiltKind::none) return std::nullopt;
  for (int k = 1; k < v.rotor_count(); ++k)
    if (v.rotor_axis(k, 0).dot(v.rotor_axis(0, 0)) < 0.9999) return std::nullopt;
  return v.rotor_axis(0, 0);
}

}  // namespace

std::optional<MotionOnGrid> motion_on_grid(const Recording& r, const Options& o) {
  const Signal *acc = r.find("acc"), *gyro = r.find("gyro");
  const Signal *p = first_of(r, "position", "est_position"), *q = first_of(r, "attitude", "est_attitude");
  const Signal* force = acc ? acc : p;
  if (!force) return std::nullopt;
  double from = force->t_s.front(), to = force->t_s.back();
  for (const Signal* s : {gyro, q})
    if (s) from = std::max(from, s->t_s.front()), to = std::min(to, s->t_s.back());
  if (!(to - from > 2) || to - from > 7200) return std::nullopt;
  MotionOnGrid m;
  for (int i = 0; i < static_cast<int>((to - from) * kPoseRate); ++i) m.t.push_back(from + i / kPoseRate);
  m.force = smooth(*force, m.t);
  m.in_body = acc || q;
  const Eigen::MatrixXd attitude = q ? smooth(*q, m.t) : Eigen::MatrixXd();
  if (!acc) {
    m.force = differentiate(differentiate(m.force, kPoseRate), kPoseRate);
    m.force.col(2).array() += o.environment.gravity;
    if (q) turn_into_body(attitude, m.force);
  }
  if (gyro || q) {
    m.w =
        gyro ? smooth(*gyro, m.t) : low_pass(rate_from_attitude(attitude, kPoseRate), kPoseRate, kPoseCutoff);
    m.dw = differentiate(m.w, kPoseRate);
  }
  return m;
}

std::optional<InverseDynamics> inverse_dynamics(const Recording& r, const vehicle::Vehicle& v,
                                                const Options& o) {
  const auto m = motion_on_grid(r, o);
  if (!m) return std::nullopt;
  const Eigen::Index edge = static_cast<Eigen::Index>(0.3 * kPoseRate), n = m->force.rows() - 2 * edge;
  const Eigen::VectorXd size = v.mass * m->force.middleRows(edge, n).rowwise().norm();
  InverseDynamics out;
  out.mean_N = size.mean();
  std::vector<double> sorted(size.begin(), size.end());
  std::sort(sorted.begin(), sorted.end());
  out.most_N = sorted[static_cast<std::size_t>(0.995 * static_cast<double>(n - 1))];
  for (const vehicle::Rotor& rotor : v.rotors) out.rotors_N += rotor.max_thrust;
  const double least = 0.1 * v.mass * o.environment.gravity;
  for (Eigen::Index i = 0; i < n;) {
    Eigen::Index j = i;
    while (j < n && size[j] < least) ++j;
    if (static_cast<double>(j - i) > 0.1 * kPoseRate)
      out.falls_s.emplace_back(m->t[static_cast<std::size_t>(i + edge)],
                               m->t[static_cast<std::size_t>(j - 1 + edge)]);
    i = j + 1;
  }
  double torque = 0, sideways = 0;
  const auto axis = only_axis(v);
  out.one_axis = axis && m->in_body;
  for (Eigen::Index i = edge; i < edge + n; ++i) {
    if (m->w.size() > 0) {
      const Vec3 w = m->w.row(i).transpose();
      torque += (v.inertia * Vec3(m->dw.row(i).transpose()) + w.cross(v.inertia * w)).squaredNorm();
    }
    const Vec3 f = m->force.row(i).transpose();
    if (out.one_axis) sideways += (f - f.dot(*axis) * *axis).squaredNorm();
  }
  out.torque_Nm = std::sqrt(torque / static_cast<double>(n));
  out.sideways_N = v.mass * std::sqrt(sideways / static_cast<double>(n));
  return out;
}

std::string in_words(const InverseDynamics& x, const vehicle::Vehicle& v) {
  std::string s = format(
      "To move like this a vehicle of %.4g kg needs %.3g N on average and %.3g N at most; "
      "its rotors give up to %.3g N together",
      v.mass, x.mean_N, x.most_N, x.rotors_N);
  s += x.most_N > x.rotors_N ? ", so that something else moved it, or its mass or max_thrust is wrong." : ".";
  if (x.one_axis)
    s += format(
        " %.2g N of it (RMS) act across the axis of its rotors: air, a rope, or a sensor that is askew.",
        x.sideways_N);
  if (!x.falls_s.empty())
    s += format(" It falls freely %zu times, first from %.2f to %.2f s.", x.falls_s.size(),
                x.falls_s.front().first, x.falls_s.front().second);
  return s;
}

std::vector<SensorFact> facts_of(const InverseDynamics& x) {
  std::vector<SensorFact> out{{"motion", "force needed, mean", "N", x.mean_N},
                              {"motion", "force needed, 99.5 % quantile", "N", x.most_N},
                              {"motion", "force of all rotors at their limit", "N", x.rotors_N}};
  if (x.torque_Nm > 0) out.push_back({"motion", "torque needed, RMS", "Nm", x.torque_Nm});
  if (x.one_axis) out.push_back({"motion", "force across the axis of the rotors, RMS", "N", x.sideways_N});
  double fall = 0;
  for (const auto& [from, to] : x.falls_s) fall += to - from;
  out.push_back({"motion", "time in free fall", "s", fall});
  return out;
}

}  // namespace omniflight::diagnosis
