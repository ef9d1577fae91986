#include "omniflight_reproduction/finding.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "omniflight_reproduction/printed.hpp"

namespace omniflight::reproduction {
namespace {

/// How far ours is from the printed number, in tolerances.
double distance(const Printed& p, double ours) {
  if (!std::isfinite(ours)) return HUGE_VAL;
  if (!p.factor) return std::abs(ours - p.value) / std::max(p.tolerance, 1e-12);
  return ours > 0 ? std::abs(std::log(ours / p.value)) / std::log(p.tolerance) : HUGE_VAL;
}

}  // namespace

const char* word(Verdict verdict) {
  switch (verdict) {
    case Verdict::reproduced:
      return "reproduced";
    case Verdict::explained:
      return "explained";
    case Verdict::contradicted:
      return "contradicted";
    case Verdict::unprinted:
      break;
  }
  return "no printed number";
}

const Reading* Row::decisive() const {
  if (readings.empty()) return nullptr;
  const Printed* p = find_printed(key);
  if (chosen && *chosen < readings.size()) return &readings[*chosen];
  if (!p) return &readings.front();
  for (const Reading& r : readings)
    if (agrees(*p, r.value)) return &r;
  return &*std::min_element(readings.begin(), readings.end(), [&](const Reading& a, const Reading& b) {
    return distance(*p, a.value) < distance(*p, b.value);
  });
}

Verdict Row::verdict() const {
  const Printed* p = find_printed(key);
  if (!p) return Verdict::unprinted;
  const Reading* r = decisive();
  if (!r || !agrees(*p, r->value)) return Verdict::contradicted;
  return r == &readings.front() ? Verdict::reproduced : Verdict::explained;
}

Row compared(std::string key, std::vector<Reading> readings) {
  Row row{.key = std::move(key), .what = {}, .unit = {}, .readings = std::move(readings)};
  if (const Printed* p = find_printed(row.key)) row.what = p->what, row.unit = p->unit;
  return row;
}

Row shown(std::string what, std::string unit, double value, std::string assumption) {
  return {.key = {},
          .what = std::move(what),
          .unit = std::move(unit),
          .readings = {{std::move(assumption), value}}};
}

void judge_together(std::vector<Row>& rows) {
  std::size_t common = 0;
  for (const Row& row : rows)
    if (find_printed(row.key)) common = std::max(common, row.readings.size());
  std::size_t best = 0, most = 0;
  double least = HUGE_VAL;
  for (std::size_t k = 0; k < common; ++k) {
    std::size_t agreeing = 0;
    double sum = 0;
    for (const Row& row : rows) {
      const Printed* p = find_printed(row.key);
      if (!p || row.readings.size() != common) continue;
      agreeing += agrees(*p, row.readings[k].value);
      sum += std::min(distance(*p, row.readings[k].value), 1e6);
    }
    if (agreeing > most || (agreeing == most && sum < least)) best = k, most = agreeing, least = sum;
  }
  for (Row& row : rows)
    if (find_printed(row.key) && row.readings.size() == common) row.chosen = best;
}

Verdict Finding::verdict() const {
  Verdict worst = Verdict::unprinted;
  for (const Row& row : rows) {
    const Verdict v = row.verdict();
    if (v == Verdict::unprinted) continue;
    if (worst == Verdict::unprinted || v > worst) worst = v;
  }
  return worst;
}

std::vector<std::string> Finding::reasons() const {
  std::vector<std::string> out;
  for (const Row& row : rows) {
    const Verdict v = row.verdict();
    const Printed* p = find_printed(row.key);
    const Reading* r = row.decisive();
    if (!p || v == Verdict::reproduced) continue;
    if (!r) {
      out.push_back(fmt::format("{}: not computed", row.what));
    } else if (v == Verdict::explained) {
      out.push_back(fmt::format("{}: {:.4g} {} with {}; by the words of the thesis {:.4g} ({})", row.what,
                                r->value, row.unit, r->assumption, row.readings.front().value,
                                row.readings.front().assumption));
    } else {
      out.push_back(fmt::format("{}: printed {:.4g} {}, ours {:.4g} at the nearest ({})", row.what, p->value,
                                row.unit, r->value, r->assumption));
    }
  }
  return out;
}

}  // namespace omniflight::reproduction
