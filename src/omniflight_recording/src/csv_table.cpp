#include "csv_table.hpp"

#include <algorithm>
#include <cmath>

#include "csv_cells.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::recording {
namespace {

constexpr std::size_t kMaxLine = 1u << 20;

}  // namespace

bool CsvTable::next_line(std::string_view& line) {
  if (at_ >= bytes_.size()) return false;
  const auto end = bytes_.find('\n', at_);
  whole_line_ = end != std::string_view::npos;
  line = bytes_.substr(at_, whole_line_ ? end - at_ : std::string_view::npos);
  at_ = whole_line_ ? end + 1 : bytes_.size();
  ++line_number_;
  return true;
}

Result<std::vector<std::string>> CsvTable::header(char separator) {
  std::string_view line;
  if (!next_line(line)) return bad_input("is empty", file_, "Give a CSV with a header row");
  if (line.size() > kMaxLine) return bad_input("the header is longer than 1 MB", here());
  if (line.substr(0, 1) == "#") line.remove_prefix(1);
  separator_ = separator != '\0' ? separator : separator_of(line);
  split_row(line, separator_, cells_);
  if (cells_.empty()) return bad_input("has no header", here(), "Give a table with a row of names first");
  if (cells_.size() > kMaxColumns)
    return bad_input("has more than 2000 columns", here(), "Export fewer columns");
  header_.assign(cells_.begin(), cells_.end());
  return header_;
}

Status CsvTable::rows(const CsvLayout& layout, Recording& recording) {
  rejected_.resize(layout.signals.size());
  last_.resize(layout.signals.size());
  for (const auto& s : layout.signals)
    collector_.describe(s.signal, s.unit, "column " + header_[static_cast<std::size_t>(s.columns.front())]);
  std::string_view line;
  while (next_line(line)) {
    if (trimmed(line).empty()) {
      ++blank_rows_;
      continue;
    }
    if (line.size() > kMaxLine)
      return bad_input("a row is longer than 1 MB", here(), "This is not a CSV of samples");
    split_row(line, separator_, cells_);
    if (cells_.size() != header_.size()) {
      if (!whole_line_) {
        recording.note(Note::Kind::loss, "the last row is cut off and was left out", 1);
        break;
      }
      return bad_input(
          "has " + std::to_string(cells_.size()) + " cells, the header has " + std::to_string(header_.size()),
          here(),
          separator_ == ',' && cells_.size() > header_.size()
              ? "Repair the row; numbers with decimal commas need semicolons between cells"
              : "Repair the row");
    }
    if (const auto ok = row(layout, recording); !ok) return ok;
  }
  tell(layout, recording);
  collector_.finish(recording);
  if (recording.signal_names().empty())
    return bad_input("contains no sample of any known signal", file_, "Describe its columns with --map FILE");
  return {};
}

Status CsvTable::row(const CsvLayout& layout, Recording& recording) {
  const auto t = time(layout, recording);
  if (!t) return Failure(t.error());
  for (std::size_t k = 0; k < layout.signals.size(); ++k)
    if (const auto ok = sample(layout.signals[k], *t, rejected_[k], last_[k]); !ok) return ok;
  return {};
}

Result<double> CsvTable::time(const CsvLayout& layout, Recording& recording) {
  const std::string_view text = cells_[static_cast<std::size_t>(layout.time_column)];
  double t = 0;
  const Cell kind = parse_cell(text, separator_ != ',', t);
  if (kind != Cell::number && kind != Cell::comma)
    return bad_input("time " + files::shown(text) + " is not a finite number",
                     here() + ": " + header_[static_cast<std::size_t>(layout.time_column)], "Repair the row");
  if (const auto ok = one_decimal_mark(text, layout.time_column, kind == Cell::comma); !ok)
    return Failure(ok.error());
  if (first_) {
    recording.start_s = std::abs(t * layout.time_scale) > 1e6 ? t * layout.time_scale : 0.0;
    start_ = recording.start_s > 0 ? t : 0.0;
  }
  t = (t - start_) * layout.time_scale;
  if (!first_ && t < previous_)
    return bad_input(
        "time runs backwards, from " + std::to_string(previous_) + " s to " + std::to_string(t) + " s",
        here(), "Sort the rows, or split the file where the clock was reset");
  first_ = false;
  previous_ = t;
  return t;
}

