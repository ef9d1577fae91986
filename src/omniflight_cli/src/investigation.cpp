#include "investigation.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/mission.hpp"
#include "omniflight_recording/formats.hpp"
#include "verbs.hpp"
#include "verdict.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

std::string count(std::size_t flights) {
  return fmt::format("{} flight{}", flights, flights == 1 ? "" : "s");
}

/// The verb itself, as a user would call it.
Status diagnose(const std::vector<std::string>& recordings, const std::string& vehicle,
                const FlightOptions& o, const std::string& out) {
  Common common;
  common.quiet = true;
  common.embedded = true;
  common.out = out;
  CLI::App verb;
  const Action action = add_diagnose(verb, common);
  std::vector<std::string> arguments = recordings;
  arguments.insert(arguments.end(), {"--vehicle", vehicle});
  for (const std::string& field : o.set) arguments.insert(arguments.end(), {"--set", field});
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 takes them
  try {
    verb.parse(arguments);
  } catch (const CLI::ParseError& e) {
    return fail(ErrorCode::internal, e.what(), out);
  }
  if (auto code = action(); !code) return Failure(code.error());
  return {};
}

Result<Round> round_of(const std::string& folder) {
  const std::string path = folder + "/diagnosis.json";
  const auto text = files::read_file(path, 64 * files::kMegabyte);
  if (!text) return Failure(text.error());
  const auto j = nlohmann::json::parse(*text, nullptr, false);
  if (!j.is_object()) return bad_input("is no diagnosis", path);
  Round r;
  r.verdict = j.value("verdict", "");
  for (const auto& f : j.value("findings", nlohmann::json::array())) {
    r.findings.push_back({f.value("effect", "")});
    for (const auto& other : f.value("cannot_be_told_apart_from", nlohmann::json::array()))
      r.findings.back().push_back(other.get<std::string>());
  }
  if (fs::exists(folder + "/next_flight.yaml"))
    if (const auto& s = j["next_flight"]["predicted_separation_sigma"]; s.is_number())
      r.separation_sigma = s.get<double>();
  return r;
}

}  // namespace

bool Round::open() const {
  return std::any_of(findings.begin(), findings.end(), [](const auto& set) { return set.size() > 1; });
}

std::string Investigation::cause() const {
  if (rounds.empty() || rounds.back().open()) return {};
  std::string out;
  for (const auto& set : rounds.back().findings) out += (out.empty() ? "" : " and ") + set.front();
  return out;
}

nlohmann::json to_json(const Investigation& investigation) {
  nlohmann::json rounds = nlohmann::json::array();
  for (const Round& r : investigation.rounds)
    rounds.push_back({{"flight", r.flight},
                      {"verdict", r.verdict},
                      {"findings", r.findings},
                      {"predicted_separation_sigma", r.separation_sigma}});
  return {{"rounds", rounds}, {"ended", investigation.ended}};
}

std::string in_words(const Investigation& investigation) {
  std::string out;
  for (std::size_t k = 0; k < investigation.rounds.size(); ++k) {
    const Round& r = investigation.rounds[k];
    std::vector<std::string> sets;
    for (const auto& set : r.findings) sets.push_back(fmt::format("{}", fmt::join(set, " or ")));
    out += fmt::format("{}{} after {}", k ? "; " : "",
                       sets.empty() ? r.verdict : fmt::format("{}", fmt::join(sets, " and ")), count(k + 1));
  }
  return out + ": " + investigation.ended;
}

std::optional<nlohmann::json> flown_before(const FlightOptions& options) {
  const auto text = files::read_file(options.out + "/flight.json", files::kMegabyte);
  if (!text) return std::nullopt;
  const auto j = nlohmann::json::parse(*text, nullptr, false);
  const auto print = fingerprint(options);
  if (!print || !j.is_object() || j.value("schema", "") != "omniflight.flight/1" ||
      j.value("inputs_sha256", "") != *print || !j.value("complete", false))
    return std::nullopt;
  // the recording itself: the bytes that were judged, closed by their recorder, as long as was told
  const std::string file =
      options.out + "/" + fs::path(j.value("recording", "flight.mcap")).filename().string();
  const auto recording = recording::load(file, {});
  if (!recording) return std::nullopt;
  const auto closed = recording->metadata.find("mcap.closed");
  if (closed == recording->metadata.end() || closed->second != "yes" ||
      recording->sha256 != j.value("recording_sha256", "") ||
      !(std::abs(recording->duration_s - j.value("simulated_s", -1.0)) < 1e-6))
    return std::nullopt;
  return j;
}

Result<Investigation> investigate(const Case& flown, int most, bool keep) {
  const auto mission = planning::load_mission(flown.options.mission);
  if (!mission) return Failure(mission.error());
  const std::string vehicle = flown.options.vehicle.empty() ? mission->vehicle : flown.options.vehicle;
  std::vector<std::string> recordings{flown.options.out + "/flight.mcap"};
  Investigation out;
  for (int round = 0;; ++round) {
    const std::string folder = fmt::format("{}/diagnosis{}", flown.options.out, round + 1);
    if (auto ok = diagnose(recordings, vehicle, flown.options, folder); !ok) return Failure(ok.error());
    auto said = round_of(folder);
    if (!said) return Failure(said.error());
    said->flight = fs::path(recordings.back()).parent_path().filename().string();
    const bool open = said->open(), proposed = said->separation_sigma > 0;
    const bool same = !out.rounds.empty() && said->findings == out.rounds.back().findings;
    out.rounds.push_back(std::move(*said));
    if (interrupted())
      out.ended = "stopped";
    else if (!open)
      out.ended = out.rounds.back().findings.empty() ? "nothing is left to tell apart" : "one answer is left";
    else if (!proposed)
      out.ended = "no flight that fits the test bed would tell more";
    else if (same)
      out.ended = "the last flight told no more than those before";
    else if (round == most)
      out.ended = fmt::format("{} more were allowed", count(static_cast<std::size_t>(most)));
    if (!out.ended.empty()) return out;
    FlightOptions next = flown.options;
    next.mission = folder + "/next_flight.yaml";
    next.plan.clear();
    next.force = true;                                            // in the folder of this investigation
    next.seed += static_cast<std::uint64_t>(1000 * (round + 1));  // other noise
    next.out = fmt::format("{}/next{}", flown.options.out, round + 1);
    if (!(keep && flown_before(next))) {
      const auto result = fly(next);
      if (!result) return Failure(result.error());
      if (!result->complete || result->verdict == kLost) {
        out.ended = "the proposed flight was not flown to the end: " + result->reason;
        return out;
      }
    }
    recordings.push_back(next.out + "/flight.mcap");
  }
}

}  // namespace omniflight::cli
