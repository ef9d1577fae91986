#include "analysis_scope.hpp"

#include <algorithm>

namespace omniflight::diagnosis {
namespace {

using recording::Recording;

bool any(const Recording& r, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* name) { return r.find(name) != nullptr; });
}

bool has_attitude(const Recording& r) { return any(r, {"attitude", "est_attitude"}); }
bool has_place(const Recording& r) { return any(r, {"position", "est_position"}); }
bool has_motion(const Recording& r) { return has_place(r) || any(r, {"acc", "velocity", "est_velocity"}); }

}  // namespace

AnalysisScope scope_of(const Recording& r) {
  if (!any(r, {"rotor_speed", "rotor_command", "pwm", "motor_power", "thrust_model"}))
    return AnalysisScope::sensors;
  return has_attitude(r) && has_motion(r) ? AnalysisScope::wrench : AnalysisScope::motors;
}

std::vector<MissingSignal> missing_signals(const Recording& r) {
  std::vector<MissingSignal> out;
  const auto add = [&](const char* signal, const char* costs) { out.push_back({signal, costs}); };
  const AnalysisScope scope = scope_of(r);
  if (scope == AnalysisScope::sensors)
    add("rotor_speed",
        "no wrench of the rotors is known: mass, thrust, drag, load, wind and ropes cannot be told; commands "
        "(rotor_command or pwm) would do for most of them, and without attitude for the balance of the "
        "motors");
  if (!has_attitude(r))
    add("attitude",
        "forces cannot be told from gravity: the wrench is not judged, nor a bias of the gyro in flight");
  if (!has_motion(r))
    add("acc", "no force on the body is known: position or velocity would do, but more slowly");
  else if (!r.find("acc"))
    add("acc", "forces are second derivatives of a pose: gusts and quick effects drown in its noise");
  if (!r.find("gyro"))
    add("gyro",
        "torques are second derivatives of an attitude, if there is one: quick ones drown in its noise");
  if (!has_place(r))
    add("position",
        "nothing that hangs on height or place is told (cable, rope, ground, walls), and no bias of the "
        "accelerometer in flight");
  if (scope != AnalysisScope::sensors && !r.find("rotor_speed"))
    add("rotor_speed",
        any(r, {"rotor_command", "thrust_model"})
            ? "thrust is that of the command: lag, sag and a weak motor look like the air"
            : "thrust is modelled from duty cycles with a scale of its own: mass, thrust scale and "
              "constant pull are not told");
  if (scope != AnalysisScope::sensors && r.find("rotor_speed") && !any(r, {"rotor_command", "pwm"}))
    add("rotor_command",
        "lag and dead time of the motors, and speeds that miss their command, are not judged");
  if (scope != AnalysisScope::sensors && !r.find("vbat"))
    add("vbat", "a sagging battery is seen by the speeds alone");
  if (!r.find("ref_position"))
    add("ref_position", "tracking is not judged, and the flight cannot be flown again in closed loop");
  return out;
}

}  // namespace omniflight::diagnosis
