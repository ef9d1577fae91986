#include "tilt.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

constexpr double kSameTilt = 1e-12;    // rad
constexpr double kShortestTilt = 0.5;  // s

}  // namespace

std::vector<TiltPiece> tilt_pieces(const std::vector<TrajectoryKnot>& knots) {
  std::vector<TiltPiece> out;
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const bool moves = std::abs(knots[k + 1].reference.alpha - knots[k].reference.alpha) > kSameTilt;
    if (out.empty() || out.back().moves != moves)
      out.push_back({k, k + 1, moves});
    else
      out.back().last = k + 1;
  }
  return out;
}

std::vector<TrajectoryKnot> move_tilt(const Pose& pose, double from, double to, double rate) {
  const double seconds = std::max(kShortestTilt, 1.875 * std::abs(to - from) / (kShareOfRate * rate));
  const int periods = static_cast<int>(std::ceil(seconds / kKnotPeriod));
  std::vector<TrajectoryKnot> out(static_cast<std::size_t>(periods) + 1);
  for (int i = 0; i <= periods; ++i) {
    const double s = static_cast<double>(i) / periods;
    auto& knot = out[static_cast<std::size_t>(i)];
    knot.t = i * kKnotPeriod;
    knot.reference.p_WB = pose.p_WB;
    knot.reference.q_WB = pose.q_WB;
    knot.reference.alpha = from + (to - from) * s * s * s * (10 + s * (-15 + 6 * s));
  }
  return out;
}

double fastest_tilt(const std::vector<TrajectoryKnot>& knots) {
  double out = 0.0;
  for (std::size_t k = 1; k < knots.size(); ++k)
    out = std::max(out, std::abs(knots[k].reference.alpha - knots[k - 1].reference.alpha) /
                            (knots[k].t - knots[k - 1].t));
  return out;
}

double rim_travel(const vehicle::Vehicle& vehicle, double angle) {
  double radius = 0;
  for (const vehicle::Rotor& r : vehicle.rotors)
    if (r.tilts) radius = std::max(radius, r.radius);
  return radius * std::abs(angle);
}

Result<MotionPeaks> peaks_while_tilting(const vehicle::Vehicle& vehicle,
                                        const std::vector<TrajectoryKnot>& knots, const TiltPiece& piece,
                                        double headroom, const Deadline& deadline) {
  MotionPeaks out;
  vehicle::RotorVector before;
  for (std::size_t k = piece.first; k <= piece.last; ++k) {
    if (deadline.passed()) return out_of_time(deadline, "moving the tilt");
    const auto rotors = Rotors::create(vehicle, knots[k].reference.alpha, headroom);
    if (!rotors) return Failure(rotors.error());
    MotionPeaks here = peaks({knots[k]}, *rotors);
    const auto now = Rotors::Thrusts(*rotors).of(rotors->load().required_wrench(knots[k].reference));
    if (k > piece.first) {
      here.thrust_rate = rotors->rate(before, now, knots[k].t - knots[k - 1].t);
      here.thrust_rate_at = knots[k].t;
    }
    before = now;
    out = larger(out, here, 0.0);
  }
  return out;
}

Result<double> load_alone(const vehicle::Vehicle& vehicle, const std::vector<TrajectoryKnot>& knots) {
  double most = 0.0;
  for (const TiltPiece& piece : tilt_pieces(knots)) {
    if (piece.moves) {
      const auto moving = peaks_while_tilting(vehicle, knots, piece, 0.0);
      if (!moving) return Failure(moving.error());
      most = std::max(most, moving->rotor_load);
      continue;
    }
    const auto rotors = allocation::RotorLoad::create(vehicle, knots[piece.first].reference.alpha);
    if (!rotors) return Failure(rotors.error());
    for (std::size_t k = piece.first; k <= piece.last; ++k)
      most = std::max(most, rotors->motion_load(knots[k].reference));
  }
  return most;
}

}  // namespace omniflight::planning
