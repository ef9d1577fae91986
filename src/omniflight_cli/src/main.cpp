#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "motor_verbs.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_jobs/task.hpp"
#include "verbs.hpp"
#include "version.hpp"

namespace omniflight::cli {
namespace {

struct Verb {
  const char* name;
  const char* does;
  const char* example;
  AddVerb add;
};
constexpr Verb kVerbs[] = {
    {"design", "Feasible wrench sets of a vehicle",
     "omniflight design omnimorph --alpha 30 --alpha 45 --f-max 5.95", add_design},
    {"plan", "A certified 6D trajectory for a mission", "omniflight plan trajectory_2 --out plan", add_plan},
    {"fly", "Fly a mission over the bus and record it",
     "omniflight fly trajectory_2 --effects configs/effects/tether.yaml --out run", add_fly},
    {"replan", "Ask a flight for another mission: planned from the state to come, joined without a jump",
     "omniflight replan elsewhere.yaml", add_replan},
    {"estop", "Stop the rotors of every run on this machine now, and wait for the gate's answer",
     "omniflight estop", add_estop},
    {"arm", "Let a flight that waits for its operator start its rotors", "omniflight arm", add_arm},
    {"keys", "Keys, certificates and permissions for a secured bus (--secure)",
     "omniflight keys --out ~/omniflight_keys --days 90", add_keys},
    {"compare", "Two recordings side by side (tracking, power, control)",
     "omniflight compare simulated/flight.mcap real/flight.mcap --vehicle omnimorph --out cmp", add_compare},
    {"diagnose", "Where model and recording differ, and which physics was left out",
     "omniflight diagnose flight.mcap --vehicle omnimorph --out diagnosis", add_diagnose},
    {"identify-motor", "Lag, delay and sampled models of the motors, from command and measured speed",
     "omniflight identify-motor a.bin b.bin --held-out c.bin --out motor", add_identify_motor},
    {"thrust-curve", "Thrust and torque over rotor speed, from sweeps of a thrust stand",
     "omniflight thrust-curve sweep.csv --thrust-unit g --out curve", add_thrust_curve},
    {"tune-motor", "Gains of the motors' speed loop from an identified model, with their margins",
     "omniflight tune-motor motor/motor.json --control-period-ms 2 --out gains", add_tune_motor},
    {"compare-runs", "How well rotors followed their commands, beside the best run so far (runs.csv)",
     "omniflight compare-runs flight.mcap --gains gains/gains.json", add_compare_runs},
    {"motor-bench", "A pseudo-random signal through gateway and boards (or emulated ones), recorded",
     "omniflight motor-bench --low 500 --high 620 --band-hz 9 --duration-s 30 --out bench", add_motor_bench},
    {"campaign", "Many flights with varied seeds, effects and gains",
     "omniflight campaign configs/campaigns/simulated.yaml --jobs 2 --out campaign", add_campaign},
    {"effects", "The library of left-out physics", "omniflight effects hung_cable", add_effects},
    {"vehicles", "Known vehicles", "omniflight vehicles", add_vehicles},
    {"info", "What is in a recording: signals, topics and the vehicle that wrote it",
     "omniflight info flight.ulg", add_info},
    {"import", "A log of another system, as MCAP (or CSV) with our topics",
     "omniflight import flight.ulg --out flight.mcap", add_import},
    {"export", "A recording in another format", "omniflight export flight.mcap --to csv --out flight.csv",
     add_export},
    {"replay", "A recording on the bus again", "omniflight replay flight.mcap --domain 7 --rate 2",
     add_replay},
    {"view", "A page that shows a flight in three dimensions, live or replayed, with a stop for its rotors",
     "omniflight view flight.mcap", add_view},
    {"topic", "What is said on the bus: list, echo, hz, record",
     "omniflight topic hz /omniflight/imu --domain 7", add_topic},
    {"new", "A new effect, vehicle, mission or map of a CSV to start from",
     "omniflight new vehicle my_quad --from flight.ulg --out here", add_new},
    {"prove", "Hidden effects on an independent plant: what does the diagnosis find?",
     "omniflight prove --cases 24 --nulls 24 --out proof", add_prove},
    {"reproduce", "The figures of the OmniMorph thesis beside ours, on one page",
     "omniflight reproduce 5.3 A.4 --out reproduction", add_reproduce},
    {"completion", "Completion of verbs, options and names for a shell",
     "omniflight completion bash > ~/.local/share/bash-completion/completions/omniflight", add_completion},
    {"man", "Manual pages of every verb, for man", "omniflight man --out man1", add_man},
    {"doctor", "Whether this machine can run everything", "omniflight doctor", add_doctor},
};

bool is_verb(const std::string& word) {
  return std::any_of(std::begin(kVerbs), std::end(kVerbs),
                     [&](const Verb& verb) { return word == verb.name; });
}

Error unknown_verb(const std::string& word) {
  std::vector<std::string> names;
  for (const Verb& verb : kVerbs) names.emplace_back(verb.name);
  const std::string near = files::nearest_word(word, names);
  return {ErrorCode::bad_input, "there is no verb " + files::shown(word), "omniflight",
          near.empty() ? "Run with --help for the verbs" : "Did you mean 'omniflight " + near + "'?"};
}

/// For the first option that the chosen verb does not know: the nearest one that it does.
std::string suggestion(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> known;
  for (const CLI::App* verb : app.get_subcommands({}))
    for (const CLI::Option* option : verb->get_options())
      if (argc > 1 && verb->get_name() == argv[1])
        for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (int i = 2; i < argc; ++i) {
    const std::string word = std::string(argv[i]).substr(0, std::string(argv[i]).find('='));
    if (word.rfind("--", 0) != 0 || std::find(known.begin(), known.end(), word) != known.end()) continue;
    const std::string near = files::nearest_word(word, known);
    if (!near.empty()) return ". Did you mean '" + near + "'?";
  }
  return ". Run with --help for the options and an example";
}

int run(int argc, char** argv) {
  CLI::App app("omniflight: plan, fly, record, and find the physics that simulation left out");
  app.require_subcommand(1);
  app.set_version_flag("--version", kVersion);
  app.failure_message([](const CLI::App*, const CLI::Error& e) {
    return std::string("omniflight: ") + e.what() + ". Run with --help for the options and an example\n";
  });
  Common common;
  std::vector<std::pair<CLI::App*, Action>> actions;
  for (const Verb& verb : kVerbs) {
    CLI::App* sub = app.add_subcommand(verb.name, verb.does);
    sub->footer(std::string("Example: ") + verb.example);
    sub->add_flag("--json", common.json, "Result as JSON on stdout, everything else on stderr");
    sub->add_flag("--quiet", common.quiet, "Neither progress nor summary");
    sub->add_option("--out", common.out, "Folder for the results");
    actions.emplace_back(sub, verb.add(*sub, common));
  }
  if (argc > 1)
    if (const std::string first = argv[1]; !first.empty() && first.front() != '-' && !is_verb(first)) {
      std::cerr << unknown_verb(first).text() << "\n";
      return static_cast<int>(ErrorCode::bad_input);
    }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ExtrasError& e) {
    std::cerr << "omniflight: " << e.what() << suggestion(app, argc, argv) << "\n";
    return static_cast<int>(ErrorCode::bad_input);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : static_cast<int>(ErrorCode::bad_input);
  }
  install_interrupt_handler();
  for (auto& [sub, action] : actions) {
    if (!sub->parsed()) continue;
    const auto result = action();
    if (result) return *result;
    std::cerr << "omniflight " << sub->get_name() << ": " << result.error().text() << "\n";
    if (common.json) std::cout << nlohmann::json{{"error", result.error().text()}}.dump() << "\n";
    return static_cast<int>(result.error().code);
  }
  return 0;
}

}  // namespace

