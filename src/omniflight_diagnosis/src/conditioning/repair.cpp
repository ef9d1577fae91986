#include "repair.hpp"

#include <algorithm>
#include <cmath>

#include "../numerics/log_factor.hpp"
#include "../numerics/text.hpp"
#include "analysis_scope.hpp"
#include "clocks.hpp"
#include "imu_place.hpp"
#include "omniflight_physics/effect_ids.hpp"
#include "repeats.hpp"
#include "sensor_noise.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

// Chosen. A freeze beyond one of the first two is a finding, a shorter one a note: motion capture that loses
// a marker for 0.4 s is common.
constexpr double kSubstantialFreeze = 0.6;  // s, longest single freeze
constexpr double kSubstantialShare = 0.1;   // of the flight
constexpr double kJoin = 0.2;               // s, clipped windows closer than this are joined
constexpr Eigen::Index kLeastCopies = 3;    // duplicated samples of a signal from which on it is mentioned

/// Groups of signals from one sensor or computer, which freeze together.
const std::vector<std::vector<const char*>>& senders() {
  static const std::vector<std::vector<const char*>> all{{"position", "attitude", "velocity"},
                                                         {"gyro", "acc"},
                                                         {"rotor_speed"},
                                                         {"est_position", "est_attitude", "est_velocity"}};
  return all;
}

Signal without(const Signal& s, const std::vector<char>& bad) {
  Signal out = s;
  Eigen::Index m = 0;
  out.t_s.clear();
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    if (bad[static_cast<std::size_t>(i)]) continue;
    out.values.row(m++) = s.values.row(i);
    out.t_s.push_back(s.t_s[static_cast<std::size_t>(i)]);
  }
  out.values.conservativeResize(m, Eigen::NoChange);
  return out;
}

/// Windows sorted, those closer than join_s [s] merged.
std::vector<Window> joined(std::vector<Window> windows, double join_s) {
  std::sort(windows.begin(), windows.end(),
            [](const Window& a, const Window& b) { return a.from_s < b.from_s; });
  std::vector<Window> out;
  for (const Window& w : windows)
    if (!out.empty() && w.from_s < out.back().to_s + join_s)
      out.back().to_s = std::max(out.back().to_s, w.to_s);
    else
      out.push_back(w);
  return out;
}

double length(const std::vector<Window>& windows) {
  double sum = 0;
  for (const Window& w : windows) sum += w.to_s - w.from_s;
  return sum;
}

/// "position and attitude"
std::string listed(const std::vector<std::string>& names) {
  std::string out;
  for (std::size_t k = 0; k < names.size(); ++k)
    out += (k == 0 ? "" : k + 1 == names.size() ? " and " : ", ") + names[k];
  return out;
}

void drop_copies(Repaired& r) {
  std::vector<std::string> names;
  for (auto& [name, s] : r.recording.signals) {
    const std::vector<Eigen::Index> copies = written_twice(s);
    if (copies.empty()) continue;
    std::vector<char> bad(s.t_s.size(), 0);
    for (const Eigen::Index i : copies) bad[static_cast<std::size_t>(i)] = 1;
    s = without(s, bad);
    if (static_cast<Eigen::Index>(copies.size()) >= kLeastCopies)
      names.push_back(format("%s (%zu)", name.c_str(), copies.size()));
  }
  for (const recording::Note& note : r.recording.notes)  // copies that the reader has dropped already
    if (const auto at = note.text.find(" samples repeat a time"); at != std::string::npos)
      if (const auto colon = note.text.find(": ");
          note.messages >= kLeastCopies && colon < at && !note.text.starts_with("truth_"))
        names.push_back(note.text.substr(0, colon) + " (" + std::to_string(note.messages) + ")");
  if (names.size() > 4) {
    names[3] = format("%zu more signals", names.size() - 3);
    names.resize(4);
  }
  if (!names.empty())
    r.notes.push_back("Samples were recorded twice and one of each was kept: " + listed(names) + ".");
}

/// Whether constant rotor speeds are commanded: the command is constant as well.
bool ordered(const Recording& r, const Signal& s, const Rows& run) {
  const Signal* command = s.name == "rotor_speed" ? r.find("rotor_command") : nullptr;
  if (!command) return false;
  // Relative range of a constant command; chosen: some motors quantise that coarsely
  constexpr double kStill = 0.01;
  const auto from = std::lower_bound(command->t_s.begin(), command->t_s.end(), time_of(s, run.begin)),
             to = std::upper_bound(from, command->t_s.end(), time_of(s, run.end - 1));
  const Eigen::MatrixXd asked =
      command->values.middleRows(from - command->t_s.begin(), std::distance(from, to));
  if (asked.rows() < 2 || !asked.allFinite()) return false;
  const Eigen::ArrayXd range = asked.colwise().maxCoeff() - asked.colwise().minCoeff();
  return (range <= kStill * asked.cwiseAbs().colwise().maxCoeff().transpose().array()).all();
}

