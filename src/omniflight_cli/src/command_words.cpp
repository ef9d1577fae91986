#include "command_words.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

namespace omniflight::cli {
namespace {

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string out;
  for (const std::string& w : words) out += (out.empty() ? "" : between) + w;
  return out;
}

OptionWords words_of(const CLI::Option& option) {
  OptionWords out;
  out.does = option.get_description();
  out.positional = option.nonpositional() == false;
  out.takes_value = option.get_expected_max() > 0;
  for (const std::string& n : option.get_snames()) out.names.push_back("-" + n);
  for (const std::string& n : option.get_lnames()) out.names.push_back("--" + n);
  if (out.positional) out.names.push_back(option.get_single_name());
  return out;
}

}  // namespace

std::vector<VerbWords> words_of(const CLI::App& command) {
  std::vector<VerbWords> out;
  for (const CLI::App* verb : command.get_subcommands({})) {
    VerbWords v{verb->get_name(), verb->get_description(), verb->get_footer(), {}};
    constexpr std::string_view kExample = "Example: ";
    if (v.example.rfind(kExample, 0) == 0) v.example.erase(0, kExample.size());
    for (const CLI::Option* option : verb->get_options()) v.options.push_back(words_of(*option));
    out.push_back(std::move(v));
  }
  return out;
}

namespace {

/// What completes the value behind an option, and a verb's positionals: names that the command lists.
struct Named {
  const char *what, *kind;
};
constexpr Named kOptionValues[] = {
    {"--vehicle", "vehicles"}, {"--mission", "missions"}, {"--refly", "missions"}, {"--why", "effects"},
    {"--only", "effects"},     {"--exclude", "effects"},  {"--sensors", "sensors"}};
constexpr Named kVerbWords[] = {
    {"design", "vehicles"}, {"plan", "missions"}, {"fly", "missions"}, {"effects", "effects"}};

/// In single quotes, for any of the shells.
std::string quoted(const std::string& text, bool fish) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'')
      out += fish ? "\\'" : "'\\''";
    else if (c == '\\' && fish)
      out += "\\\\";
    else
      out += c == '\n' ? ' ' : c;
  }
  return out + "'";
}

std::string first_sentence(const std::string& text) {
  const auto end = text.find_first_of("\n;(");
  std::string out = text.substr(0, end);
  while (!out.empty() && (out.back() == ' ' || out.back() == ':')) out.pop_back();
  return out;
}

