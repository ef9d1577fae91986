#include "motor_data.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::cli {
namespace {

using recording::Recording;
using recording::Signal;

constexpr double kTurning = 0.2;  // of the fast speed
constexpr double kGapPeriods = 5.0;
constexpr double kShortest_s = 1.0;
constexpr double kFastest_s = 1e-4, kSlowest_s = 0.1;  // sampling periods that tell of a motor

/// The sample at or before each time, NaN before the first and where it is older than max_age_s.
Eigen::VectorXd held(const Signal& s, Eigen::Index column, const std::vector<double>& t_s, double max_age_s) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(t_s.size()));
  std::size_t at = 0;
  for (std::size_t k = 0; k < t_s.size(); ++k) {
    while (at + 1 < s.t_s.size() && s.t_s[at + 1] <= t_s[k] + 1e-9) ++at;
    const double age = t_s[k] - s.t_s[at];
    out[static_cast<Eigen::Index>(k)] =
        age >= -1e-9 && age <= max_age_s ? s.values(static_cast<Eigen::Index>(at), column) : std::nan("");
  }
  return out;
}

double fast_speed(Eigen::VectorXd speed) {
  const auto place = speed.data() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(speed.size() - 1));
  std::nth_element(speed.data(), place, speed.data() + speed.size());
  return *place;
}

}  // namespace

const char* name_of(VoltageUse use) {
  switch (use) {
    case VoltageUse::none:
      return "not used";
    case VoltageUse::second_input:
      return "second input";
    case VoltageUse::product:
      return "scales the command";
  }
  return "";
}

Result<MotorSignals> motor_signals(const Recording& r, const std::string& wanted) {
  MotorSignals out;
  const Signal* speed = r.find("rotor_speed");
  if (speed == nullptr)
    return bad_input("has no measured rotor speed (rotor_speed), so nothing tells what the motors did",
                     r.file, "Log the speed of the rotors, or name it in a map (--map)");
  std::string list;
  for (const char* name : {"rotor_command", "pwm", "motor_power"}) {
    const Signal* s = r.find(name);
    if (s == nullptr) continue;
    list += std::string(list.empty() ? "" : ", ") + name;
    if (!out.command.empty() || (!wanted.empty() && wanted != name)) continue;
    if (s->width() != speed->width())
      return bad_input(std::string(name) + " has " + std::to_string(s->width()) + " rotors and rotor_speed " +
                           std::to_string(speed->width()),
                       r.file, "Name the columns of both in a map (--map)");
    out.command = name;
    out.unit = s->unit;
  }
  if (out.command.empty())
    return bad_input(wanted.empty() ? "has no command of the motors (rotor_command, pwm or motor_power)"
                                    : "has no signal " + wanted + (list.empty() ? "" : "; it has " + list),
                     r.file, "Log what the motors are told, or name it in a map (--map)");
  if (const Signal* voltage = r.find("vbat"); voltage != nullptr) {
    out.voltage = VoltageUse::second_input;
    out.reference_V = voltage->values.col(0).mean();
  }
  out.rotors = speed->width();
  out.period_s = speed->median_period_s();
  if (!(out.period_s >= kFastest_s && out.period_s <= kSlowest_s))
    return bad_input("rotor_speed comes every " + std::to_string(out.period_s) +
                         " s; 0.0001 to 0.1 s can show a motor's lag",
                     r.file, "Log rotor speed and command at 100 Hz or faster");
  return out;
}

Result<identification::Dataset> rotor_data(const Recording& r, const MotorSignals& signals,
                                           Eigen::Index rotor) {
  const Signal& speed = *r.find("rotor_speed");
  const Signal& command = *r.find(signals.command);
  const Signal* voltage = signals.voltage != VoltageUse::none ? r.find("vbat") : nullptr;
  const std::string where = r.file + ", rotor " + std::to_string(rotor + 1);
  if (rotor >= speed.width() || rotor >= command.width())
    return bad_input("is not in the recording, which has " + std::to_string(speed.width()), where);
  if (signals.voltage != VoltageUse::none && voltage == nullptr)
    return bad_input("has no battery voltage (vbat), which other recordings have", r.file,
                     "Identify recordings without it apart from those with it");
  const double T = signals.period_s, from = speed.t_s.front();
  const auto count = static_cast<std::size_t>((speed.t_s.back() - from) / T) + 1;
  if (count > 5'000'000) return bad_input("is too long for one identification", where, "Cut it");
  std::vector<double> t(count);
  for (std::size_t k = 0; k < count; ++k) t[k] = from + static_cast<double>(k) * T;
  Signal own = speed;
  own.values = speed.values.col(rotor).cwiseAbs();
  const double gap = kGapPeriods * T;
  const Eigen::VectorXd y = recording::resample(own, t, gap).col(0);
  const Eigen::VectorXd u = held(command, rotor, t, std::max(gap, 2 * command.median_period_s()));
  Eigen::VectorXd v = Eigen::VectorXd::Zero(y.size());
  if (voltage != nullptr)
    v = recording::resample(*voltage, t, std::max(gap, 5 * voltage->median_period_s())).col(0);

  const double turning = kTurning * fast_speed(own.values.col(0));
  if (!(turning > 0))
    return bad_input("does not turn: its measured speed is 0", where,
                     "Leave it out with --rotor, look at the sensor");
  identification::Dataset out{T, {}};
  const auto shortest = static_cast<Eigen::Index>(std::ceil(kShortest_s / T));
  for (Eigen::Index k = 0, begin = 0; k <= y.size(); ++k) {
    const bool good =
        k < y.size() && std::isfinite(y[k]) && std::isfinite(u[k]) && std::isfinite(v[k]) && y[k] > turning;
    if (good) continue;
    if (k - begin >= shortest) {
      const bool beside = signals.voltage == VoltageUse::second_input;
      identification::Experiment e{y.segment(begin, k - begin), Eigen::MatrixXd(k - begin, beside ? 2 : 1)};
      e.u.col(0) = u.segment(begin, k - begin);
      if (signals.command == "rotor_command") e.u.col(0) = e.u.col(0).cwiseAbs().eval();
      if (beside) e.u.col(1) = v.segment(begin, k - begin);
      if (signals.voltage == VoltageUse::product)
        e.u.col(0).array() *= v.segment(begin, k - begin).array() / signals.reference_V;
      out.experiments.push_back(std::move(e));
    }
    begin = k + 1;
  }
  if (out.experiments.empty())
    return bad_input("turns nowhere for a second with speed and command recorded", where,
                     "Record longer, or leave it out with --rotor");
  const Eigen::VectorXd commands = command.values.col(rotor);
  if (!(commands.maxCoeff() > commands.minCoeff()))
    return bad_input("its command (" + signals.command + ") is constant, so that nothing follows from it",
                     where, "Record a flight or a test signal in which it moves");
  return out;
}

}  // namespace omniflight::cli
