// `new effect|vehicle|mission|map NAME`: a file to start from, that works as it is.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <regex>

#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "omniflight_recording/map_draft.hpp"
#include "skeletons.hpp"
#include "vehicle_from_log.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

Status write_new(const fs::path& path, const std::string& text) {
  std::error_code ec;
  if (fs::exists(path, ec)) return bad_input("exists already", path.string(), "Choose another name");
  fs::create_directories(path.parent_path(), ec);
  if (ec)
    return bad_input("its folder cannot be made: " + ec.message(), path.string(), "Choose another --out");
  return files::write_file_atomic(path, text);
}

/// The file's text with a line put before `mark`.
Result<std::string> with_line(const fs::path& file, const std::string& line, const std::string& mark) {
  auto text = files::read_file(file, files::kMegabyte);
  if (!text) return text;
  const auto at = text->rfind(mark);
  if (at == std::string::npos)
    return bad_input("has no line '" + mark + "'", file.string(), "Add by hand: " + line);
  text->insert(at, line + "\n");
  return text;
}

/// The workspace that holds the sources: above the configuration folder.
Result<fs::path> workspace(const Common& common) {
  if (!common.out.empty()) return fs::path(common.out);
  auto configs = files::config_dir();
  if (!configs) return Failure(configs.error());
  return configs->parent_path();
}

/// The text of a vehicle file, of a log where one is given; what is from the log and what is made up is said.
Result<std::string> vehicle_text(const std::string& name, const std::string& log, const Common& common) {
  if (log.empty()) return vehicle_skeleton(name);
  const auto recording = recording::load(log, {});
  if (!recording) return Failure(recording.error());
  const auto draft = vehicle_from_log(name, *recording);
  if (!draft) return Failure(draft.error());
  for (const std::string& line : draft->told) say(common, "from the log: " + line);
  for (const std::string& line : draft->missing) say(common, "missing: " + line);
  return draft->yaml;
}

/// The text of a map for a CSV; what was guessed and what is not used is said.
Result<std::string> map_text(const std::string& name, const std::string& log, const Common& common) {
  if (log.empty())
    return bad_input("needs the CSV that it is for", "--from",
                     "For instance omniflight new map " + name + " --from flight.csv");
  const auto draft = recording::draft_csv_map(log);
  if (!draft) return Failure(draft.error());
  for (const std::string& line : draft->guessed) say(common, "guessed: " + line);
  for (const std::string& line : draft->unused) say(common, "not used: " + line);
  return draft->yaml;
}

Result<int> run(const std::string& kind, const std::string& name, const std::string& log,
                const Common& common) {
  if (!std::regex_match(name, std::regex("[a-z][a-z0-9_]{0,48}")))
    return bad_input("'" + name + "' is no name: small letters, digits and _ only, a letter first", "name",
                     "For instance my_" + kind);
  if (!log.empty() && kind != "vehicle" && kind != "map")
    return bad_input("is for a vehicle or a map", "--from",
                     "For instance omniflight new vehicle " + name + " --from " + log);
  auto root = workspace(common);
  if (!root) return Failure(root.error());
  std::vector<std::string> written;
  std::string next;
  if (kind == "effect") {
    const fs::path folder = *root / "src" / "omniflight_physics" / "src" / "effects";
    // both edits are made in memory before the first file is written
    auto header =
        with_line(folder / "table.hpp", "const Effect& " + name + "_effect();", "\n}  // namespace");
    if (!header) return Failure(header.error());
    auto table = with_line(folder / "table.cpp", "      &" + name + "_effect(),", "  };\n  return table;");
    if (!table) return Failure(table.error());
    if (auto ok = write_new(folder / (name + ".cpp"), effect_skeleton(name)); !ok) return Failure(ok.error());
    if (auto ok = files::write_file_atomic(folder / "table.hpp", *header); !ok) return Failure(ok.error());
    if (auto ok = files::write_file_atomic(folder / "table.cpp", *table); !ok) return Failure(ok.error());
    written = {(folder / (name + ".cpp")).string(), (folder / "table.hpp").string(),
               (folder / "table.cpp").string()};
    next = "write its equation, build omniflight_physics and run its tests; then `omniflight effects " +
           name + "`";
  } else if (kind == "vehicle") {
    const fs::path file = *root / "configs" / "vehicles" / name / (name + ".yaml");
    const auto text = vehicle_text(name, log, common);
    if (!text) return Failure(text.error());
    if (auto ok = write_new(file, *text); !ok) return Failure(ok.error());
    written = {file.string()};
    next = log.empty() ? "omniflight design " + file.string() + " --alpha 0"
                       : "put in what is missing, then omniflight diagnose " + log + " --vehicle " +
                             file.string() + " --check";
  } else if (kind == "map") {
    const fs::path file = *root / "configs" / "csv_maps" / (name + ".yaml");
    const auto text = map_text(name, log, common);
    if (!text) return Failure(text.error());
    if (auto ok = write_new(file, *text); !ok) return Failure(ok.error());
    written = {file.string()};
    next = "check every line, then omniflight info " + log + " --map " + file.string();
  } else {
    const fs::path file = *root / "configs" / "missions" / (name + ".yaml");
    if (auto ok = write_new(file, mission_skeleton(name)); !ok) return Failure(ok.error());
    written = {file.string()};
    next = "omniflight plan " + file.string();
  }
  for (const auto& file : written) say(common, "written: " + file);
  say(common, "next: " + next);
  print_json(common, {{"written", written}, {"next", next}});
  return 0;
}

}  // namespace

Action add_new(CLI::App& verb, Common& common) {
  auto kind = std::make_shared<std::string>();
  auto name = std::make_shared<std::string>();
  verb.add_option("kind", *kind, "effect | vehicle | mission | map")
      ->required()
      ->check(CLI::IsMember({"effect", "vehicle", "mission", "map"}));
  verb.add_option("name", *name, "Small letters, digits and _")->required();
  auto log = std::make_shared<std::string>();
  verb.add_option(
      "--from", *log,
      "Log that the vehicle wrote: rotor count, geometry and thrust as far as it tells them; for a map "
      "a CSV whose columns it is to name");
  return [kind, name, log, &common] { return run(*kind, *name, *log, common); };
}

}  // namespace omniflight::cli