Status CsvTable::sample(const CsvSignal& signal, double t_s, Rejected& rejected, std::vector<double>& last) {
  values_.clear();
  for (const int column : signal.columns)
    if (const auto ok = cell(signal, column); !ok) return ok;
  const std::size_t width = signal.list ? signal.width : signal.columns.size();
  if (values_.empty()) return {};
  if (width > 0 && values_.size() != width) {
    if (rejected.partial++ == 0) rejected.first_line = line_number_;
    return {};
  }
  if (signal.xyzw && values_.size() == 4) std::rotate(values_.begin(), values_.begin() + 3, values_.end());
  if (signal.held_s > 0) {
    const bool same = last.size() == values_.size() + 1 && t_s - last.front() < signal.held_s &&
                      std::equal(values_.begin(), values_.end(), last.begin() + 1);
    if (same) {
      ++rejected.held;
      return {};
    }
    last.assign(1, t_s);
    last.insert(last.end(), values_.begin(), values_.end());
  }
  collector_.add(signal.signal, t_s, values_.data(), values_.size());
  return {};
}

Status CsvTable::cell(const CsvSignal& signal, int column) {
  const std::string_view text = cells_[static_cast<std::size_t>(column)];
  const std::size_t before = values_.size();
  double value = 0;
  const Cell kind = signal.list ? parse_list(text, values_) : parse_cell(text, separator_ != ',', value);
  if (kind == Cell::bad && !whole_line_) {  // a number that is cut in the middle
    values_.resize(before);
    return {};
  }
  if (kind == Cell::bad)
    return bad_cell(column, signal.list ? "Write finite numbers with decimal points, as [0.1, 0.2, 9.8], or "
                                          "leave it empty"
                                        : "Correct the cell or leave it empty");
  if (!signal.list && (kind == Cell::number || kind == Cell::comma)) {
    if (const auto ok = one_decimal_mark(text, column, kind == Cell::comma); !ok) return ok;
    values_.push_back(value);
  }
  for (std::size_t i = before; i < values_.size(); ++i)
    values_[i] = values_[i] * signal.scale + signal.offset;
  return {};
}

Status CsvTable::bad_cell(int column, const std::string& next_step) const {
  const auto at = static_cast<std::size_t>(column);
  return bad_input(files::shown(cells_[at]) + " is not a finite number", here() + ": " + header_[at],
                   next_step);
}

/// A point between the digits of a table with decimal commas may group thousands: 1.234 is not guessed.
Status CsvTable::one_decimal_mark(std::string_view text, int column, bool comma) {
  if (separator_ == ',' || (!comma && text.find('.') == std::string_view::npos)) return {};
  std::size_t& seen = comma ? comma_line_ : point_line_;
  if (seen == 0) seen = line_number_;
  if (comma_line_ == 0 || point_line_ == 0) return {};
  return bad_input(files::shown(text) + ": the table has decimal commas (line " +
                       std::to_string(comma_line_) + ") and points (line " + std::to_string(point_line_) +
                       ")",
                   here() + ": " + header_[static_cast<std::size_t>(column)],
                   "Export it with one decimal mark and without groups of thousands");
}

void CsvTable::tell(const CsvLayout& layout, Recording& recording) const {
  if (comma_line_ > 0) recording.note(Note::Kind::information, "its numbers were read with decimal commas");
  if (!whole_line_)
    recording.note(Note::Kind::loss, "the file does not end with a line break; its last row may be cut");
  for (std::size_t k = 0; k < rejected_.size(); ++k) {
    const std::string& name = layout.signals[k].signal;
    if (rejected_[k].partial > 0)
      recording.note(Note::Kind::ignored,
                     name + ": " + std::to_string(rejected_[k].partial) +
                         " rows have only some of its cells (first in line " +
                         std::to_string(rejected_[k].first_line) + ") and were left out",
                     rejected_[k].partial);
    if (rejected_[k].held > 0)
      recording.note(Note::Kind::information,
                     name + ": " + std::to_string(rejected_[k].held) +
                         " rows repeat the sample before, because the log is written more often than it is "
                         "measured, and were left out",
                     rejected_[k].held);
  }
}

}  // namespace omniflight::recording
