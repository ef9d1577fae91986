#include "compare_flights.hpp"

#include <cmath>

#include "omniflight_recording/formats.hpp"

namespace omniflight::proof {
namespace {

using recording::Recording;
using recording::Signal;

/// First instant of free flight [s].
double release(const Recording& r) {
  if (const Signal* phase = r.find("phase"))
    for (Eigen::Index i = 0; i < phase->size(); ++i)
      if (phase->values(i, 0) == 1) return phase->t_s[static_cast<std::size_t>(i)];
  return 0;
}

double mean_power(const Signal& speed, const vehicle::Vehicle& vehicle, double from, double to) {
  double sum = 0;
  long count = 0;
  for (Eigen::Index i = 0; i < speed.size(); ++i) {
    const double t = speed.t_s[static_cast<std::size_t>(i)];
    if (t < from || t > to) continue;
    ++count;
    for (Eigen::Index k = 0; k < std::min<Eigen::Index>(speed.width(), vehicle.rotor_count()); ++k) {
      const auto& rotor = vehicle.rotors[static_cast<std::size_t>(k)];
      sum += rotor.drag_ratio * rotor.thrust_coefficient * std::pow(std::abs(speed.values(i, k)), 3);
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

double rms(const Eigen::VectorXd& x) { return std::sqrt(x.squaredNorm() / static_cast<double>(x.size())); }

}  // namespace

Result<FlightDifference> compare_flights(const std::filesystem::path& first,
                                         const std::filesystem::path& second,
                                         const vehicle::Vehicle& vehicle) {
  const std::filesystem::path* const paths[] = {&first, &second};
  Recording flights[2];
  const Signal *position[2], *attitude[2], *speed[2], *reference[2];
  double from = 0.5, to = 1e9;  // s: rotors have spun up, and nothing holds either vehicle any more
  for (int k = 0; k < 2; ++k) {
    auto loaded = recording::load(*paths[k]);
    if (!loaded) return Failure(loaded.error());
    flights[k] = std::move(*loaded);
    const auto need = [&](const char* name, const Signal*& out) -> Status {
      auto found = flights[k].require(name);
      if (!found) return Failure(found.error());
      out = *found;
      return {};
    };
    for (Status ok : {need("truth_position", position[k]), need("truth_attitude", attitude[k]),
                      need("rotor_speed", speed[k]), need("ref_position", reference[k])})
      if (!ok) return Failure(ok.error());
    from = std::max(from, release(flights[k]));
    to = std::min(to, position[k]->t_s.back());
  }
  if (to - from < 1.0)
    return bad_input("share less than a second of free flight", first.string() + ", " + second.string());

  FlightDifference out;
  out.duration = to - from;
  for (const double t : position[0]->t_s)
    if (t >= from && t <= to) out.t.push_back(t);
  const Eigen::MatrixXd p0 = resample(*position[0], out.t), p1 = resample(*position[1], out.t);
  const Eigen::MatrixXd q0 = resample(*attitude[0], out.t), q1 = resample(*attitude[1], out.t);
  const Eigen::VectorXd distance = (p1 - p0).rowwise().norm();
  // |sin(angle / 2)| is the vector part of q0* q1: exact where the angle is small
  Eigen::VectorXd angle(q0.rows());
  for (Eigen::Index i = 0; i < q0.rows(); ++i) {
    const Quat a(q0(i, 0), q0(i, 1), q0(i, 2), q0(i, 3)), b(q1(i, 0), q1(i, 1), q1(i, 2), q1(i, 3));
    angle[i] = to_degrees(log_rotation(a.conjugate() * b).norm());
  }
  if (!distance.allFinite() || !angle.allFinite())
    return bad_input("have no true state at the same times", first.string() + ", " + second.string());
  out.position_rmse = rms(distance);
  out.position_max = distance.maxCoeff();
  out.attitude_rmse_deg = rms(angle);
  for (int k = 0; k < 2; ++k) {
    out.power[k] = mean_power(*speed[k], vehicle, from, to);
    const Eigen::MatrixXd wanted = resample(*reference[k], out.t), flown = resample(*position[k], out.t);
    double sum = 0;
    long count = 0;
    for (Eigen::Index i = 0; i < wanted.rows(); ++i)
      if (const double e = (flown.row(i) - wanted.row(i)).squaredNorm(); std::isfinite(e)) sum += e, ++count;
    out.tracking_rmse[k] = count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
  }
  for (Eigen::Index i = 0; i < distance.size(); ++i) {
    out.distance_mm.push_back(1e3 * distance[i]);
    out.angle_mdeg.push_back(1e3 * angle[i]);
  }
  return out;
}

}  // namespace omniflight::proof
