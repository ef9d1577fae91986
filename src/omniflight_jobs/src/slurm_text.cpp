#include "slurm_text.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>

namespace omniflight::jobs {
namespace {

std::vector<std::string> split(const std::string& line, char by) {
  std::vector<std::string> out;
  std::istringstream in(line);
  for (std::string word; std::getline(in, word, by);) {
    const auto first = word.find_first_not_of(" \t"), last = word.find_last_not_of(" \t\r");
    out.push_back(first == std::string::npos ? "" : word.substr(first, last - first + 1));
  }
  return out;
}

std::optional<std::size_t> whole(const std::string& text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// "key=value" words of a record.
std::map<std::string, std::string> fields(const std::string& record) {
  std::map<std::string, std::string> out;
  std::istringstream in(record);
  for (std::string word; in >> word;)
    if (const auto at = word.find('='); at != std::string::npos)
      out.try_emplace(word.substr(0, at), word.substr(at + 1));
  return out;
}

std::string ending(const std::string& state, const std::string& nodes, const std::string& code) {
  std::string out = state;
  if (!nodes.empty() && nodes != "None assigned" && nodes != "(null)") out += " on " + nodes;
  if (!code.empty() && code != "0:0") out += " (exit code:signal " + code + ")";
  return out;
}

}  // namespace

std::vector<QueuedTask> read_queue(const std::string& text) {
  std::vector<QueuedTask> out;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const auto words = split(line, '|');
    if (words.size() < 5) continue;
    const auto number = whole(words[0]), restarts = whole(words[4]);
    if (number)
      out.push_back({*number, words[1], words[2], words[3], static_cast<int>(restarts.value_or(0))});
  }
  return out;
}

Endings read_accounting(const std::string& text) {
  Endings out;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const auto words = split(line, '|');
    if (words.size() < 4) continue;
    const auto at = words[0].find('_');
    if (at == std::string::npos) continue;
    if (const auto task = whole(words[0].substr(at + 1))) out[*task] = ending(words[1], words[3], words[2]);
  }
  return out;
}

Endings read_jobs(const std::string& text) {
  Endings out;
  std::istringstream in(text);
  std::string record;
  const auto take = [&] {
    auto f = fields(record);
    record.clear();
    if (const auto task = whole(f["ArrayTaskId"]))
      out[*task] = ending(f["JobState"], f["NodeList"], f["ExitCode"]);
  };
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("JobId=", 0) == 0) take();
    record += line + "\n";
  }
  take();
  return out;
}

std::size_t largest_array(const std::string& config) {
  std::istringstream in(config);
  for (std::string line; std::getline(in, line);) {
    const auto words = split(line, '=');
    if (words.size() == 2 && words[0] == "MaxArraySize") return whole(words[1]).value_or(0);
  }
  return 0;
}

Error refusal(const std::string& said) {
  std::string line;
  std::istringstream in(said);
  for (std::string next; std::getline(in, next);) {
    const auto at = next.find("error: ");
    if (!next.empty())
      line += (line.empty() ? "" : "; ") + (at == std::string::npos ? next : next.substr(at + 7));
  }
  if (line.empty()) line = "sbatch gave no reason";
  std::string low = said;
  std::transform(low.begin(), low.end(), low.begin(), [](unsigned char c) { return std::tolower(c); });
  struct Rule {
    const char *words, *field, *next;
  };
  static constexpr Rule rules[] = {
      {"partition name", "--partition", "'sinfo' lists the partitions; leave it out for the default one"},
      {"no partition", "--partition", "Give --partition; 'sinfo' lists them"},
      {"account or account/partition", "--account",
       "'sacctmgr show associations user=$USER' lists the accounts"},
      {"invalid account", "--account", "'sacctmgr show associations user=$USER' lists the accounts"},
      {"time limit", "--time", "'sinfo --format=\"%P %l\"' lists the longest times; give less, in minutes"},
      {"array", "--jobs-per-task", "Give more jobs a task: fewer tasks"},
      {"max submit", "--jobs-per-task", "Give more jobs a task, or wait for other work of yours to end"},
      {"node count specification", "--cpus", "'sinfo --format=\"%P %c\"' lists processors a node"},
      {"requested node configuration", "--cpus", "'sinfo --format=\"%P %c\"' lists processors a node"},
      {"unable to contact", "--executor slurm", "See whether 'sinfo' answers; the controller may be down"},
      {"access/permission denied", "--executor slurm",
       "Ask the cluster's administrator for the right to submit"},
  };
  for (const Rule& rule : rules)
    if (low.find(rule.words) != std::string::npos)
      return {ErrorCode::bad_input, "the cluster refuses: " + line, rule.field, rule.next};
  return {ErrorCode::bad_input, "the cluster refuses: " + line, "--executor slurm",
          "The words are sbatch's own; see the cluster's documentation"};
}

Blocked blocked(const std::string& reason) {
  struct Rule {
    const char *reason, *message, *field, *next;
    double patience_s = 10;
  };
  static constexpr Rule rules[] = {
      {"PartitionTimeLimit", "the tasks would never start: they may take longer than the partition allows",
       "--time", "'sinfo --format=\"%P %l\"' lists the longest times; give less, in minutes"},
      {"PartitionNodeLimit", "the tasks would never start: they ask for more nodes than the partition allows",
       "--partition", "Give another partition"},
      {"BadConstraints", "the tasks would never start: no node has what they ask for", "--cpus",
       "'sinfo --format=\"%P %c\"' lists processors a node"},
      {"PartitionConfig", "the tasks do not start: no node of the partition has what they ask for", "--cpus",
       "'sinfo --format=\"%P %c %a\"' lists processors a node, and whether the partition is up", 120},
      {"InvalidAccount", "the tasks would never start: the account is not known", "--account",
       "'sacctmgr show associations user=$USER' lists the accounts"},
      {"InvalidQOS", "the tasks would never start: their quality of service is not allowed", "--account",
       "'sacctmgr show associations user=$USER' lists what is allowed"},
      {"AccountNotAllowed", "the tasks would never start: the partition is not for this account", "--account",
       "Give another --account or --partition"},
  };
  for (const Rule& rule : rules)
    if (reason == rule.reason)
      return {{ErrorCode::bad_input, std::string(rule.message) + " (" + reason + ")", rule.field, rule.next},
              rule.patience_s};
  return {};
}

bool is_held(const std::string& reason) {
  return reason.rfind("JobHeld", 0) == 0 || reason.find("held") != std::string::npos;
}

std::string shell_word(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace omniflight::jobs
