// Cells of text tables: separators, quotes, decimal commas and lists of numbers in one cell.
#pragma once

#include <string_view>
#include <vector>

namespace omniflight::recording {

inline constexpr std::size_t kMaxColumns = 2000, kMaxListed = 100;

/// Without blanks around it, and without the quotes around what is left.
std::string_view trimmed(std::string_view text);

/// What separates the cells of this header: a semicolon or a tab where there are more of them than commas,
/// otherwise a comma; 0 where there is none of the three.
char separator_of(std::string_view header);

/// Splits a row into trimmed cells; separators between quotes do not count. A blank as separator stands for
/// any number of blanks. At most kMaxColumns + 1 cells.
void split_row(std::string_view row, char separator, std::vector<std::string_view>& cells);

/// What a cell holds; `comma`: a number with a decimal comma.
enum class Cell { empty, number, comma, bad };

/// Decimal commas are numbers only where commas do not separate cells. "nan" is empty, infinity is bad.
Cell parse_cell(std::string_view text, bool decimal_commas, double& value);

/// "[0.1, 0.2 9.81]" with brackets, parentheses or none, separated by commas, semicolons or blanks, with
/// decimal points. Numbers are appended to `values`; `bad` where one is not finite or there are more than
/// kMaxListed.
Cell parse_list(std::string_view text, std::vector<double>& values);

}  // namespace omniflight::recording
