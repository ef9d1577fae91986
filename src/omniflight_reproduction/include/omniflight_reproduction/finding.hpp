// What was found of one figure: numbers, drawings, and a verdict that follows from the numbers alone.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_report/blocks.hpp"

namespace omniflight::reproduction {

enum class Verdict {
  reproduced,    ///< as the thesis defines it, within the tolerance
  explained,     ///< under another reading, which is named
  contradicted,  ///< under no reading that was tried
  unprinted      ///< shown; the thesis prints no number to compare with
};
const char* word(Verdict verdict);

/// Our number under one set of assumptions.
struct Reading {
  std::string assumption;  ///< "f_max 5.95 N, nearest vertex"
  double value = 0;
};

/// One printed number and ours. The first reading takes the thesis by its words.
struct Row {
  std::string key;         ///< of printed_numbers(); empty: the thesis prints none
  std::string what, unit;  ///< of rows without key; others have the printed words
  std::vector<Reading> readings;
  std::optional<std::size_t> chosen = {};  ///< the reading that judge_together() took

  Verdict verdict() const;
  /// The reading that the verdict rests on: the chosen one, else the first that agrees, else the nearest.
  const Reading* decisive() const;
};
/// A row of printed number `key`.
Row compared(std::string key, std::vector<Reading> readings);
/// A number of ours that has no printed counterpart.
Row shown(std::string what, std::string unit, double value, std::string assumption = {});
/// One definition for all rows that have the same number of readings: that which agrees in most of them, of
/// equals the nearest. Otherwise every row would pick the definition that suits it.
void judge_together(std::vector<Row>& rows);

struct Finding {
  std::vector<Row> rows;
  std::vector<std::string> notes;  ///< why, a paragraph each
  std::vector<report::Table> tables;
  std::vector<report::Outlines> outlines;
  std::vector<report::TimePlot> plots;

  /// The worst of its rows; unprinted rows do not count.
  Verdict verdict() const;
  /// One sentence a row that is not reproduced: by how much, or under which reading.
  std::vector<std::string> reasons() const;
};

/// Everything, so that a page can be made of it again.
nlohmann::json to_json(const Finding& finding);
/// Refuses what to_json() does not write.
Result<Finding> finding_from_json(const nlohmann::json& json);

}  // namespace omniflight::reproduction
