#include "certify.hpp"

#include <algorithm>
#include <optional>

#include "text.hpp"
#include "tilt.hpp"
#include "tilting_check.hpp"

namespace omniflight::planning {
namespace {

/// What the motion of a piece asks at most; nothing when the deadline has passed.
std::optional<MotionPeaks> peaks_until(const Deadline& deadline, const Knots& all, const AtTilt& here) {
  constexpr std::size_t kKnotsAtOnce = 20'000;  // between looks at the clock: 5 ms
  MotionPeaks most;
  for (std::size_t from = 0; from < all.size(); from += kKnotsAtOnce) {
    if (deadline.passed()) return {};
    const std::size_t first = from == 0 ? 0 : from - 1;  // changes of thrust are between two knots
    const Knots some(all.begin() + static_cast<std::ptrdiff_t>(first),
                     all.begin() + static_cast<std::ptrdiff_t>(std::min(from + kKnotsAtOnce, all.size())));
    MotionPeaks part = peaks(some, *here.rotors);
    if (here.flat) part.lean = largest_lean(some, *here.flat);
    most = larger(part, most, 0.0);
  }
  return most;
}

}  // namespace

Status certify(const Trajectory& trajectory, const vehicle::Vehicle& vehicle, Tilts& tilts, double headroom,
               const Deadline& deadline, Certificate& c) {
  c.min_clearance = c.clearance_horizon;
  c.alpha_lowest = c.alpha_highest = c.alpha;
  const Knots& all = trajectory.knots();
  const auto late = [&] { return out_of_time(deadline, "checking the finished curve"); };
  const auto note = [&](const CurveCheck& curve, double start) -> Status {
    if (curve.out_of_time) return late();
    if (!curve.free)
      return fail(ErrorCode::incomplete,
                  text("curve_blocked: the curve comes within %.3f m at %.2f s", curve.min_clearance,
                       start + curve.at),
                  c.mission_file, "Reduce clearance_m or add waypoints");
    c.witnesses += curve.witnesses;
    if (curve.min_clearance < c.min_clearance)
      c.min_clearance = curve.min_clearance, c.min_clearance_at = start + curve.at;
    return {};
  };
  for (const TiltPiece& piece : tilt_pieces(all)) {
    if (deadline.passed()) return late();
    const double tilt = all[piece.first].reference.alpha, start = all[piece.first].t;
    for (std::size_t k = piece.first; k <= piece.last; k += piece.moves ? 1 : piece.last - piece.first) {
      c.alpha_lowest = std::min(c.alpha_lowest, all[k].reference.alpha);
      c.alpha_highest = std::max(c.alpha_highest, all[k].reference.alpha);
    }
    if (piece.moves) {
      const Knots moving(all.begin() + static_cast<std::ptrdiff_t>(piece.first),
                         all.begin() + static_cast<std::ptrdiff_t>(piece.last) + 1);
      c.peak_tilt_rate = std::max(c.peak_tilt_rate, fastest_tilt(moving));
      c.tilts_in_flight = c.tilts_in_flight || std::any_of(moving.begin(), moving.end(), [](const auto& k) {
                            return k.reference.v_WB_W.norm() + k.reference.w_WB_B.norm() > 0.0;
                          });
      const auto curve = curve_while_tilting(trajectory, piece, vehicle, tilts, deadline);
      if (!curve) return Failure(curve.error());
      if (auto ok = note(*curve, 0.0); !ok) return ok;
      const auto most = peaks_while_tilting(vehicle, all, piece, headroom, deadline);
      if (!most) return Failure(most.error());
      if (most->rotor_load > 1.0 - headroom)
        return fail(ErrorCode::incomplete,
                    text("tilt_blocked: moving the tilt needs %.0f %% of the rotors' range at %.2f s",
                         100.0 * most->rotor_load, most->rotor_load_at),
                    c.mission_file, "Move the tilt less, or at another attitude");
      c.peak = larger(c.peak, *most, 0.0);
      continue;
    }
    // hours of holds have millions of knots, which are copied only where the tilt cuts the curve into pieces
    std::optional<Trajectory> cut;
    if (piece.first > 0 || piece.last + 1 < all.size() || start != 0.0) {
      Knots knots(all.begin() + static_cast<std::ptrdiff_t>(piece.first),
                  all.begin() + static_cast<std::ptrdiff_t>(piece.last) + 1);
      for (TrajectoryKnot& knot : knots) knot.t -= start;
      auto made = Trajectory::create(std::move(knots));
      if (!made) return Failure(made.error());
      cut.emplace(std::move(*made));
    }
    const Trajectory& part = cut ? *cut : trajectory;
    if (deadline.passed()) return late();
    const auto here = tilts.at(tilt);
    if (!here) return Failure(here.error());
    const CurveCheck curve = (*here)->check.curve(part, deadline);
    if (auto ok = note(curve, start); !ok) return ok;
    const auto most = peaks_until(deadline, part.knots(), **here);
    if (!most) return late();
    c.peak = larger(c.peak, *most, start);
  }
  if (const ThrustRate& rate = c.peak.thrust_rate;
      rate.share > 1.0 - headroom)  // rides keep it, tilts may not
    return fail(ErrorCode::incomplete,
                text("rotor_lag: rotor %d needs %.0f %% of the rate of thrust that its lag allows at %.2f s",
                     rate.rotor, 100.0 * rate.share, c.peak.thrust_rate_at),
                c.mission_file, "Move the tilt less, or fly slower");
  return {};
}

Status certify_tether(const Mission& mission, const vehicle::Vehicle& without_tether, const Knots& all,
                      Certificate& c) {
  c.tether = tether_use(*mission.tether, all);
  if (const auto twisted = twist_conflict(*mission.tether, *c.tether))
    return fail(ErrorCode::incomplete, "tether_twisted: " + *twisted, mission.file,
                "Turn back on the way, or allow more twist_deg");
  const auto load = load_alone(without_tether, all);
  if (!load) return Failure(load.error());
  if (*load > 1.0 - mission.limits.rotor_headroom)
    return fail(ErrorCode::incomplete,
                text("tether_unloaded: without the tether's weight the rotors need %.0f %% of their range",
                     100.0 * *load),
                mission.file, "Attach the tether nearer to the centre of mass, or ask for less headroom");
  return {};
}

}  // namespace omniflight::planning
