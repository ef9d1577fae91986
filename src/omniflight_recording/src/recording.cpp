#include "omniflight_recording/recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "omniflight_core/frames.hpp"

namespace omniflight::recording {

const std::vector<SignalSpec>& canonical_signals() {
  static const std::vector<SignalSpec> table{
      {"position", "m", 3},
      {"attitude", "1", 4},
      {"velocity", "m/s", 3},
      {"gyro", "rad/s", 3},
      {"acc", "m/s2", 3},
      {"rotor_speed", "rad/s", 0},
      {"rotor_command", "rad/s", 0},
      {"pwm", "1", 0},
      {"motor_power", "1", 0},  // commanded power before battery compensation, 0..1
      {"thrust_model", "N", 0},
      {"alpha", "rad", 1},
      {"alpha_command", "rad", 1},
      {"vbat", "V", 1},
      {"ibat", "A", 1},
      {"ref_position", "m", 3},
      {"ref_attitude", "1", 4},
      {"ref_velocity", "m/s", 3},
      {"ref_angular_velocity", "rad/s", 3},
      {"ref_acceleration", "m/s2", 3},
      {"ref_angular_acceleration", "rad/s2", 3},
      {"qddr", "m/s2, rad/s2", 6},
      {"qdd", "m/s2, rad/s2", 6},
      {"thrust_command", "N", 0},
      {"integral", "m/s2, rad/s2", 6},
      {"est_position", "m", 3},
      {"est_attitude", "1", 4},
      {"est_velocity", "m/s", 3},
      {"est_angular_velocity", "rad/s", 3},
      {"est_acceleration", "m/s2", 3},  // world, gravity removed
      {"est_roll", "rad", 1},
      {"est_yaw", "rad", 1},
      {"phase", "1", 1},
      {"truth_position", "m", 3},
      {"truth_attitude", "1", 4},
      {"truth_velocity", "m/s", 3},
      {"truth_angular_velocity", "rad/s", 3},
      {"truth_rotor_speed", "rad/s", 0},
      {"truth_alpha", "rad", 1},
      {"truth_power", "W", 1},
      {"truth_wrench", "N, N m", 6},
  };
  return table;
}

const SignalSpec* find_spec(std::string_view name) {
  for (const SignalSpec& spec : canonical_signals())
    if (name == spec.name) return &spec;
  return nullptr;
}

bool is_attitude(std::string_view name) {
  return name.size() >= 8 && name.substr(name.size() - 8) == "attitude";
}

double Signal::median_period_s() const {
  if (t_s.size() < 2) return 0.0;
  std::vector<double> steps(t_s.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = t_s[i + 1] - t_s[i];
  auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

const Signal* Recording::find(const std::string& name) const {
  const auto found = signals.find(name);
  return found == signals.end() || found->second.empty() ? nullptr : &found->second;
}

Result<const Signal*> Recording::require(const std::string& name) const {
  if (const Signal* signal = find(name)) return signal;
  std::string list;
  for (const auto& n : signal_names()) list += (list.empty() ? "" : ", ") + n;
  return bad_input("the recording has no signal " + name, file, "It contains: " + list);
}

std::vector<std::string> Recording::signal_names() const {
  std::vector<std::string> names;
  for (const auto& [name, signal] : signals)
    if (!signal.empty()) names.push_back(name);
  return names;
}

bool Recording::lost_anything() const {
  return std::any_of(notes.begin(), notes.end(), [](const Note& n) {
    return n.kind == Note::Kind::loss || n.kind == Note::Kind::damage;
  });
}

void Recording::note(Note::Kind kind, std::string text, std::uint64_t messages, double from_s, double to_s) {
  notes.push_back({kind, std::move(text), messages, from_s, to_s});
}

Eigen::MatrixXd resample(const Signal& signal, const std::vector<double>& t_s, double max_gap_s) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Eigen::MatrixXd out = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(t_s.size()), signal.width(), nan);
  if (signal.empty()) return out;
  const bool attitude = is_attitude(signal.name) && signal.width() == 4;
  const auto quat = [&](Eigen::Index row) {
    const auto q = signal.values.row(row);
    return Quat(q(0), q(1), q(2), q(3));
  };
  std::size_t next = 0;  // first sample later than the wanted time; times usually increase, so this is O(n)
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    const double t = t_s[i];
    if (!(t >= signal.t_s.front() && t <= signal.t_s.back())) continue;
    if (next == 0 || signal.t_s[next - 1] > t || next >= signal.t_s.size() || signal.t_s[next] <= t) {
      // Usually the next sample or the one after; otherwise a binary search.
      if (next > 0 && next + 1 < signal.t_s.size() && signal.t_s[next] <= t && signal.t_s[next + 1] > t)
        ++next;
      else
        next = static_cast<std::size_t>(std::upper_bound(signal.t_s.begin(), signal.t_s.end(), t) -
                                        signal.t_s.begin());
    }
    const auto after = static_cast<Eigen::Index>(std::min(next, signal.t_s.size() - 1));
    const Eigen::Index before = static_cast<Eigen::Index>(next) - 1;
    const auto row = static_cast<Eigen::Index>(i);
    const double t0 = signal.t_s[static_cast<std::size_t>(before)];
    const double span = signal.t_s[static_cast<std::size_t>(after)] - t0;
    if (t == t0 || after == before) {
      out.row(row) = signal.values.row(before);
      continue;
    }
    if (span > max_gap_s) continue;
    const double u = (t - t0) / span;
    if (attitude) {
      const Quat q = quat(before).slerp(u, quat(after));
      out.row(row) << q.w(), q.x(), q.y(), q.z();
    } else {
      out.row(row) = (1 - u) * signal.values.row(before) + u * signal.values.row(after);
    }
  }
  return out;
}

Signal window(const Signal& signal, double from_s, double to_s) {
  Signal out = signal;
  const auto begin = std::lower_bound(signal.t_s.begin(), signal.t_s.end(), from_s);
  const auto end = std::max(begin, std::upper_bound(signal.t_s.begin(), signal.t_s.end(), to_s));
  out.t_s.assign(begin, end);
  out.values = signal.values.middleRows(begin - signal.t_s.begin(), end - begin);
  return out;
}

Signal rate_of_attitude(const Signal& attitude) {
  Signal out;
  out.name = "attitude_rate";
  out.unit = "rad/s";
  out.source = attitude.source;
  if (attitude.size() < 2 || attitude.width() != 4) return out;
  out.values.resize(attitude.size() - 1, 3);
  const auto quat = [&](Eigen::Index row) {
    const auto q = attitude.values.row(row);
    return Quat(q(0), q(1), q(2), q(3));
  };
  for (Eigen::Index i = 0; i + 1 < attitude.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double dt = attitude.t_s[k + 1] - attitude.t_s[k];
    out.t_s.push_back(attitude.t_s[k] + 0.5 * dt);
    out.values.row(i) = (log_rotation(quat(i).conjugate() * quat(i + 1)) / dt).transpose();
  }
  return out;
}

}  // namespace omniflight::recording
