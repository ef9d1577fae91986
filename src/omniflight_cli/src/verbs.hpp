// Every verb of the command line: one file each, one line in main.cpp.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "command_line_names.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::cli {

/// Options that every verb has.
struct Common {
  bool json = false;      ///< result as JSON on stdout, everything else on stderr
  bool quiet = false;     ///< no progress, no summary
  std::string out;        ///< folder for results
  bool embedded = false;  ///< runs inside another verb, which goes on after it
};

/// What a verb does when it is chosen: the exit code, or an error.
using Action = std::function<Result<int>()>;
/// Registers a verb: description, options and what it does.
using AddVerb = Action (*)(CLI::App& verb, Common& common);

Action add_design(CLI::App& verb, Common& common);
Action add_plan(CLI::App& verb, Common& common);
Action add_fly(CLI::App& verb, Common& common);
Action add_compare(CLI::App& verb, Common& common);
Action add_diagnose(CLI::App& verb, Common& common);
Action add_identify_motor(CLI::App& verb, Common& common);
Action add_campaign(CLI::App& verb, Common& common);
Action add_effects(CLI::App& verb, Common& common);
Action add_vehicles(CLI::App& verb, Common& common);
Action add_info(CLI::App& verb, Common& common);
Action add_export(CLI::App& verb, Common& common);
Action add_import(CLI::App& verb, Common& common);
Action add_replay(CLI::App& verb, Common& common);
Action add_topic(CLI::App& verb, Common& common);
Action add_view(CLI::App& verb, Common& common);
Action add_completion(CLI::App& verb, Common& common);
Action add_man(CLI::App& verb, Common& common);
Action add_new(CLI::App& verb, Common& common);
Action add_prove(CLI::App& verb, Common& common);
Action add_reproduce(CLI::App& verb, Common& common);
Action add_estop(CLI::App& verb, Common& common);
Action add_replan(CLI::App& verb, Common& common);
Action add_arm(CLI::App& verb, Common& common);
Action add_keys(CLI::App& verb, Common& common);
Action add_doctor(CLI::App& verb, Common& common);

/// Refuses an option's number below zero (and zero itself when `zero` is false), saying so in words.
CLI::Validator not_negative(bool zero = true);
/// The option --map of every verb that opens foreign logs.
void add_map(CLI::App& verb, std::string& map);
/// Adds --axes, see ReadAs.
void add_axes(CLI::App& verb, std::string& axes);
/// Makes the folder; the error names it.
Status make_folder(const std::string& path);
/// Prints JSON on stdout when asked for.
void print_json(const Common& common, const nlohmann::json& value);
/// A line for people: stdout, or stderr under --json; nothing under --quiet.
void say(const Common& common, const std::string& line);
/// Full path of another omniflight program: beside this one, or in the neighbouring package of the workspace.
Result<std::string> find_program(const std::string& name);

}  // namespace omniflight::cli
