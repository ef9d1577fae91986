#include "omniflight_allocation/survival.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_allocation/look_ahead.hpp"

namespace omniflight::allocation {
namespace {

constexpr double kFlownPeriod = 0.01;  // s, of fly()
constexpr std::size_t kMostFlights = 10000;

Status check(const vehicle::Vehicle& v, const SurvivalConfig& c) {
  const auto refuse = [](const char* field, const char* why) {
    return bad_input(why, std::string("survival.") + field, "Correct the setting");
  };
  if (auto ok = vehicle::validate(v); !ok) return ok;
  if (v.tilt.kind == vehicle::TiltKind::none || !(v.tilt.max > v.tilt.min))
    return bad_input("'" + v.name + "' does not tilt its rotors", "tilt.kind", "Map a vehicle that does");
  const auto all = [](const auto& values, const auto& good) {
    return !values.empty() && std::all_of(values.begin(), values.end(), good);
  };
  if (!all(c.roll_times, [](double t) { return t >= 0.1 && t <= 600; }))
    return refuse("roll_times", "must be some, within [0.1, 600] s");
  if (!all(c.tilt_steps, [](double s) { return s > 0 && s <= kPi; }))
    return refuse("tilt_steps", "must be some, within (0, pi] rad a period");
  if (!all(c.shares, [](const ThrustShare& s) {
        return s.at_low > 0 && s.at_low <= 10 && s.at_high > 0 && s.at_high <= 10;
      }))
    return refuse("shares", "must be some, within (0, 10]");
  if (c.roll_times.size() * c.tilt_steps.size() * c.shares.size() > kMostFlights)
    return refuse("roll_times", "times tilt_steps times shares must be 10000 at most");
  if (!(c.left > 0) || !(c.turned_away > 0)) return refuse("left", "and turned_away must be positive");
  return {};
}

struct Flight {
  const vehicle::Vehicle& vehicle;
  const SurvivalConfig& config;
  Motion motion;
  double duration, step;
  std::function<double(double)> share;
};

Result<LoopResult> flown(const Flight& f, TiltMethod method) {
  auto weights = method == TiltMethod::case_a ? AllocatorConfig::case_a() : AllocatorConfig::case_b();
  weights.initial_tilt = std::clamp(f.config.initial_tilt, f.vehicle.tilt.min, f.vehicle.tilt.max);
  weights.tilt_step = f.step;
  weights.dynamic_weights.enabled = method != TiltMethod::case_a && method != TiltMethod::case_b;
  if (method < TiltMethod::look_ahead)
    return fly(f.vehicle, weights, f.motion, f.duration, f.share, f.config.gains);
  LookAheadConfig plan;
  plan.rate = f.step / kFlownPeriod;
  plan.reserve = method == TiltMethod::look_ahead_told ? f.config.reserve_told : f.config.reserve;
  plan.initial = weights.initial_tilt;
  if (method == TiltMethod::look_ahead_told) plan.thrust_share = f.share;
  const auto tilt = look_ahead(f.vehicle, f.motion, f.duration, plan);
  if (!tilt) return Failure(tilt.error());
  return fly(f.vehicle, weights, f.motion, f.duration, f.share, f.config.gains,
             [&](double t) { return tilt->at(t); });
}

}  // namespace

const char* words(TiltMethod method) {
  switch (method) {
    case TiltMethod::case_a:
      return "case A";
    case TiltMethod::case_b:
      return "case B";
    case TiltMethod::dynamic:
      return "dynamic weights";
    case TiltMethod::look_ahead:
      return "dynamic weights with look-ahead";
    case TiltMethod::look_ahead_told:
      return "look-ahead that is told the loss";
  }
  return "";
}

std::string ThrustShare::words() const {
  const auto percent = [](double share) { return std::to_string(std::lround(100 * share)) + " %"; };
  if (at_low == 1 && at_high == 1) return "all thrust";
  if (at_low == at_high) return percent(at_low) + " of the thrust";
  return percent(at_low) + " to " + percent(at_high) + " over the tilt";
}

Result<SurvivalMap> survival_map(const vehicle::Vehicle& vehicle, const SurvivalConfig& config,
                                 const std::function<bool(double)>& go_on) {
  if (auto ok = check(vehicle, config); !ok) return Failure(ok.error());
  SurvivalMap out{config, {}};
  const std::size_t steps = config.tilt_steps.size(), times = config.roll_times.size(),
                    count = config.shares.size() * times * steps;
  const double low = vehicle.tilt.min, range = vehicle.tilt.max - vehicle.tilt.min;
  for (std::size_t k = 0; k < count; ++k) {
    SurvivalCell cell{k / (times * steps), k / steps % times, k % steps, {}};
    const double roll_time = config.roll_times[cell.roll_time];
    const ThrustShare share = config.shares[cell.share];
    const Flight flight{
        vehicle,
        config,
        [=](double t) { return roll_reference(t, roll_time); },
        roll_time + 3.0,
        config.tilt_steps[cell.tilt_step],
        [=](double alpha) { return share.at_low + (share.at_high - share.at_low) * (alpha - low) / range; }};
    for (const TiltMethod method : kTiltMethods) {
      const auto r = flown(flight, method);
      if (!r) return Failure(r.error());
      Survival& s = cell.flights[static_cast<std::size_t>(method)];
      s = {!r->failed && r->worst_error < config.left && r->worst_angle < config.turned_away, r->worst_error,
           r->worst_angle, 0};
      if (s.survived) s.mean_power = r->mean_power;
    }
    out.cells.push_back(cell);
    if (go_on && !go_on(static_cast<double>(k + 1) / static_cast<double>(count)))
      return fail(ErrorCode::incomplete, "the map was stopped", "survival", "Start it again");
  }
  return out;
}

SurvivalComparison compare(const SurvivalMap& map, TiltMethod first, TiltMethod second) {
  SurvivalComparison out;
  for (const SurvivalCell& cell : map.cells) {
    const Survival &a = cell.of(first), &b = cell.of(second);
    out.first += a.survived;
    out.second += b.survived;
    out.only_first += a.survived && !b.survived;
    if (!a.survived || !b.survived) continue;
    const double ratio = b.mean_power / a.mean_power;
    out.lowest = out.both == 0 ? ratio : std::min(out.lowest, ratio);
    out.highest = std::max(out.highest, ratio);
    out.second_needs_less += ratio < 1;
    ++out.both;
  }
  return out;
}

}  // namespace omniflight::allocation
