// Reads the rows of a text table, one sample a row, as its layout says.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "collector.hpp"
#include "csv_map.hpp"

namespace omniflight::recording {

class CsvTable {
 public:
  /// `bytes` must outlive the table.
  CsvTable(std::string_view bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  /// Reads the header. `separator` 0: found out from it.
  Result<std::vector<std::string>> header(char separator = '\0');
  /// Reads all rows behind the header. The error names line and column.
  Status rows(const CsvLayout& layout, Recording& recording);

  char separator() const { return separator_; }
  std::uint64_t blank_rows() const { return blank_rows_; }

 private:
  struct Rejected {
    std::uint64_t partial = 0, held = 0;
    std::size_t first_line = 0;
  };

  bool next_line(std::string_view& line);
  std::string here() const { return file_ + ":" + std::to_string(line_number_); }
  Status row(const CsvLayout& layout, Recording& recording);
  Result<double> time(const CsvLayout& layout, Recording& recording);
  Status sample(const CsvSignal& signal, double t_s, Rejected& rejected, std::vector<double>& last);
  Status cell(const CsvSignal& signal, int column);
  Status bad_cell(int column, const std::string& next_step) const;
  Status one_decimal_mark(std::string_view text, int column, bool comma);
  void tell(const CsvLayout& layout, Recording& recording) const;

  std::string_view bytes_;
  std::string file_;
  std::size_t at_ = 0, line_number_ = 0;
  bool whole_line_ = true;
  char separator_ = ',';
  std::vector<std::string> header_;
  std::vector<std::string_view> cells_;
  std::vector<double> values_;
  std::size_t comma_line_ = 0,
              point_line_ = 0;  // where a decimal comma and a point were first seen; 0: nowhere
  std::uint64_t blank_rows_ = 0;
  bool first_ = true;
  double start_ = 0.0, previous_ = 0.0;
  std::vector<Rejected> rejected_;
  std::vector<std::vector<double>> last_;  // time and values of the last sample that was kept, by signal
  Collector collector_;
};

}  // namespace omniflight::recording
