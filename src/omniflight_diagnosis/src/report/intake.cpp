#include "intake.hpp"

#include <algorithm>

#include "../conditioning/analysis_scope.hpp"
#include "../sensor_checks/sensor_health.hpp"

namespace omniflight::diagnosis {

Intake describe(const recording::Recording& r, const Flight& f) {
  Intake out;
  out.recording = r.file;
  out.sensors = sensor_facts(r);
  out.missing = missing_signals(r);
  for (const auto& [name, s] : r.signals) {
    if (s.empty() || name.rfind("truth_", 0) == 0) continue;
    SignalInfo info{name, s.unit, static_cast<int>(s.size()), 0, 0};
    if (const double period = s.median_period_s(); period > 0) info.rate_hz = 1 / period;
    for (std::size_t i = 1; i < s.t_s.size(); ++i)
      info.longest_gap_s = std::max(info.longest_gap_s, s.t_s[i] - s.t_s[i - 1]);
    out.signals.push_back(info);
  }
  out.alignment = f.alignment;
  out.notes = f.notes;
  return out;
}

}  // namespace omniflight::diagnosis