CLI::Validator not_negative(bool zero) {
  return CLI::Validator(
      [zero](const std::string& text) -> std::string {
        double value = 0;
        if (!CLI::detail::lexical_cast(text, value)) return "'" + text + "' is not a number";
        if (value > 0 || (zero && value == 0)) return {};
        return "is " + text + (zero ? ", must not be negative" : ", must be more than 0");
      },
      zero ? "NONNEGATIVE" : "POSITIVE");
}

void add_map(CLI::App& verb, std::string& map) {
  verb.add_option(
      "--map", map,
      "YAML (or a name under configs/csv_maps or configs/topic_maps) that says which columns of a foreign "
      "CSV, "
      "or which topics of a bag or ULog, are which signals; without it the maps that fit are taken");
}

void add_axes(CLI::App& verb, std::string& axes) {
  verb.add_option("--axes", axes,
                  "Axes of the log: enu (world up, body forward-left-up; or as its map says), or ned "
                  "(north-east-down and "
                  "forward-right-down: every vector and attitude is turned)")
      ->check(CLI::IsMember({"enu", "ned"}))
      ->capture_default_str();
}

Status make_folder(const std::string& path) {
  std::error_code ec;
  std::filesystem::create_directories(path, ec);
  if (ec) return bad_input("cannot be made: " + ec.message(), path, "Choose another --out");
  return {};
}

void print_json(const Common& common, const nlohmann::json& value) {
  if (common.json) std::cout << value.dump(2) << std::endl;
}

void say(const Common& common, const std::string& line) {
  if (common.quiet) return;
  (common.json ? std::cerr : std::cout) << line << std::endl;
}

Result<std::string> find_program(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code ec;
  const fs::path here = fs::read_symlink("/proc/self/exe", ec).parent_path();
  std::vector<fs::path> folders{here};
  if (const char* told = std::getenv("OMNIFLIGHT_PROGRAMS"); told != nullptr && *told != '\0')
    folders.insert(folders.begin(), fs::path(told));
  for (const fs::path& folder :
       std::vector<fs::path>(folders))  // beside its package, in an installed workspace
    for (const char* package : {"omniflight_components", "omniflight_proof"})
      folders.push_back(folder.parent_path().parent_path() / package / "bin");
  for (const fs::path& folder : folders)
    if (fs::is_regular_file(folder / name, ec)) return (folder / name).string();
  return bad_input("the program " + name + " is neither beside this one nor in the workspace", here.string(),
                   "Build the package omniflight_components, or name its folder in OMNIFLIGHT_PROGRAMS");
}

}  // namespace omniflight::cli

int main(int argc, char** argv) {
  // how the task of a job array calls this program; no verb, since nobody types it
  if (argc == 4 && std::string(argv[1]) == "run-task")
    return omniflight::jobs::run_task_main(argv[2], argv[3]);
  return omniflight::cli::run(argc, argv);
}
