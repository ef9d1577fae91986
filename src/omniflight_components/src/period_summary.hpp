// What a clock master in real time says of its periods: in words, in a message, and in a file for whoever
// started it.
#pragma once

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "omniflight_bus/message.hpp"
#include "omniflight_files/files.hpp"
#include "silence_log.hpp"

namespace omniflight::components {

struct PeriodCounts {
  std::uint64_t periods = 0;           ///< since the motors run
  std::uint64_t missed = 0;            ///< of them
  double latest_s = 0;                 ///< s, the longest that one began late
  std::uint64_t commands_refused = 0;  ///< by the gate
  std::uint64_t page_faults = 0;       ///< of the loop's thread, from arming to the end of the loop
};

inline std::string words(const PeriodCounts& c) {
  return fmt::format(
      "{} of {} control periods missed, the latest {:.1f} ms late; {} commands refused, {} page faults",
      c.missed, c.periods, 1e3 * c.latest_s, c.commands_refused, c.page_faults);
}

/// Key and value pairs of a diagnostic status.
template <class Values>
void fill(Values& values, const PeriodCounts& c) {
  bus::resize(values, 5);
  auto pairs = bus::view(values);
  const std::pair<const char*, std::string> said[] = {
      {"periods", std::to_string(c.periods)},
      {"periods_missed", std::to_string(c.missed)},
      {"latest_ms", fmt::format("{:.3f}", 1e3 * c.latest_s)},
      {"commands_refused", std::to_string(c.commands_refused)},
      {"page_faults", std::to_string(c.page_faults)}};
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    bus::set_text(pairs[k].key, said[k].first);
    bus::set_text(pairs[k].value, said[k].second);
  }
}

/// Nothing without a file.
inline Status write_summary(const PeriodCounts& c, const std::vector<Silence>& silences,
                            const std::string& file) {
  if (file.empty()) return {};
  nlohmann::json silent = nlohmann::json::array();
  for (const Silence& s : silences)
    silent.push_back({{"component", s.who}, {"at_s", s.at_s}, {"for_s", s.for_s}, {"back", s.back}});
  const nlohmann::json j = {{"schema", "omniflight.periods/1"},
                            {"periods", c.periods},
                            {"periods_missed", c.missed},
                            {"latest_ms", 1e3 * c.latest_s},
                            {"commands_refused", c.commands_refused},
                            {"page_faults", c.page_faults},
                            {"silent", silent}};
  return files::write_file_atomic(file, j.dump(2) + "\n");
}

}  // namespace omniflight::components
