// `completion` and `man`: the command's own words for shells and man(1).
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

#include "command_words.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_vehicle/vehicle.hpp"
#include "verbs.hpp"
#include "version.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

/// Names that a user may write: of vehicles, missions, effects, sensors.
Result<std::vector<std::string>> names_of(const std::string& kind) {
  if (kind == "vehicles") return vehicle::vehicle_names();
  std::vector<std::string> out;
  if (kind == "effects") {
    for (const physics::Effect* e : physics::builtin_effects()) out.push_back(e->info().id);
    return out;
  }
  const auto configs = files::config_dir();
  if (!configs) return Failure(configs.error());
  std::error_code ec;
  for (const auto& entry : fs::directory_iterator(*configs / kind, ec))
    if (entry.path().extension() == ".yaml") out.push_back(entry.path().stem().string());
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

Action add_completion(CLI::App& verb, Common&) {
  struct CompletionOptions {
    std::string shell, kind;
  };
  auto o = std::make_shared<CompletionOptions>();
  verb.add_option("shell", o->shell, "bash | zsh | fish; words: the names that one of these scripts asks for")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish", "words"}));
  verb.add_option("kind", o->kind, "For words: vehicles | missions | effects | sensors")
      ->check(CLI::IsMember({"vehicles", "missions", "effects", "sensors"}));
  return [o, &verb]() -> Result<int> {
    if (o->shell != "words") {
      std::cout << completion_script(words_of(*verb.get_parent()), o->shell);
      return 0;
    }
    if (o->kind.empty())
      return bad_input("needs a kind of names", "completion words", "vehicles, missions, effects or sensors");
    const auto names = names_of(o->kind);
    if (!names) return Failure(names.error());
    for (const std::string& name : *names) std::cout << name << "\n";
    return 0;
  };
}

Action add_man(CLI::App& verb, Common& common) {
  return [&verb, &common]() -> Result<int> {
    const std::string out = common.out.empty() ? "man1" : common.out;
    if (auto ok = make_folder(out); !ok) return Failure(ok.error());
    const auto verbs = words_of(*verb.get_parent());
    if (auto ok = files::write_file_atomic(out + "/omniflight.1", manual_page(verbs, kVersion)); !ok)
      return Failure(ok.error());
    for (const VerbWords& v : verbs)
      if (auto ok = files::write_file_atomic(out + "/omniflight-" + v.name + ".1", manual_page(v, kVersion));
          !ok)
        return Failure(ok.error());
    say(common,
        std::to_string(verbs.size() + 1) + " pages in " + out + "; `man -l " + out + "/omniflight-fly.1`");
    print_json(common, {{"folder", out}, {"pages", verbs.size() + 1}});
    return 0;
  };
}

}  // namespace omniflight::cli
