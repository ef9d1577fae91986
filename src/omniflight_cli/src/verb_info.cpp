// `info`: looking into recordings.
#include <fmt/format.h>

#include "omniflight_recording/formats.hpp"
#include "verbs.hpp"

namespace omniflight::cli {

Action add_info(CLI::App& verb, Common& common) {
  auto file = std::make_shared<std::string>();
  verb.add_option("recording", *file, "Any supported log")->required();
  return [file, &common]() -> Result<int> {
    auto r = recording::load(*file, {});
    if (!r) return Failure(r.error());
    nlohmann::json signals = nlohmann::json::array(), notes = nlohmann::json::array();
    say(common, fmt::format("{}: {}, {:.2f} s, sha256 {}", r->file, r->format, r->duration_s, r->sha256));
    for (const auto& [name, s] : r->signals) {
      signals.push_back({{"name", name},
                         {"unit", s.unit},
                         {"samples", s.size()},
                         {"components", s.width()},
                         {"source", s.source}});
      say(common, fmt::format("  {:22} {:8} samples x {}  [{}]  from {}", name, s.size(), s.width(), s.unit,
                              s.source));
    }
    for (const auto& [key, value] : r->metadata) say(common, "  " + key + ": " + value);
    for (const auto& n : r->notes) {
      notes.push_back(n.text);
      say(common, "  note: " + n.text);
    }
    print_json(common, {{"file", r->file},
                        {"format", r->format},
                        {"sha256", r->sha256},
                        {"duration_s", r->duration_s},
                        {"signals", signals},
                        {"notes", notes},
                        {"metadata", r->metadata}});
    return 0;
  };
}

}  // namespace omniflight::cli
