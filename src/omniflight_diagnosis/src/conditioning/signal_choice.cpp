#include "signal_choice.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

/// Share of the signal's span that lies in gaps longer than max_gap_s.
double gap_share(const Signal& s, double max_gap_s) {
  double lost = 0;
  for (std::size_t i = 1; i < s.t_s.size(); ++i)
    if (const double step = s.t_s[i] - s.t_s[i - 1]; step > max_gap_s) lost += step;
  const double span = s.t_s.back() - s.t_s.front();
  return span > 0 ? lost / span : 1.0;
}

/// The measured signal, or the onboard estimate where the measurement is missing, or has gaps over more than
/// 5 % of the time (chosen) and the estimate less than half as many.
const Signal* measured_or_estimated(const Recording& recording, const std::string& name, const Options& o,
                                    std::vector<std::string>& notes) {
  const Signal* measured = recording.find(name);
  const Signal* estimated = recording.find("est_" + name);
  if (!estimated) return measured;
  if (!measured || (gap_share(*measured, o.max_gap_s) > 0.05 &&
                    gap_share(*estimated, o.max_gap_s) < 0.5 * gap_share(*measured, o.max_gap_s))) {
    notes.push_back("The " + name + " is the vehicle's own estimate: " +
                    (measured ? "the measured one has many gaps." : "no measured one was recorded."));
    return estimated;
  }
  return measured;
}

/// Shifts the pose to the clock of the gyro where the lag is known to 2 ms (standard error).
void align_pose(ChosenSignals& c) {
  for (const Alignment& a : c.alignment) {
    if (a.early != "gyro" || a.late != c.attitude.name || !(a.lag_se < 0.002)) continue;
    const auto shift = [&a](Signal& s) {
      for (double& t : s.t_s) t -= a.lag_s;
    };
    shift(c.attitude);
    if (c.position && c.position->name == "position" && a.late == "attitude") shift(*c.position);
  }
}

}  // namespace

std::vector<const Signal*> ChosenSignals::all() const {
  std::vector<const Signal*> out{&attitude, &rotors.speed};
  for (const Signal* s : {acc, gyro, position ? &*position : nullptr, velocity})
    if (s) out.push_back(s);
  return out;
}

Result<ChosenSignals> choose_signals(const Repaired& repaired, const vehicle::Vehicle& vehicle,
                                     const Options& o, std::vector<std::string>& notes) {
  const Recording& recording = repaired.recording;
  ChosenSignals out;
  const Signal* attitude = measured_or_estimated(recording, "attitude", o, notes);
  if (!attitude)
    return bad_input("no signal 'attitude', so forces cannot be told from gravity", recording.file,
                     "Record it, or name the column with --map");
  out.attitude = *attitude;
  auto rotors = thrust_source(recording, vehicle);
  if (!rotors)
    return bad_input("no 'rotor_speed', 'rotor_command' or 'pwm': the wrench of the rotors is unknown",
                     recording.file, "Record one of them, or name the columns with --map");
  out.rotors = std::move(*rotors);
  if (!out.rotors.note.empty()) notes.push_back(out.rotors.note);
  out.acc = recording.find("acc");
  out.gyro = recording.find("gyro");
  if (const Signal* position = measured_or_estimated(recording, "position", o, notes))
    out.position = *position;
  out.velocity = measured_or_estimated(recording, "velocity", o, notes);
  if (!out.acc && !out.velocity && !out.position)
    return bad_input("neither accelerometer nor velocity nor position was recorded", recording.file,
                     "The force residual needs one of 'acc', 'velocity', 'position'");
  out.alignment =
      repaired.alignment.empty() || repaired.clock_moved ? align_signals(recording) : repaired.alignment;
  align_pose(out);
  return out;
}

}  // namespace omniflight::diagnosis
