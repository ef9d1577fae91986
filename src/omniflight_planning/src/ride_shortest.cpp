#include "ride_shortest.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "path_limits.hpp"
#include "shortest_ride.hpp"
#include "tilt.hpp"

namespace omniflight::planning {
namespace {

constexpr int kSteps = 200;
constexpr int kLooks = 2000;         // at a ride, each time that it is slowed down
constexpr int kSlowings = 40;        // of local slowing
constexpr double kGentle = 0.5;      // share of an excess that one takes away
constexpr double kFirstWidth = 2.0;  // time constants of the slowest motor, and a knot's period at least
constexpr double kWider = 1.25;
constexpr int kMisses = 3;  // widths that gain nothing, after which wider ones do not either

/// What is ridden: a curve, the tilt along it, and what keeps to it.
struct Riding {
  const PoseCurve& curve;
  const MotionLimits& limits;
  std::function<double(double)> tilt;                             ///< rad, over the curve's parameter
  std::function<const Rotors&(double)> rotors;                    ///< at the tilt of the nearest place
  double tilt_rate;                                               ///< rad/s, that the plan may use
  double slowest;                                                 ///< s, time constant of the slowest motor
  std::function<bool(const std::vector<TrajectoryKnot>&)> keeps;  ///< every limit, exactly
};

/// A ride by the average of a profile, a whole number of knot periods long.
struct Averaged {
  const Riding& riding;
  const SpeedProfile& profile;
  double width;  // s
  int intervals;
  double slower;  // than the average

  Averaged(const Riding& r, const SpeedProfile& p, double w, int n)
      : riding(r), profile(p), width(w), intervals(n), slower(n * kKnotPeriod / (p.duration() + w)) {}

  SpeedProfile::Law law(int k) const { return profile.averaged(k * kKnotPeriod / slower, width); }
  TrajectoryKnot knot(int k) const {
    const auto l = law(k);
    TrajectoryKnot out{k * kKnotPeriod, riding.curve.at(l.u, l.du / slower, l.ddu / (slower * slower))};
    out.reference.alpha = riding.tilt(l.u);
    return out;
  }
  std::vector<TrajectoryKnot> knots() const {
    std::vector<TrajectoryKnot> out;
    out.reserve(static_cast<std::size_t>(intervals) + 1);
    for (int k = 0; k <= intervals; ++k) out.push_back(knot(k));
    return out;
  }
};

/// The largest share of a limit; 1 where it is just kept.
double use_of(const MotionPeaks& p, const MotionLimits& limits) {
  const double free = 1.0 - limits.rotor_headroom;
  return std::max({p.rotor_load / free, p.thrust_rate.share / free, p.speed / limits.speed,
                   p.acceleration / limits.acceleration, p.rate / limits.rate,
                   p.angular_acceleration / limits.angular_acceleration});
}

/// Lets a profile use less of what its places allow wherever its average exceeds a limit, until none is.
class LocalSlowing {
 public:
  LocalSlowing(const Riding& riding, const PathLimits& places) : riding_(riding), places_(places) {}

  Result<SpeedProfile> profile(double width, const Deadline& deadline) const {
    std::vector<double> shares(static_cast<std::size_t>(places_.steps()) + 1, 1.0);
    for (int k = 0;; ++k) {
      if (deadline.passed()) return out_of_time(deadline, "finding the fastest ride");
      auto profile = places_.fastest(shares);
      if (!profile || k == kSlowings || !slow(*profile, width, shares)) return profile;
    }
  }

 private:
  bool slow(const SpeedProfile& profile, double width, std::vector<double>& shares) const {
    const Averaged ride(riding_, profile, width,
                        static_cast<int>(std::ceil((profile.duration() + width) / kKnotPeriod)));
    const int stride = 1 + ride.intervals / kLooks;
    const auto place_at = [&](double t) {
      return profile.averaged(t / ride.slower, 1e-9).u / riding_.curve.length() * places_.steps();
    };
    std::vector<double> less(shares.size(), 1.0);
    for (int k = 0; k < ride.intervals; k += stride) {
      const std::vector<TrajectoryKnot> here{ride.knot(k), ride.knot(k + 1)};
      const double use = std::max(use_of(peaks(here, riding_.rotors(ride.law(k).u)), riding_.limits),
                                  fastest_tilt(here) / riding_.tilt_rate);
      if (use <= 1.0) continue;
      // what is averaged there, and up to the next look
      const auto first = static_cast<std::size_t>(place_at(k * kKnotPeriod - width * ride.slower));
      const auto last = std::min(shares.size() - 1,
                                 static_cast<std::size_t>(std::ceil(place_at((k + stride) * kKnotPeriod))));
      for (std::size_t i = first; i <= last; ++i) less[i] = std::min(less[i], std::pow(use, -kGentle));
    }
    bool any = false;
    for (std::size_t i = 0; i < shares.size(); ++i) any = any || less[i] < 1.0, shares[i] *= less[i];
    return any;
  }

