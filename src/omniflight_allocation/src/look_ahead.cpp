#include "omniflight_allocation/look_ahead.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "omniflight_allocation/allocator.hpp"

namespace omniflight::allocation {
namespace {

constexpr double kLongest = 3600;    // s
constexpr double kMostTilts = 2000;  // on the grid
constexpr std::int64_t kMostCells = 20'000'000;
constexpr double kRest = 1e-9;  // relative cost of moving on by one tilt: of equals, rest

Status check(const vehicle::Vehicle& vehicle, double duration, const LookAheadConfig& c) {
  const auto refuse = [](const char* field, const char* why) {
    return bad_input(why, std::string("look_ahead.") + field, "Correct the setting");
  };
  if (vehicle.tilt.kind == vehicle::TiltKind::none || !(vehicle.tilt.max > vehicle.tilt.min))
    return bad_input("'" + vehicle.name + "' does not tilt its rotors", "tilt.kind",
                     "Look ahead with a vehicle that does");
  if (!(duration >= 0 && duration <= kLongest)) return refuse("duration", "must lie in [0, 3600] s");
  if (!(c.grid > 0) || !((vehicle.tilt.max - vehicle.tilt.min) / c.grid < kMostTilts))
    return refuse("grid", "must be positive, and give fewer than 2000 tilts (rad)");
  if (!(c.period >= 1e-3 && c.period <= 10)) return refuse("period", "must lie in [0.001, 10] s");
  if (!(c.reserve >= 0 && c.reserve <= 0.9)) return refuse("reserve", "must lie in [0, 0.9]");
  if (!(c.rate >= 0) || !std::isfinite(c.rate)) return refuse("rate", "must be finite and >= 0 rad/s");
  if (!((c.rate > 0 ? c.rate : vehicle.tilt.rate) > 0))
    return refuse("rate", "is not told by the vehicle (tilt.rate_deg_s), give one (rad/s)");
  if (c.initial && !(*c.initial >= vehicle.tilt.min - 1e-9 && *c.initial <= vehicle.tilt.max + 1e-9))
    return refuse("initial", "lies outside the tilt limits");
  return {};
}

/// Tilts, decisions, and how many tilts one decision may pass.
struct Grid {
  double low, step, period;
  int tilts, decisions, reach;
  double tilt(int j) const { return low + step * j; }
};

Grid grid_of(const vehicle::Vehicle& v, double duration, const LookAheadConfig& c) {
  Grid g;
  const double rate = c.rate > 0 ? c.rate : v.tilt.rate, range = v.tilt.max - v.tilt.min;
  g.low = v.tilt.min;
  g.tilts = static_cast<int>(std::ceil(range / c.grid - 1e-9)) + 1;
  g.step = range / (g.tilts - 1);
  g.reach = static_cast<int>(std::clamp(std::floor(rate * c.period / g.step), 1.0, double(g.tilts)));
  g.period = std::max(g.reach * g.step / rate, g.reach == g.tilts ? c.period : 0.0);
  g.decisions = static_cast<int>(std::ceil(duration / g.period)) + 1;
  return g;
}

/// One allocator for all tilts, or, where the share of thrust changes with the tilt, one for each: thrusts u
/// that give s u are limited to s of the limits and weighed as u.
Result<std::vector<Allocator>> at_tilts(const Grid& g, const vehicle::Vehicle& v,
                                        const AllocatorConfig& weights,
                                        const std::function<double(double)>& share) {
  std::vector<Allocator> out;
  for (int j = 0; j < (share ? g.tilts : 1); ++j) {
    const double s = share ? share(std::min(g.tilt(j), v.tilt.max)) : 1.0;
    if (!(s > 0 && s <= 10))
      return bad_input("must lie in (0, 10]", "look_ahead.thrust_share", "Correct the setting");
    vehicle::Vehicle weaker = v;
    for (vehicle::Rotor& r : weaker.rotors) r.max_thrust *= s, r.min_thrust *= s;
    AllocatorConfig config = weights;
    config.w_input /= s * s;
    auto one = Allocator::create(weaker, config);
    if (!one) return Failure(one.error());
    out.push_back(std::move(*one));
  }
  return out;
}

Allocator& of_tilt(std::vector<Allocator>& allocators, int tilt) {
  return allocators[std::min(static_cast<std::size_t>(tilt), allocators.size() - 1)];
}

/// What the motion asks for at decision k.
AllocationInput at_decision(const Grid& g, const std::function<Reference(double)>& motion, double duration,
                            int k) {
  const Reference r = motion(std::min(k * g.period, duration));
  AllocationInput in;
  in.qdd_ref << r.a_WB_W, r.dw_WB_B;
  in.q_WB = r.q_WB;
  in.w_WB_B = r.w_WB_B;
  return in;
}

/// The cheapest way into every tilt of a decision from those within reach of it.
void step_into(const Grid& g, const std::vector<double>& before, const std::vector<double>& cost,
               std::vector<double>& after, std::int16_t* from) {
  for (int j = 0; j < g.tilts; ++j) {
    double best = HUGE_VAL;
    int origin = j;
    for (int d = 0; d <= g.reach; ++d)  // the nearest first: it wins where costs are equal
      for (const int i : {j - d, j + d}) {
        if (i < 0 || i >= g.tilts) continue;
        const double way = before[static_cast<std::size_t>(i)] * (1 + kRest * d);
        if (way < best) best = way, origin = i;
      }
    after[static_cast<std::size_t>(j)] = best + cost[static_cast<std::size_t>(j)];
    from[j] = static_cast<std::int16_t>(origin);
  }
}

}  // namespace

double TiltSchedule::at(double t) const {
  if (alpha.empty()) return 0;
  const double place = std::clamp(t / period, 0.0, static_cast<double>(alpha.size() - 1));
  const auto k = std::min(static_cast<std::size_t>(place), alpha.size() - 1);
  if (k + 1 == alpha.size()) return alpha.back();
  return alpha[k] + (place - static_cast<double>(k)) * (alpha[k + 1] - alpha[k]);
}

Result<TiltSchedule> look_ahead(const vehicle::Vehicle& vehicle,
                                const std::function<Reference(double)>& motion, double duration,
                                const LookAheadConfig& config) {
  if (auto ok = vehicle::validate(vehicle); !ok) return Failure(ok.error());
  if (auto ok = check(vehicle, duration, config); !ok) return Failure(ok.error());
  const Grid g = grid_of(vehicle, duration, config);
  if (std::int64_t{g.decisions} * g.tilts > kMostCells)
    return bad_input("takes " + std::to_string(g.decisions) + " decisions over " + std::to_string(g.tilts) +
                         " tilts, more than 20 million cells",
                     "look_ahead.period", "Take a coarser grid or a longer period");
  vehicle::Vehicle kept = vehicle;
  for (vehicle::Rotor& r : kept.rotors) {
    r.max_thrust *= 1 - config.reserve;
    r.min_thrust = std::min(r.min_thrust, 0.5 * r.max_thrust);
  }
  AllocatorConfig weights = config.weights;
  weights.tilt_mode = TiltMode::fixed;
  weights.w_rate = 0;
  weights.dynamic_weights.enabled = false;
  const auto n = static_cast<std::size_t>(g.tilts);
  auto allocators = at_tilts(g, kept, weights, config.thrust_share);
  if (!allocators) return Failure(allocators.error());
  std::vector<double> before(n, HUGE_VAL), after(n), cost(n);
  std::vector<std::int16_t> from(n * static_cast<std::size_t>(g.decisions));
  const auto costs_at = [&](int k) -> Status {
    AllocationInput in = at_decision(g, motion, duration, k);
    for (int j = 0; j < g.tilts; ++j) {
      in.alpha = std::min(g.tilt(j), vehicle.tilt.max);
      const auto out = of_tilt(*allocators, j).allocate(in);
      if (!out) return Failure(out.error());
      cost[static_cast<std::size_t>(j)] = out->cost;
    }
    return {};
  };
  for (int k = 0; k < g.decisions; ++k) {
    if (auto ok = costs_at(k); !ok) return Failure(ok.error());
    if (k > 0) {
      step_into(g, before, cost, after, &from[n * static_cast<std::size_t>(k)]);
    } else {
      const int start =
          config.initial ? static_cast<int>(std::lround((*config.initial - g.low) / g.step)) : -1;
      for (int j = 0; j < g.tilts; ++j)
        after[static_cast<std::size_t>(j)] =
            start < 0 || j == start ? cost[static_cast<std::size_t>(j)] : HUGE_VAL;
    }
    std::swap(before, after);
  }
  TiltSchedule out;
  out.period = g.period;
  out.alpha.resize(static_cast<std::size_t>(g.decisions));
  auto j = static_cast<int>(std::min_element(before.begin(), before.end()) - before.begin());
  for (int k = g.decisions - 1; k >= 0; --k) {
    out.alpha[static_cast<std::size_t>(k)] = std::min(g.tilt(j), vehicle.tilt.max);
    if (k > 0) j = from[n * static_cast<std::size_t>(k) + static_cast<std::size_t>(j)];
  }
  auto whole = at_tilts(g, vehicle, weights, config.thrust_share);  // the reserve may be used
  if (!whole) return Failure(whole.error());
  for (int k = 0; k < g.decisions; ++k) {
    AllocationInput in = at_decision(g, motion, duration, k);
    in.alpha = out.alpha[static_cast<std::size_t>(k)];
    const auto tilt = static_cast<int>(std::lround((*in.alpha - g.low) / g.step));
    if (const auto found = of_tilt(*whole, tilt).allocate(in))
      out.missing = std::max(out.missing, (found->qdd - in.qdd_ref).cwiseAbs().maxCoeff());
  }
  return out;
}

}  // namespace omniflight::allocation
