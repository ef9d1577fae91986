#include "intake_lines.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "log_sources.hpp"
#include "motor_order.hpp"

namespace omniflight::cli {

void say_intake(const Common& common, const diagnosis::Intake& in, const vehicle::Vehicle& vehicle,
                const std::vector<recording::Recording>& recordings) {
  const auto log = std::find_if(recordings.begin(), recordings.end(),
                                [&](const recording::Recording& r) { return r.file == in.recording; });
  const auto source_of = [&](const std::string& name) {
    const recording::Signal* s = log == recordings.end() ? nullptr : log->find(name);
    return s == nullptr || s->source.empty() ? "" : ", from " + s->source;
  };
  say(common, "  " + in.recording + ":");
  for (const auto& s : in.signals)
    say(common, fmt::format("  {:22} {:6} samples, {:.1f} Hz, longest gap {:.3f} s [{}]{}", s.name, s.samples,
                            s.rate_hz, s.longest_gap_s, s.unit, source_of(s.name)));
  if (log != recordings.end()) {
    for (const std::string& line : topic_lines(*log)) say(common, "  " + line);
    for (const std::string& line : vehicle_lines(*log)) say(common, "  vehicle: " + line);
    say(common, "  motors: " + to_text(judge_motor_order(*log, vehicle)));
    for (const recording::Note& n : log->notes) say(common, "  note: " + n.text);
  }
  for (const auto& a : in.alignment)
    say(common, fmt::format("  clock: {} comes {:.1f} ms (+-{:.1f}) after {}, drifts {:.0f} ppm "
                            "(+-{:.0f}), correlation {:.2f}",
                            a.late, 1e3 * a.lag_s, 1e3 * a.lag_se, a.early, 1e6 * a.skew, 1e6 * a.skew_se,
                            a.correlation));
  for (const auto& e : in.excitation)
    say(common, fmt::format("  moves: {:18} {:9.3g} to {:9.3g} {}, RMS {:.3g}", e.name, e.low, e.high, e.unit,
                            e.rms));
  for (const auto& f : in.sensors)
    say(common, fmt::format("  sensor: {:14} {:32} {:.4g} {}", f.signal, f.quantity, f.value, f.unit));
  for (const auto& m : in.missing) say(common, fmt::format("  missing: {}: {}", m.signal, m.costs));
}

}  // namespace omniflight::cli