  const Riding& riding_;
  const PathLimits& places_;
};

/// The shortest ride of several widths of the average that is shorter than `best`, or `best`. A wider average
/// asks less of the motors, and takes its width longer.
Knots shortest_of(const Riding& riding, const PathLimits& places, Knots best, const Deadline& deadline) {
  const LocalSlowing slowing(riding, places);
  const double first = std::max(kKnotPeriod, kFirstWidth * riding.slowest);
  bool gained = false;
  for (double width = first, misses = 0; width < best.back().t && misses < kMisses; width *= kWider) {
    if (gained) ++misses;
    const auto profile = slowing.profile(width, deadline);
    if (!profile) return best;
    const double least = profile->duration() + width;
    if (least >= best.back().t) continue;
    auto found = first_ride(
        least, [&](int intervals, double) { return Averaged(riding, *profile, width, intervals).knots(); },
        riding.keeps, deadline);
    if (!found) return best;
    if (found->back().t < best.back().t) best = std::move(*found), gained = true, misses = 0;
  }
  return best;
}

}  // namespace

Result<std::vector<TrajectoryKnot>> ride_shortest(const PoseCurve& curve, const Rotors& rotors,
                                                  const MotionLimits& limits, const Deadline& deadline) {
  auto best = ride(curve, rotors, limits, deadline);
  if (!best || curve.length() <= 0.0 || rotors.load().rank() < 6) return best;
  const auto places = PathLimits::create(curve, rotors.load(), limits, kSteps, deadline);
  if (!places) return best;
  const Riding riding{
      .curve = curve,
      .limits = limits,
      .tilt = [alpha = rotors.load().alpha()](double) { return alpha; },
      .rotors = [&rotors](double) -> const Rotors& { return rotors; },
      .tilt_rate = HUGE_VAL,
      .slowest = rotors.slowest(),
      .keeps = [&](const Knots& knots) { return within(peaks(knots, rotors), limits); },
  };
  return shortest_of(riding, *places, std::move(*best), deadline);
}

Knots ride_shortest_tilting(const PoseCurve& curve, const TiltWay& way, const vehicle::Vehicle& vehicle,
                            const MotionLimits& limits, Knots best, const Deadline& deadline) {
  if (best.empty() || curve.length() <= 0.0) return best;
  const double rate = kShareOfRate * vehicle.tilt.rate, step = curve.length() / kSteps;
  std::vector<Rotors> rotors;
  std::vector<const allocation::RotorLoad*> loads;
  std::vector<double> speeds;
  rotors.reserve(kSteps + 1);
  for (int i = 0; i <= kSteps; ++i) {
    if (deadline.passed()) return best;
    const double u = step * i;
    auto made = Rotors::create(vehicle, way.at(u), limits.rotor_headroom);
    if (!made || made->load().rank() < 6) return best;
    rotors.push_back(std::move(*made));
    loads.push_back(&rotors.back().load());
    // the tilt's rate is its slope over the way times the speed along it
    const double near = 0.5 * step, from = std::max(0.0, u - near), to = std::min(curve.length(), u + near);
    const double slope = std::abs(way.at(to) - way.at(from)) / (to - from);
    speeds.push_back(slope > 0.0 ? rate / slope : HUGE_VAL);
  }
  const auto places = PathLimits::create(curve, loads, speeds, limits, deadline);
  if (!places) return best;
  const Riding riding{
      .curve = curve,
      .limits = limits,
      .tilt = [&way](double u) { return way.at(u); },
      .rotors = [&](double u) -> const Rotors& {
        return rotors[static_cast<std::size_t>(std::clamp(std::lround(u / step), 0L, long{kSteps}))];
      },
      .tilt_rate = rate,
      .slowest = rotors.front().slowest(),
      .keeps =
          [&](const Knots& knots) {
            if (fastest_tilt(knots) > rate) return false;
            const auto most = peaks_while_tilting(vehicle, knots, {0, knots.size() - 1, true},
                                                  limits.rotor_headroom, deadline);
            return most && within(*most, limits);
          },
  };
  return shortest_of(riding, *places, std::move(best), deadline);
}

}  // namespace omniflight::planning
