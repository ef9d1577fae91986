// The command's own words, read from its parser: for shell completion and manual pages.
#pragma once

#include <string>
#include <vector>

#include "command_line_names.hpp"

namespace omniflight::cli {

struct OptionWords {
  std::vector<std::string> names;  ///< with their dashes; the name alone of a positional
  std::string does;
  bool positional = false, takes_value = false;
};
struct VerbWords {
  std::string name, does, example;
  std::vector<OptionWords> options;
};

/// Every verb of the command, in the order of its table.
std::vector<VerbWords> words_of(const CLI::App& command);

/// A script that completes verbs, options and names in "bash", "zsh" or "fish"; empty for another shell.
std::string completion_script(const std::vector<VerbWords>& verbs, const std::string& shell);

/// A manual page in man(7): of a verb, or of the command itself.
std::string manual_page(const VerbWords& verb, const std::string& version);
std::string manual_page(const std::vector<VerbWords>& verbs, const std::string& version);

}  // namespace omniflight::cli
