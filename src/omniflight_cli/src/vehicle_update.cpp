#include "vehicle_update.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <regex>

#include "omniflight_files/files.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

/// Where the numbers behind `key:` stand, outside of comments.
std::vector<std::pair<std::size_t, std::size_t>> places(const std::string& text, const std::string& key) {
  std::vector<std::pair<std::size_t, std::size_t>> out;
  const std::regex pattern("(^|[ \\t{,\\n-])" + key + ":[ \\t]*([-+0-9.eE]+)");
  for (std::size_t line = 0; line < text.size();) {
    const std::size_t end = std::min(text.find('\n', line), text.size());
    const std::string part = text.substr(line, std::min(end, text.find('#', line)) - line);
    for (std::sregex_iterator it(part.begin(), part.end(), pattern), none; it != none; ++it)
      out.emplace_back(line + static_cast<std::size_t>(it->position(2)),
                       static_cast<std::size_t>(it->length(2)));
    line = end + 1;
  }
  return out;
}

std::string values_of(const RotorField& field) {
  std::string list;
  for (const double value : field.values) list += fmt::format("{}{:.4g}", list.empty() ? "" : ", ", value);
  return field.key + " " + list;
}

Status put_values(std::string& text, const RotorField& field, const std::string& file) {
  const auto at = places(text, field.key);
  if (at.size() != field.values.size())
    return bad_input(fmt::format("{} stands {} times in the file, {} rotors have one", field.key, at.size(),
                                 field.values.size()),
                     file, "Write by hand: " + values_of(field));
  for (std::size_t k = at.size(); k-- > 0;)
    if (std::isfinite(field.values[k]))
      text.replace(at[k].first, at[k].second, fmt::format("{:.4g}", field.values[k]));
  return {};
}

/// The line of the key under the block `provenance:`, new or in place of the old one.
Status put_provenance(std::string& text, const RotorField& field, const std::string& file) {
  std::string words = field.provenance;
  std::erase_if(words, [](char c) { return c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20; });
  const std::string line = "  " + field.key + ": \"" + words + "\"\n";
  if (text.empty() || text.back() != '\n') text += '\n';
  std::smatch found;
  if (!std::regex_search(text, found, std::regex("(^|\\n)provenance:([^\\n]*)\\n"))) {
    text += "provenance:\n" + line;
    return {};
  }
  const std::string behind = found.str(2);
  if (behind.find_first_not_of(" \t") != std::string::npos && behind[behind.find_first_not_of(" \t")] != '#')
    return bad_input("its provenance is not a block of lines", file, "Write by hand: " + values_of(field));
  const std::size_t begin = static_cast<std::size_t>(found.position(0) + found.length(0));
  for (std::size_t at = begin; at < text.size() && text[at] == ' ';) {
    const std::size_t end = text.find('\n', at) + 1;
    if (text.compare(at, field.key.size() + 3, "  " + field.key + ":") == 0) {
      text.replace(at, end - at, line);
      return {};
    }
    at = end;
  }
  text.insert(begin, line);
  return {};
}

}  // namespace

Result<std::string> update_vehicle(const std::string& name, const std::vector<RotorField>& fields) {
  const auto vehicle = vehicle::load_vehicle(name);
  if (!vehicle) return Failure(vehicle.error());
  auto text = files::read_file(vehicle->file, files::kMegabyte);
  if (!text) return Failure(text.error());
  for (const RotorField& field : fields) {
    if (static_cast<int>(field.values.size()) != vehicle->rotor_count())
      return bad_input(
          fmt::format("has {} rotors, the recordings {}", vehicle->rotor_count(), field.values.size()),
          vehicle->file, "Name the vehicle that flew");
    if (auto ok = put_values(*text, field, vehicle->file); !ok) return Failure(ok.error());
    if (auto ok = put_provenance(*text, field, vehicle->file); !ok) return Failure(ok.error());
  }
  // beside the old one, because a URDF is named relative to it
  const fs::path trial = fs::path(vehicle->file).concat(".new.yaml");
  if (auto ok = files::write_file_atomic(trial, *text); !ok) return Failure(ok.error());
  const auto checked = vehicle::load_vehicle(trial.string());
  std::error_code ec;
  fs::remove(trial, ec);
  if (!checked) return Failure(checked.error());
  if (auto ok = files::write_file_atomic(vehicle->file, *text); !ok) return Failure(ok.error());
  return vehicle->file;
}

}  // namespace omniflight::cli
