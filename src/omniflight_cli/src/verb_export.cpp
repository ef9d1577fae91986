// `export` and `import`: recordings from and to other formats.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>

#include "folder.hpp"
#include "load_all.hpp"
#include "mcap_export.hpp"
#include "omniflight_recording/formats.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

/// What a CSV cannot hold of an MCAP file: whole topics.
std::vector<std::string> without_columns(const recording::Recording& r) {
  std::vector<std::string> out;
  for (const auto& note : r.notes)
    if (note.text.rfind("topic ", 0) == 0) out.push_back(note.text);
  return out;
}

Result<int> write(const std::string& in, const ReadAs& as, const std::string& format, bool force,
                  const Common& common) {
  if (common.out.empty())
    return bad_input("needs a file to write", "--out", "For instance --out flight." + format);
  std::error_code ec;
  if (std::filesystem::equivalent(in, common.out, ec))
    return bad_input("is the recording itself", "--out " + common.out, "Choose another --out");
  if (format != "rosbag2")  // a folder is never overwritten, see write_rosbag2
    if (auto ok = refuse_overwriting(common.out, force); !ok) return Failure(ok.error());
  auto r = load_as(in, as);
  if (!r) return Failure(r.error());
  nlohmann::json j{{"written", common.out}, {"format", format}, {"read_as", r->format}};
  j["notes"] = nlohmann::json::array();
  for (const auto& note : r->notes) {
    j["notes"].push_back(note.text);
    say(common, "note: " + note.text);
  }
  if (format == "csv") {
    if (auto ok = recording::write_csv(*r, common.out); !ok) return Failure(ok.error());
    j["left_out"] = without_columns(*r);
  } else {
    auto done = format == "mcap" ? write_mcap(*r, common.out) : write_rosbag2(*r, common.out);
    if (!done) return Failure(done.error());
    j["messages"] = done->messages;
    j["left_out"] = done->left_out;
    for (const auto& [topic, count] : done->messages)
      say(common, fmt::format("  {:26} {:8} messages", topic, count));
    for (const std::string& name : done->left_out) say(common, "  no topic carries " + name + ": left out");
  }
  say(common, "written: " + common.out);
  print_json(common, j);
  return 0;
}

}  // namespace

Action add_export(CLI::App& verb, Common& common) {
  auto file = std::make_shared<std::string>();
  auto format = std::make_shared<std::string>("csv");
  verb.add_option("recording", *file, "Any supported log")->required();
  verb.add_option("--to", *format, "csv | mcap | rosbag2 (a folder)")
      ->check(CLI::IsMember({"csv", "mcap", "rosbag2"}));
  auto force = std::make_shared<bool>(false);
  verb.add_flag("--force", *force, "Overwrite the file that --out names (not a folder)");
  return [file, format, force, &common] { return write(*file, {}, *format, *force, common); };
}

Action add_import(CLI::App& verb, Common& common) {
  auto file = std::make_shared<std::string>();
  auto as = std::make_shared<ReadAs>();
  verb.add_option("log", *file, "Log of another system, recognised by its content")->required();
  add_map(verb, as->map);
  add_axes(verb, as->axes);
  auto force = std::make_shared<bool>(false);
  verb.add_flag("--force", *force, "Overwrite the file that --out names");
  return [file, as, force, &common]() -> Result<int> {
    const std::string kind = std::filesystem::path(common.out).extension() == ".csv" ? "csv" : "mcap";
    return write(*file, *as, kind, *force, common);
  };
}

}  // namespace omniflight::cli
