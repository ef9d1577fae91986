#include "omniflight_identification/bench_sweep.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

namespace omniflight::identification {
namespace {

constexpr double kRpm = 3.14159265358979323846 / 30.0;
constexpr double kGram = 9.80665e-3;  // N
constexpr std::size_t kMostRows = 200'000, kMostColumns = 200;
constexpr double kTurning = 0.1;      // of the fastest row
constexpr double kApart = 1.0 / 3.0;  // speeds of rotors in one row

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t' || s.front() == '"')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t' || s.back() == '"' || s.back() == '\r'))
    s.remove_suffix(1);
  return s;
}

std::vector<std::string_view> cells(std::string_view line, char separator) {
  std::vector<std::string_view> out;
  for (;;) {
    const std::size_t at = line.find(separator);
    out.push_back(trimmed(line.substr(0, at)));
    if (at == std::string_view::npos || out.size() > kMostColumns) return out;
    line.remove_prefix(at + 1);
  }
}

struct Heading {
  std::string name, unit;  ///< lower case
};
Heading heading(std::string_view text) {
  std::string low(text);
  std::transform(low.begin(), low.end(), low.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::size_t open = low.find_first_of("[("), close = low.find_last_of("])");
  if (open == std::string::npos || close == std::string::npos || close < open) return {low, ""};
  return {std::string(trimmed(std::string_view(low).substr(0, open))),
          low.substr(open + 1, close - open - 1)};
}

/// Newtons per unit; nothing for a unit that is no force.
std::optional<double> newtons(const std::string& unit) {
  if (unit == "n") return 1.0;
  if (unit == "g" || unit == "gf") return kGram;
  if (unit == "kg" || unit == "kgf") return 1000 * kGram;
  return std::nullopt;
}

bool is_torque_unit(const std::string& unit) {
  return unit == "nm" || unit == "n m" || unit == "n*m" || unit == "n\xc2\xb7m" || unit == "n.m";
}

struct Columns {
  std::vector<std::size_t> speed;
  std::optional<std::size_t> thrust, torque, time;
  double newton = 1.0;
};

Result<Columns> find_columns(const std::vector<std::string_view>& names, const std::string& file,
                             const SweepOptions& options) {
  Columns out;
  std::optional<std::size_t> electrical, optical;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const Heading h = heading(names[k]);
    if (h.name.rfind("rpm", 0) == 0)
      out.speed.push_back(k);
    else if (h.name.find("speed") != std::string::npos && h.unit == "rpm")
      (h.name.find("optical") != std::string::npos ? optical : electrical) = k;
    else if (!out.thrust && (h.name == "thrust" || h.name == "weight")) {
      std::string unit = h.unit.empty() ? options.thrust_unit : h.unit;
      std::transform(unit.begin(), unit.end(), unit.begin(), [](unsigned char c) { return std::tolower(c); });
      const auto factor = newtons(unit);
      if (!factor)
        return bad_input(
            "column '" + std::string(names[k]).substr(0, 60) +
                (unit.empty() ? "' has no unit" : "' has a unit that is no force (N, g, gf, kg)"),
            file + ":1", "Name its unit with --thrust-unit");
      out.thrust = k;
      out.newton = *factor;
    } else if (!out.torque && h.name == "torque" && is_torque_unit(h.unit))
      out.torque = k;
    else if (!out.time && h.name == "time" && h.unit == "s")
      out.time = k;
  }
  if (out.speed.empty() && (electrical || optical)) out.speed.push_back(electrical ? *electrical : *optical);
  if (out.speed.empty())
    return bad_input("has no column of rotor speed (rpm, rpm1, ..., or 'speed (RPM)')", file + ":1",
                     "Record the speed, or name its column so");
  if (!out.thrust)
    return bad_input("has no column of thrust ('thrust (N)' or 'weight[g]')", file + ":1",
                     "Record the thrust, or name its column so");
  return out;
}

std::optional<double> value(const std::vector<std::string_view>& row, std::size_t k) {
  if (k >= row.size() || row[k].empty()) return std::nullopt;
  double number = 0;
  const auto [end, error] = std::from_chars(row[k].data(), row[k].data() + row[k].size(), number);
  if (error != std::errc() || end != row[k].data() + row[k].size() || !std::isfinite(number))
    return std::nullopt;
  return number;
}

/// Rows of numbers: speeds [rad/s], thrust [N], torque [Nm], time [s]; NaN where a column is absent.
struct Rows {
  std::vector<std::vector<double>> kept;
  Eigen::Index dropped = 0;
};
Result<Rows> read_rows(std::string_view text, char separator, const Columns& c, const std::string& file) {
  Rows out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) continue;
    if (out.kept.size() >= kMostRows) return bad_input("has more than 200000 rows", file, "Cut it");
    const auto row = cells(line, separator);
    std::vector<double> numbers;
    bool whole = true;
    for (const std::size_t k : c.speed) {
      const auto v = value(row, k);
      whole = whole && v;
      numbers.push_back(v ? kRpm * std::abs(*v) : 0);
    }
    const auto thrust = value(row, *c.thrust);
    const auto torque = c.torque ? value(row, *c.torque) : std::nullopt;
    const auto time = c.time ? value(row, *c.time) : std::nullopt;
    whole = whole && thrust && (!c.torque || torque);
    if (!whole) {
      ++out.dropped;
      continue;
    }
    numbers.insert(numbers.end(),
                   {c.newton * *thrust, torque.value_or(std::nan("")), time.value_or(std::nan(""))});
    out.kept.push_back(std::move(numbers));
  }
  return out;
}

