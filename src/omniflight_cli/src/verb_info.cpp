// `info`: looking into recordings.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "load_all.hpp"
#include "log_sources.hpp"
#include "omniflight_recording/formats.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

void tell(const recording::Recording& r, const Common& common) {
  say(common, fmt::format("{}: {}, {:.2f} s, sha256 {}", r.file, r.format, r.duration_s, r.sha256));
  for (const auto& [name, s] : r.signals)
    say(common,
        fmt::format("  {:22} {:8} samples x {}  [{}]  from {}", name, s.size(), s.width(), s.unit, s.source));
  if (r.signals.empty() && !r.topics.empty())
    say(common, "  no topic gives a signal; a map says which do (--map, configs/topic_maps)");
  for (const std::string& line : topic_lines(r)) say(common, "  " + line);
  for (const std::string& line : vehicle_lines(r)) say(common, "  vehicle: " + line);
  if (!r.parameters.empty())
    say(common, fmt::format("  {} parameters of the autopilot (--json lists them)", r.parameters.size()));
  for (const auto& [key, value] : r.metadata) say(common, "  " + key + ": " + value);
  for (const auto& n : r.notes) say(common, "  note: " + n.text);
}

nlohmann::json as_json(const recording::Recording& r) {
  nlohmann::json signals = nlohmann::json::array(), notes = nlohmann::json::array();
  for (const auto& [name, s] : r.signals)
    signals.push_back({{"name", name},
                       {"unit", s.unit},
                       {"samples", s.size()},
                       {"components", s.width()},
                       {"source", s.source}});
  for (const auto& n : r.notes) notes.push_back(n.text);
  return {{"file", r.file},
          {"format", r.format},
          {"sha256", r.sha256},
          {"duration_s", r.duration_s},
          {"signals", signals},
          {"topics", topics_json(r)},
          {"vehicle", vehicle_json(r)},
          {"parameters", r.parameters},
          {"notes", notes},
          {"metadata", r.metadata}};
}

}  // namespace

Action add_info(CLI::App& verb, Common& common) {
  auto file = std::make_shared<std::string>();
  auto as = std::make_shared<ReadAs>();
  verb.add_option("recording", *file, "Any supported log")->required();
  add_map(verb, as->map);
  add_axes(verb, as->axes);
  return [file, as, &common]() -> Result<int> {
    const auto r = load_as(*file, *as);
    if (!r) return Failure(r.error());
    tell(*r, common);
    print_json(common, as_json(*r));
    return 0;
  };
}

}  // namespace omniflight::cli
