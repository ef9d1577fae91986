#include "csv_columns.hpp"

#include <charconv>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {
namespace {

/// Names with a letter a component, written around it: before + letter + after.
struct Lettered {
  const char* signal;
  const char* before;
  const char* letters;
  const char* after;
};
constexpr Lettered kLettered[] = {
    {"position", "p", "xyz", "_m"},
    {"attitude", "q", "wxyz", ""},
    {"velocity", "v", "xyz", "_mps"},
    {"gyro", "gyro_", "xyz", "_radps"},
    {"acc", "acc_", "xyz", "_mps2"},
    {"ref_position", "ref_p", "xyz", "_m"},
    {"ref_attitude", "ref_q", "wxyz", ""},
    {"ref_velocity", "ref_v", "xyz", "_mps"},
    {"ref_angular_velocity", "ref_w", "xyz", "_radps"},
    {"ref_acceleration", "ref_a", "xyz", "_mps2"},
    {"ref_angular_acceleration", "ref_dw", "xyz", "_radps2"},
};

/// Names with a rotor number: before + number + after.
struct Numbered {
  const char* signal;
  const char* before;
  const char* after;
};
constexpr Numbered kNumbered[] = {
    {"rotor_speed", "rotor", "_radps"},
    {"rotor_command", "rotor", "_cmd_radps"},
    {"pwm", "pwm", ""},
    {"thrust_command", "u", "_N"},
};

/// Names of single numbers.
struct Single {
  const char* signal;
  const char* column;
};
constexpr Single kSingle[] = {
    {"alpha", "alpha_rad"}, {"alpha_command", "alpha_cmd_rad"}, {"vbat", "vbat_V"}, {"ibat", "ibat_A"}};

/// before + middle + after == text; the middle is returned.
std::optional<std::string_view> between(std::string_view text, std::string_view before,
                                        std::string_view after) {
  if (text.size() < before.size() + after.size() + 1 || text.substr(0, before.size()) != before ||
      text.substr(text.size() - after.size()) != after)
    return std::nullopt;
  return text.substr(before.size(), text.size() - before.size() - after.size());
}

/// 1..99 without leading zero, as an index from 0.
std::optional<int> rotor_number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 1 || value > 99 || text[0] == '0')
    return std::nullopt;
  return value - 1;
}

}  // namespace

std::optional<ColumnPlace> place_of_column(std::string_view column) {
  for (const Single& s : kSingle)
    if (column == s.column) return ColumnPlace{s.signal, 0};
  for (const Lettered& l : kLettered) {
    const auto letter = between(column, l.before, l.after);
    if (!letter || letter->size() != 1) continue;
    const auto at = std::string_view(l.letters).find((*letter)[0]);
    if (at != std::string_view::npos) return ColumnPlace{l.signal, static_cast<int>(at)};
  }
  for (const Numbered& n : kNumbered)
    if (const auto middle = between(column, n.before, n.after))
      if (const auto number = rotor_number(*middle)) return ColumnPlace{n.signal, *number};
  const auto underscore = column.rfind('_');  // any other signal: name, or name_1 ... name_n
  if (underscore != std::string_view::npos) {
    const SignalSpec* spec = find_spec(column.substr(0, underscore));
    const auto number = rotor_number(column.substr(underscore + 1));
    if (spec && number && (spec->width == 0 || *number < spec->width))
      return ColumnPlace{spec->name, *number};
  }
  if (const SignalSpec* spec = find_spec(column); spec && spec->width == 1) return ColumnPlace{spec->name, 0};
  return std::nullopt;
}

std::string column_of(const std::string& signal, int component, int width) {
  for (const Single& s : kSingle)
    if (signal == s.signal) return s.column;
  for (const Lettered& l : kLettered)
    if (signal == l.signal) return std::string(l.before) + l.letters[component] + l.after;
  for (const Numbered& n : kNumbered)
    if (signal == n.signal) return n.before + std::to_string(component + 1) + n.after;
  return width == 1 ? signal : signal + "_" + std::to_string(component + 1);
}

}  // namespace omniflight::recording