/// Positive where a stand counts a push as negative.
Eigen::VectorXd upright(const Eigen::VectorXd& x) { return x.mean() < 0 ? Eigen::VectorXd(-x) : x; }

}  // namespace

Result<BenchSweep> read_sweep(std::string_view text, const std::string& file, const SweepOptions& options) {
  if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view header = text.substr(0, end);
  const char separator =
      std::count(header.begin(), header.end(), ';') > std::count(header.begin(), header.end(), ',') ? ';'
                                                                                                    : ',';
  const auto columns = find_columns(cells(header, separator), file, options);
  if (!columns) return Failure(columns.error());
  text.remove_prefix(std::min(end + 1, text.size()));
  auto rows = read_rows(text, separator, *columns, file);
  if (!rows) return Failure(rows.error());

  const std::size_t rotors = columns->speed.size();
  double fastest = 0;
  for (const auto& row : rows->kept)
    fastest =
        std::max(fastest, *std::max_element(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(rotors)));
  Eigen::Index apart = 0;
  std::erase_if(rows->kept, [&](const std::vector<double>& row) {
    const auto [low, high] =
        std::minmax_element(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(rotors));
    const bool turns = *high > kTurning * fastest, differ = *high - *low > kApart * *high;
    apart += turns && differ;
    rows->dropped += !turns || differ;
    return !turns || differ;
  });
  const auto n = static_cast<Eigen::Index>(rows->kept.size());
  if (n < 5)
    return bad_input("has " + std::to_string(n) + " usable rows of speed and thrust, at least 5 are needed" +
                         (apart > 0 ? "; in " + std::to_string(apart) +
                                          " rows the rotors' speeds differ by more than a third or one stands"
                                    : ""),
                     file, "Look at the speed columns, sweep more steps");
  BenchSweep out;
  out.file = file;
  out.dropped = rows->dropped;
  out.speed_radps.resize(n, static_cast<Eigen::Index>(rotors));
  out.thrust_N.resize(n);
  Eigen::VectorXd torque(n), time(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto& row = rows->kept[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < rotors; ++i) out.speed_radps(k, static_cast<Eigen::Index>(i)) = row[i];
    out.thrust_N[k] = row[rotors];
    torque[k] = row[rotors + 1];
    time[k] = row[rotors + 2];
  }
  out.thrust_N = upright(out.thrust_N);
  if (columns->torque) out.torque_Nm = upright(torque);
  if (columns->time && time.allFinite()) out.time_s = time;
  return out;
}

}  // namespace omniflight::identification