std::string bash(const std::vector<VerbWords>& verbs) {
  std::vector<std::string> names;
  for (const VerbWords& v : verbs) names.push_back(v.name);
  std::string out =
      "# bash completion of omniflight; made by `omniflight completion bash`\n"
      "_omniflight() {\n"
      "  local cur=\"${COMP_WORDS[COMP_CWORD]}\" prev=\"${COMP_WORDS[COMP_CWORD-1]}\" words=\"\" kind=\"\"\n"
      "  COMPREPLY=()\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      "    COMPREPLY=($(compgen -W \"" +
      joined(names, " ") + " --help --version\" -- \"$cur\"))\n    return\n  fi\n  case \"$prev\" in\n";
  for (const Named& n : kOptionValues) out += std::string("    ") + n.what + ") kind=" + n.kind + " ;;\n";
  out += "  esac\n  if [ -z \"$kind\" ]; then\n    case \"${COMP_WORDS[1]}\" in\n";
  for (const VerbWords& v : verbs) {
    std::vector<std::string> options;
    for (const OptionWords& o : v.options)
      if (!o.positional) options.insert(options.end(), o.names.begin(), o.names.end());
    out += "      " + v.name + ") words=\"" + joined(options, " ") + "\"";
    for (const Named& n : kVerbWords)
      if (v.name == n.what) out += std::string(" kind=") + n.kind;
    out += " ;;\n";
  }
  return out +
         "    esac\n  fi\n"
         "  case \"$cur\" in\n"
         "    -*) COMPREPLY=($(compgen -W \"$words\" -- \"$cur\")) ;;\n"
         "    *)\n"
         "      [ -z \"$kind\" ] || COMPREPLY=($(compgen -W \"$(omniflight completion words \"$kind\" "
         "2>/dev/null)\" -- \"$cur\"))\n"
         "      COMPREPLY+=($(compgen -f -- \"$cur\")) ;;\n"
         "  esac\n}\n"
         "complete -o filenames -F _omniflight omniflight\n";
}

/// Inside [...] of zsh's _arguments.
std::string zsh_text(const std::string& text) {
  std::string out;
  for (const char c : first_sentence(text)) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

std::string zsh(const std::vector<VerbWords>& verbs) {
  std::string out =
      "#compdef omniflight\n# zsh completion of omniflight; made by `omniflight completion zsh`\n"
      "_omniflight_names() {\n  local -a names\n  names=(${(f)\"$(omniflight completion words $1 "
      "2>/dev/null)\"})\n"
      "  compadd -a names\n  _files\n}\n"
      "_omniflight() {\n  local -a verbs\n  verbs=(\n";
  for (const VerbWords& v : verbs) out += "    " + quoted(v.name + ":" + zsh_text(v.does), false) + "\n";
  out +=
      "  )\n  if (( CURRENT == 2 )); then\n    _describe verb verbs\n    return\n  fi\n"
      "  local verb=$words[2]\n  shift words\n  (( CURRENT-- ))\n  case $verb in\n";
  for (const VerbWords& v : verbs) {
    out += "    " + v.name + ")\n      _arguments";
    for (const OptionWords& o : v.options) {
      if (o.positional) continue;
      for (const std::string& name : o.names) {
        std::string action = o.takes_value ? ":value:_files" : "";
        for (const Named& n : kOptionValues)
          if (name == n.what) action = std::string(":name:_omniflight_names ") + n.kind;
        out += " \\\n        " + quoted("*" + name + "[" + zsh_text(o.does) + "]" + action, false);
      }
    }
    std::string action = "_files";
    for (const Named& n : kVerbWords)
      if (v.name == n.what) action = std::string("_omniflight_names ") + n.kind;
    out += " \\\n        " + quoted("*:what:" + action, false) + " ;;\n";
  }
  return out +
         "  esac\n}\nif [ \"$funcstack[1]\" = _omniflight ]; then\n  _omniflight \"$@\"\nelse\n"
         "  compdef _omniflight omniflight\nfi\n";
}

std::string fish(const std::vector<VerbWords>& verbs) {
  std::string out = "# fish completion of omniflight; made by `omniflight completion fish`\n";
  for (const VerbWords& v : verbs) {
    out += "complete -c omniflight -n __fish_use_subcommand -f -a " + v.name + " -d " +
           quoted(first_sentence(v.does), true) + "\n";
    const std::string here = "complete -c omniflight -n '__fish_seen_subcommand_from " + v.name + "'";
    for (const Named& n : kVerbWords)
      if (v.name == n.what) out += here + " -a '(omniflight completion words " + n.kind + ")'\n";
    for (const OptionWords& o : v.options) {
      if (o.positional) continue;
      out += here;
      for (const std::string& name : o.names) {
        out += name.rfind("--", 0) == 0 ? " -l " + name.substr(2) : " -s " + name.substr(1);
        for (const Named& n : kOptionValues)
          if (name == n.what) out += std::string(" -f -a '(omniflight completion words ") + n.kind + ")'";
      }
      out += std::string(o.takes_value ? " -r" : "") + " -d " + quoted(first_sentence(o.does), true) + "\n";
    }
  }
  return out;
}

}  // namespace

std::string completion_script(const std::vector<VerbWords>& verbs, const std::string& shell) {
  return shell == "bash" ? bash(verbs) : shell == "zsh" ? zsh(verbs) : shell == "fish" ? fish(verbs) : "";
}

namespace {

/// Text of man(7): dashes that can be copied, no line that looks like a request.
std::string troff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '-')
      out += "\\-";
    else if (c == '\\')
      out += "\\e";
    else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
      out += std::string("\\&") + c;
    else
      out += c;
  }
  return out;
}

std::string head(const std::string& name, const std::string& does, const std::string& version) {
  std::string title = name;
  std::transform(title.begin(), title.end(), title.begin(), [](unsigned char c) { return std::toupper(c); });
  return ".TH \"" + troff(title) + "\" 1 \"\" \"" + troff(version) + "\" \"omniflight\"\n.SH NAME\n" +
         troff(name) + " \\- " + troff(does) + "\n";
}

constexpr const char* kEnd =
    ".SH EXIT STATUS\n0 done, 1 internal error, 2 the work ended without the wanted result, 3 proven "
    "impossible, "
    "4 bad input.\n";

}  // namespace

std::string manual_page(const VerbWords& verb, const std::string& version) {
  std::string out = head("omniflight-" + verb.name, verb.does, version) + ".SH SYNOPSIS\n.B omniflight " +
                    troff(verb.name) + "\n";
  for (const OptionWords& o : verb.options)
    if (o.positional) out += ".I " + troff(o.names.back()) + "\n";
  out += "[options]\n.SH OPTIONS\n";
  for (const OptionWords& o : verb.options)
    out += ".TP\n.B " + troff(joined(o.names, ", ")) +
           (o.takes_value && !o.positional ? " \\fIvalue\\fR" : "") + "\n" + troff(o.does) + "\n";
  return out + ".SH EXAMPLE\n.nf\n" + troff(verb.example) + "\n.fi\n" + kEnd +
         ".SH SEE ALSO\n.BR omniflight (1)\n";
}

std::string manual_page(const std::vector<VerbWords>& verbs, const std::string& version) {
  std::string out =
      head("omniflight", "plan, fly, record, and find the physics that simulation left out", version) +
      ".SH SYNOPSIS\n.B omniflight\n.I verb\n[options]\n.SH VERBS\n";
  for (const VerbWords& v : verbs)
    out += ".TP\n.BR omniflight\\-" + troff(v.name) + " (1)\n" + troff(v.does) + "\n";
  return out + kEnd;
}

}  // namespace omniflight::cli