void cut_freezes(Repaired& r) {
  for (const auto& sender : senders()) {
    std::vector<std::string> names;
    std::vector<Window> windows;
    double starts = -1e18;
    std::ptrdiff_t repeated = 0;  // samples of the signal that repeats most
    for (const char* name : sender) {
      const auto at = r.recording.signals.find(name);
      if (at == r.recording.signals.end()) continue;
      Signal& s = at->second;
      std::vector<Rows> runs = frozen(s, driven(r.recording, s));
      std::erase_if(runs, [&](const Rows& run) { return ordered(r.recording, s, run); });
      if (runs.empty()) continue;
      starts = std::max(starts, s.t_s.front());
      std::vector<char> bad(s.t_s.size(), 0);
      for (const Rows& run : runs) {
        windows.push_back({time_of(s, run.begin), time_of(s, std::min(run.end, s.size() - 1)), ""});
        std::fill(bad.begin() + run.begin + 1, bad.begin() + run.end, 1);
      }
      repeated = std::max(repeated, std::count(bad.begin(), bad.end(), 1));
      s = without(s, bad);
      names.emplace_back(name);
    }
    if (windows.empty()) continue;
    windows = joined(std::move(windows), 0.01);
    double longest = 0;
    for (Window& w : windows) {
      w.why = listed(names) + " frozen: the same sample again and again";
      r.frozen.push_back(w);
    }
    // constant from the first sample on: the sender had not started; a note, no finding
    const double first = windows.front().from_s <= starts ? windows.front().to_s : -1;
    if (first >= 0) {
      windows.erase(windows.begin());
      r.notes.push_back(format("The %s %s still up to %.2f s, from the first sample on; cut out.",
                               listed(names).c_str(), names.size() > 1 ? "stand" : "stands", first));
      if (windows.empty()) continue;
    }
    for (const Window& w : windows) longest = std::max(longest, w.to_s - w.from_s);
    const double share = length(windows) / std::max(1e-9, r.recording.duration_s);
    const bool several = names.size() > 1, again = windows.size() > 1;
    const std::string sentence =
        format("The %s %s in flight: the same %s repeated bit for bit for up to %.2f s, from %.2f s on",
               listed(names).c_str(), several ? "freeze" : "freezes", several ? "samples are" : "sample is",
               longest, windows.front().from_s) +
        (again ? format(" and %zu times in all (%.1f s)", windows.size(), length(windows)) : "") +
        "; cut out.";
    if (longest > kSubstantialFreeze || share > kSubstantialShare)
      r.faults.push_back({physics::effect_id::stale_samples, names.front(), sentence, share,
                          log_factor_of_repeats(repeated)});
    else
      r.notes.push_back(sentence);
  }
}

void cut_clipped(Repaired& r) {
  for (const auto& [name, unit] : {std::pair{"gyro", "rad/s"}, {"acc", "m/s2"}}) {
    const auto at = r.recording.signals.find(name);
    if (at == r.recording.signals.end()) continue;
    Signal& s = at->second;
    const Clipped c = clipped(s);
    if (c.runs.empty()) continue;
    std::vector<Window> windows;
    std::vector<char> bad(s.t_s.size(), 0);
    for (const Rows& run : c.runs) {
      windows.push_back({time_of(s, run.begin), time_of(s, run.end - 1), ""});
      std::fill(bad.begin() + run.begin, bad.begin() + run.end, 1);
    }
    s = without(s, bad);
    std::string limits;
    if (c.high != 0) limits += format("%.4g", c.high);
    if (c.low != 0) limits += format("%s%.4g", limits.empty() ? "" : " and ", c.low);
    r.notes.push_back(format("The %s is clipped at %s %s: %zu times, %.2f s in all; cut out.", name,
                             limits.c_str(), unit, c.runs.size(), length(windows)));
    for (Window& w : joined(std::move(windows), kJoin)) {
      w.why = format("%s clipped at %s %s", name, limits.c_str(), unit);
      r.clipped.push_back(w);
    }
  }
}

}  // namespace

Repaired as_it_is(const Recording& recording) {
  Repaired out;
  out.recording = recording;
  return out;
}

Repaired repaired(const Recording& recording) {
  Repaired out;
  Recording& r = out.recording;
  r = recording;
  std::erase_if(r.signals, [](const auto& s) { return s.first.rfind("truth_", 0) == 0; });
  for (const auto& [name, s] : r.signals)
    for (const recording::SignalSpec& spec : recording::canonical_signals())
      if (s.size() < 2 || !s.values.allFinite() ||
          (name == spec.name && spec.width > 0 && s.width() != spec.width))
        return out;  // validate_input() will say so
  drop_copies(out);
  cut_freezes(out);
  cut_clipped(out);
  settle_clocks(out);
  return out;
}

Repaired in_order(const Recording& recording, const Options& o) {
  Repaired out = scope_of(recording) == AnalysisScope::wrench ? repaired(recording) : as_it_is(recording);
  out.recording = at_origin(out.recording, o.imu_position);
  if (add_missing_noise(out.recording))
    out.notes.push_back(
        "The sensors record no noise: that of good ones was added (seed 1), so that errors of arithmetic are "
        "not taken for physics.");
  return out;
}

}  // namespace omniflight::diagnosis
