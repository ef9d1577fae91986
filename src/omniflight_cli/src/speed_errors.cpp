#include "speed_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>

#include "omniflight_files/files.hpp"

namespace omniflight::cli {
namespace {

constexpr std::size_t kFixedColumns = 8, kMostRows = 100'000;

std::string header(std::size_t rotors) {
  std::string out = "time,log,kp,ki,kd,n,better,mean_error_radps";
  for (std::size_t k = 1; k <= rotors; ++k) out += fmt::format(",rotor{}_mean_radps,rotor{}_max_radps", k, k);
  return out;
}

std::string cell(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : ""; }

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> out(1);
  for (const char c : line)
    if (c == ',')
      out.emplace_back();
    else if (c != '\r')
      out.back() += c;
  return out;
}

/// A finite number, or NaN for an empty cell; nothing for anything else.
std::optional<double> number(const std::string& text) {
  if (text.empty()) return std::nan("");
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end != text.c_str() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

double SpeedErrors::overall() const {
  double sum = 0;
  for (const double m : mean) sum += m;
  return mean.empty() ? std::nan("") : sum / static_cast<double>(mean.size());
}

Result<SpeedErrors> speed_errors(const recording::Recording& r) {
  const auto command = r.require("rotor_command");
  if (!command) return Failure(command.error());
  const auto speed = r.require("rotor_speed");
  if (!speed) return Failure(speed.error());
  const recording::Signal &c = **command, &s = **speed;
  if (c.width() != s.width())
    return bad_input(fmt::format("has {} commands and {} speeds", c.width(), s.width()), r.file,
                     "Map them (--map)");
  SpeedErrors out;
  for (Eigen::Index k = 0; k < s.width(); ++k) {
    double sum = 0, most = 0;
    Eigen::Index count = 0;
    std::size_t at = 0;
    for (Eigen::Index i = 0; i < s.size(); ++i) {
      const double t = s.t_s[static_cast<std::size_t>(i)];
      if (t < c.t_s.front()) continue;
      while (at + 1 < c.t_s.size() && c.t_s[at + 1] <= t) ++at;
      const double wanted = c.values(static_cast<Eigen::Index>(at), k);
      if (wanted == 0) continue;
      const double error = std::abs(std::abs(wanted) - std::abs(s.values(i, k)));
      sum += error;
      most = std::max(most, error);
      ++count;
    }
    if (count == 0)
      return bad_input(fmt::format("rotor {} is never commanded to turn", k + 1), r.file,
                       "Choose another run");
    out.mean.push_back(sum / static_cast<double>(count));
    out.max.push_back(most);
  }
  return out;
}

std::string now_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

Result<std::vector<RunRow>> read_runs(const std::string& file) {
  std::vector<RunRow> rows;
  std::error_code ec;
  if (!std::filesystem::exists(file, ec)) return rows;
  const auto text = files::read_file(file, 64 * files::kMegabyte);
  if (!text) return Failure(text.error());
  std::size_t rotors = 0;
  int line_number = 0;
  for (std::size_t at = 0; at < text->size();) {
    const std::size_t end = std::min(text->find('\n', at), text->size());
    const std::string line = text->substr(at, end - at);
    at = end + 1;
    ++line_number;
    const std::string where = file + ":" + std::to_string(line_number);
    const auto cells = split(line);
    if (line_number == 1) {
      rotors = cells.size() < kFixedColumns ? 0 : (cells.size() - kFixedColumns) / 2;
      if (rotors == 0 || rotors > 16 || split(header(rotors)) != cells)
        return bad_input("has other columns than compare-runs writes", where, "Choose another --runs");
      continue;
    }
    if (cells.size() != kFixedColumns + 2 * rotors || rows.size() >= kMostRows)
      return bad_input(
          fmt::format("has {} columns, the first line {}", cells.size(), kFixedColumns + 2 * rotors), where,
          "Mend or remove the line");
    std::vector<double> numbers;
    for (std::size_t k = 2; k < cells.size(); ++k) {
      if (k == 6) continue;
      const auto value = number(cells[k]);
      if (!value || (k > 6 && !std::isfinite(*value)))
        return bad_input(files::shown(cells[k]) + " is no number", where, "Mend or remove the line");
      numbers.push_back(*value);
    }
    RunRow row{cells[0], cells[1], {numbers[0], numbers[1], numbers[2], numbers[3]}, {}};
    for (std::size_t k = 0; k < rotors; ++k) {
      row.errors.mean.push_back(numbers[5 + 2 * k]);
      row.errors.max.push_back(numbers[6 + 2 * k]);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

Status write_runs(const std::string& file, const std::vector<RunRow>& rows) {
  if (rows.empty()) return {};
  std::string text = header(rows.front().errors.mean.size()) + "\n";
  double best = std::numeric_limits<double>::infinity();
  for (const RunRow& row : rows) {
    const double mean = row.errors.overall();
    std::string log = row.log;
    std::replace_if(
        log.begin(), log.end(), [](char c) { return c == ',' || static_cast<unsigned char>(c) < 0x20; }, '_');
    text += fmt::format("{},{},{},{},{},{},{},{:.6g}", row.time, log, cell(row.gains.kp), cell(row.gains.ki),
                        cell(row.gains.kd), cell(row.gains.n), mean < best ? "yes" : "no", mean);
    for (std::size_t k = 0; k < row.errors.mean.size(); ++k)
      text += fmt::format(",{:.6g},{:.6g}", row.errors.mean[k], row.errors.max[k]);
    text += "\n";
    best = std::min(best, mean);
  }
  return files::write_file_atomic(file, text);
}

std::optional<std::size_t> best_run(const std::vector<RunRow>& rows) {
  if (rows.empty()) return std::nullopt;
  const auto best = std::min_element(rows.begin(), rows.end(), [](const RunRow& a, const RunRow& b) {
    return a.errors.overall() < b.errors.overall();
  });
  return static_cast<std::size_t>(best - rows.begin());
}

}  // namespace omniflight::cli
