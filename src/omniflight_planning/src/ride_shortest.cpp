#include <algorithm>
#include <cmath>

#include "path_limits.hpp"
#include "shortest_ride.hpp"

namespace omniflight::planning {
namespace {

constexpr int kSteps = 200;
constexpr int kLooks = 2000;         // at a ride, each time that it is slowed down
constexpr int kSlowings = 40;        // of local slowing
constexpr double kGentle = 0.5;      // share of an excess that one takes away
constexpr double kFirstWidth = 2.0;  // time constants of the slowest motor, and a knot's period at least
constexpr double kWider = 1.25;
constexpr int kMisses = 3;  // widths that gain nothing, after which wider ones do not either

/// A ride by the average of a profile, a whole number of knot periods long.
struct Averaged {
  const PoseCurve& curve;
  const SpeedProfile& profile;
  double width;  // s
  int intervals;
  double slower;  // than the average

  Averaged(const PoseCurve& c, const SpeedProfile& p, double w, int n)
      : curve(c), profile(p), width(w), intervals(n), slower(n * kKnotPeriod / (p.duration() + w)) {}

  TrajectoryKnot knot(int k, double alpha) const {
    const double t = k * kKnotPeriod;
    const auto law = profile.averaged(t / slower, width);
    TrajectoryKnot out{t, curve.at(law.u, law.du / slower, law.ddu / (slower * slower))};
    out.reference.alpha = alpha;
    return out;
  }
  std::vector<TrajectoryKnot> knots(double alpha) const {
    std::vector<TrajectoryKnot> out;
    out.reserve(static_cast<std::size_t>(intervals) + 1);
    for (int k = 0; k <= intervals; ++k) out.push_back(knot(k, alpha));
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
  LocalSlowing(const PoseCurve& curve, const Rotors& rotors, const MotionLimits& limits,
               const PathLimits& places)
      : curve_(curve), rotors_(rotors), limits_(limits), places_(places) {}

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
    const Averaged ride(curve_, profile, width,
                        static_cast<int>(std::ceil((profile.duration() + width) / kKnotPeriod)));
    const int stride = 1 + ride.intervals / kLooks;
    const double alpha = rotors_.load().alpha();
    const auto place_at = [&](double t) {
      return profile.averaged(t / ride.slower, 1e-9).u / curve_.length() * places_.steps();
    };
    std::vector<double> less(shares.size(), 1.0);
    for (int k = 0; k < ride.intervals; k += stride) {
      const double use = use_of(peaks({ride.knot(k, alpha), ride.knot(k + 1, alpha)}, rotors_), limits_);
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

  const PoseCurve& curve_;
  const Rotors& rotors_;
  const MotionLimits& limits_;
  const PathLimits& places_;
};

}  // namespace

Result<std::vector<TrajectoryKnot>> ride_shortest(const PoseCurve& curve, const Rotors& rotors,
                                                  const MotionLimits& limits, const Deadline& deadline) {
  auto best = ride(curve, rotors, limits, deadline);
  if (!best || curve.length() <= 0.0 || rotors.load().rank() < 6) return best;
  const auto places = PathLimits::create(curve, rotors.load(), limits, kSteps, deadline);
  if (!places) return best;
  const LocalSlowing slowing(curve, rotors, limits, *places);
  const auto keeps = [&](const std::vector<TrajectoryKnot>& knots) {
    return within(peaks(knots, rotors), limits);
  };
  // a wider average asks less of the motors, and takes its width longer
  const double first = std::max(kKnotPeriod, kFirstWidth * rotors.slowest());
  bool gained = false;
  for (double width = first, misses = 0; width < best->back().t && misses < kMisses; width *= kWider) {
    if (gained) ++misses;
    const auto profile = slowing.profile(width, deadline);
    if (!profile) return best;
    const double least = profile->duration() + width;
    if (least >= best->back().t) continue;
    auto found = first_ride(
        least,
        [&](int intervals, double) {
          return Averaged(curve, *profile, width, intervals).knots(rotors.load().alpha());
        },
        keeps, deadline);
    if (!found) return best;
    if (found->back().t < best->back().t) best = std::move(found), gained = true, misses = 0;
  }
  return best;
}

}  // namespace omniflight::planning
