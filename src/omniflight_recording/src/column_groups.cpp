#include "column_groups.hpp"

#include <algorithm>
#include <cctype>
#include <map>

namespace omniflight::recording {
namespace {

constexpr const char* kUnits[] = {"s",     "ms",  "us",   "ns", "deg", "rad", "degps",
                                  "radps", "mps", "mps2", "g",  "rpm", "mv",  "m"};

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

std::string small(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return std::tolower(c); });
  return out;
}

/// Takes "[deg/s]" or "(deg/s)" off the end.
std::string take_bracket(std::string& name) {
  const auto open = name.find_last_of("[(");
  if (open == std::string::npos || open == 0 || (name.back() != ']' && name.back() != ')')) return {};
  std::string unit = name.substr(open + 1, name.size() - open - 2);
  if (unit.empty() || std::all_of(unit.begin(), unit.end(), is_digit)) return {};  // "motor[0]"
  name.resize(open);
  return unit;
}

std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> out(1);
  for (const char c : name) {
    if (is_letter(c) || is_digit(c))
      out.back() += c;
    else if (!out.back().empty())
      out.emplace_back();
  }
  if (out.back().empty()) out.pop_back();
  return out;
}

/// Takes the component off the last word: "x", "gyrox" (only behind known short words), "rpm1".
void take_component(ColumnName& name) {
  std::string& last = name.words.back();
  const auto digits = last.find_last_not_of("0123456789") + 1;
  if (digits < last.size() && last.size() - digits <= 2) {
    name.component = 'n';
    name.number = std::stoi(last.substr(digits));
    last.resize(digits);
  } else if (std::string_view("xyzw").find(last.back()) != std::string_view::npos) {
    name.component = last.back();
    last.pop_back();
  }
  if (last.empty()) name.words.pop_back();
}

}  // namespace

ColumnName parse_column_name(std::string_view text) {
  ColumnName out;
  std::string name = small(text);
  out.unit = take_bracket(name);
  out.words = words_of(name);
  if (out.words.empty()) return out;
  if (out.unit.empty() && out.words.size() > 1 &&
      std::find(std::begin(kUnits), std::end(kUnits), out.words.back()) != std::end(kUnits)) {
    out.unit = out.words.back();
    out.words.pop_back();
  }
  take_component(out);
  return out;
}

std::vector<ColumnGroup> group_columns(const std::vector<std::string>& header) {
  struct Members {
    std::map<char, int> letters;
    std::map<int, int> numbers;
  };
  std::map<std::pair<std::vector<std::string>, std::string>, Members> all;
  std::vector<ColumnGroup> out;
  for (int column = 0; column < static_cast<int>(header.size()); ++column) {
    const ColumnName name = parse_column_name(header[static_cast<std::size_t>(column)]);
    Members& members = all[{name.words, name.unit}];
    if (name.component == 'n')
      members.numbers.emplace(name.number, column);
    else
      members.letters.emplace(name.component, column);
  }
  for (const auto& [key, members] : all) {
    const auto add = [&](char kind, std::vector<int> columns) {
      out.push_back({key.first, key.second, std::move(columns), kind});
    };
    const auto& l = members.letters;
    if (l.count('x') && l.count('y') && l.count('z')) {
      if (l.count('w'))
        add('q', {l.at('w'), l.at('x'), l.at('y'), l.at('z')});
      else
        add('v', {l.at('x'), l.at('y'), l.at('z')});
    }
    if (l.count(0)) add('s', {l.at(0)});
    if (!members.numbers.empty()) {
      std::vector<int> columns;
      for (const auto& [number, column] : members.numbers) columns.push_back(column);
      add('n', std::move(columns));
    }
  }
  std::sort(out.begin(), out.end(),
            [](const ColumnGroup& a, const ColumnGroup& b) { return a.columns < b.columns; });
  return out;
}

}  // namespace omniflight::recording
