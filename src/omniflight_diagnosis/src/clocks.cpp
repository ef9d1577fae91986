#include "clocks.hpp"

#include <algorithm>
#include <cmath>

#include "text.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kFar = 0.15;       // s: motors, radios and filters are quicker
constexpr double kAlike = 0.1;      // s between two lags that one clock explains
constexpr double kSure = 0.7;       // correlation
constexpr double kWorthIt = 1e-3;   // s of skew over the recording
constexpr double kSignificant = 4;  // standard errors

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

bool far(const Alignment* a) { return a && std::abs(a->lag_s) > kFar && std::abs(a->correlation) > kSure; }

std::string side(double lag_s, double se_s) {
  return format("%.3f +- %.3f s %s", std::abs(lag_s), se_s, lag_s > 0 ? "late" : "early");
}

}  // namespace

void settle_clocks(Repaired& r) {
  r.alignment = align_signals(r.recording);
  const Alignment* pose = pair(r.alignment, "gyro", "attitude");
  const Alignment* thrust = pair(r.alignment, "acc", "rotor_speed (thrust)");
  const Alignment* answer = pair(r.alignment, "rotor_command", "rotor_speed");
  if (far(pose) && far(thrust) && std::abs(pose->lag_s - thrust->lag_s) < kAlike) {
    move(r, {"gyro", "acc"}, {-pose->lag_s});
    r.notes.push_back("The clock of gyro and accelerometer is " + side(-pose->lag_s, pose->lag_se) +
                      " on those of the pose and the rotor speeds: corrected.");
  } else {
    if (far(pose)) {
      move(r, {"position", "attitude", "velocity"}, {pose->lag_s});
      r.notes.push_back("The clock of the pose is " + side(pose->lag_s, pose->lag_se) +
                        " on that of the gyro: corrected.");
    }
    if (const Alignment* rotors = far(thrust) ? thrust : far(answer) ? answer : nullptr) {
      move(r, {"rotor_speed"}, {rotors->lag_s});
      r.notes.push_back("The clock of the rotor speeds is " + side(rotors->lag_s, rotors->lag_se) +
                        " on that of the " + (rotors == thrust ? "accelerometer" : "commands") +
                        ": corrected.");
    }
  }
  if (!pose || !(pose->skew_se > 0) || std::abs(pose->skew) < kSignificant * pose->skew_se ||
      std::abs(pose->skew) * r.recording.duration_s < kWorthIt)
    return;
  move(r, {"position", "attitude", "velocity"}, {0, pose->skew, pose->at_s});
  r.notes.push_back(
      format("The clock of the pose runs %.0f +- %.0f us a second %s than that of the gyro: corrected.",
             1e6 * std::abs(pose->skew), 1e6 * pose->skew_se, pose->skew > 0 ? "slower" : "faster"));
}

}  // namespace omniflight::diagnosis
