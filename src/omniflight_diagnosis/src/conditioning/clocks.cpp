#include "clocks.hpp"

#include <algorithm>
#include <cmath>

#include "../numerics/text.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured.
// s, lag taken for a clock error; lags of motors, radios and filters are shorter
constexpr double kFarLag = 0.15;
constexpr double kAlike = 0.1;      // s, two lags that differ by less have one cause
constexpr double kSure = 0.7;       // least correlation of a lag that is acted upon
constexpr double kWorthIt = 1e-3;   // s, least drift over the recording that is corrected
constexpr double kSignificant = 4;  // standard errors of the skew

/// Correction of a time stamp t: lag_s + skew (t - at_s).
struct Line {
  double lag_s = 0, skew = 0, at_s = 0;
};

const Alignment* pair(const std::vector<Alignment>& all, const char* early, const char* late) {
  for (const Alignment& a : all)
    if (a.early == early && a.late == late) return &a;
  return nullptr;
}

void move(Repaired& r, std::initializer_list<const char*> names, const Line& by) {
  for (const char* name : names) {
    const auto at = r.recording.signals.find(name);
    if (at == r.recording.signals.end()) continue;
    for (double& t : at->second.t_s) t -= by.lag_s + by.skew * (t - by.at_s);
  }
  r.clock_moved = true;
}

bool far(const Alignment* a) { return a && std::abs(a->lag_s) > kFarLag && std::abs(a->correlation) > kSure; }

/// Adds the finding clock_offset: the clock `whose` deviates by lag_s and is corrected to that of `ruler`.
void name_clock(Repaired& r, const char* channel, const char* whose, double lag_s, double se_s,
                const char* ruler) {
  const double wide = 1.96 * se_s;
  r.faults.push_back({physics::effect_id::clock_offset,
                      channel,
                      format("the clock of the %s %.3f +- %.3f s %s on that of the %s; corrected.", whose,
                             std::abs(lag_s), se_s, lag_s > 0 ? "late" : "early", ruler),
                      1,
                      0,
                      {{"offset", "t_d", "s", lag_s, lag_s - wide, lag_s + wide}}});
}

}  // namespace

void settle_clocks(Repaired& r) {
  r.alignment = align_signals(r.recording);
  const Alignment* pose = pair(r.alignment, "gyro", "attitude");
  const Alignment* estimate = pair(r.alignment, "est_position", "position");
  const Alignment* turn = pair(r.alignment, "gyro", "est_attitude");
  const Alignment* thrust = pair(r.alignment, "acc", "rotor_speed (thrust)");
  const Alignment* answer = pair(r.alignment, "rotor_command", "rotor_speed");
  const Alignment* push = pair(r.alignment, "acc", "est_velocity");
  const bool estimate_agrees = estimate && !far(estimate) && std::abs(estimate->correlation) > kSure;
  const bool rotors_agree = far(thrust) && far(pose) && std::abs(pose->lag_s - thrust->lag_s) < kAlike;
  const Alignment* believed = far(push) ? push : far(turn) ? turn : nullptr;
  if (believed && far(estimate) && std::abs(believed->lag_s + estimate->lag_s) < kAlike) {
    move(r, {"est_position", "est_attitude", "est_velocity"}, {believed->lag_s});
    name_clock(r, "est_position", "vehicle's own estimate", believed->lag_s, believed->lag_se,
               "other signals");
  } else if (const Alignment* sensor = far(pose) && (rotors_agree || estimate_agrees) ? pose : believed) {
    move(r, {"gyro", "acc"}, {-sensor->lag_s});
    name_clock(r, "gyro", "gyro and accelerometer", -sensor->lag_s, sensor->lag_se,
               sensor == pose ? "pose" : "vehicle's own estimate");
  } else {
    if (const Alignment* moved = far(pose) ? pose : far(estimate) ? estimate : nullptr) {
      move(r, {"position", "attitude", "velocity"}, {moved->lag_s});
      name_clock(r, "position", "pose", moved->lag_s, moved->lag_se,
                 moved == pose ? "gyro" : "vehicle's own estimate");
    }
    if (const Alignment* rotors = far(thrust) ? thrust : far(answer) ? answer : nullptr) {
      move(r, {"rotor_speed"}, {rotors->lag_s});
      name_clock(r, "rotor_speed", "rotor speeds", rotors->lag_s, rotors->lag_se,
                 rotors == thrust ? "accelerometer" : "commands");
    }
  }
  const Alignment* ruler = pose ? pose : estimate;
  if (!ruler || !(std::abs(ruler->correlation) > kSure) || !(ruler->skew_se > 0) ||
      std::abs(ruler->skew) < kSignificant * ruler->skew_se ||
      std::abs(ruler->skew) * r.recording.duration_s < kWorthIt)
    return;
  move(r, {"position", "attitude", "velocity"}, {0, ruler->skew, ruler->at_s});
  r.notes.push_back(
      format("The clock of the pose runs %.0f +- %.0f us a second %s than that of the %s: corrected.",
             1e6 * std::abs(ruler->skew), 1e6 * ruler->skew_se, ruler->skew > 0 ? "slower" : "faster",
             ruler == pose ? "gyro" : "vehicle's own estimate"));
}

}  // namespace omniflight::diagnosis
