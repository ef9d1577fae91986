#include "omniflight_reproduction/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "omniflight_report/page.hpp"
#include "omniflight_reproduction/printed.hpp"

namespace omniflight::reproduction {
namespace {

struct Counts {
  int reproduced = 0, explained = 0, contradicted = 0, unprinted = 0, left = 0;
};

Counts count(const std::vector<Computed>& all) {
  Counts c;
  for (const Computed& one : all) {
    if (!one.finding) {
      ++c.left;
      continue;
    }
    switch (one.finding->verdict()) {
      case Verdict::reproduced:
        ++c.reproduced;
        break;
      case Verdict::explained:
        ++c.explained;
        break;
      case Verdict::contradicted:
        ++c.contradicted;
        break;
      case Verdict::unprinted:
        ++c.unprinted;
    }
  }
  return c;
}

std::string heading(const Figure& f) {
  const std::string id = f.id;
  return (id.rfind("table", 0) == 0 ? "T" + id.substr(1) : "Figure " + id) + ": " + f.title;
}

std::string in_words(const Computed& one) {
  return one.finding ? word(one.finding->verdict()) : "not computed";
}

/// One line, most telling first.
std::string why(const Computed& one) {
  if (!one.finding) return one.why_not;
  const auto reasons = one.finding->reasons();
  if (!reasons.empty())
    return reasons.front() + (reasons.size() > 1 ? fmt::format("; and {} more", reasons.size() - 1) : "");
  if (one.finding->verdict() == Verdict::reproduced) return "as the thesis defines it";
  return "shown";
}

report::Table overview(const std::vector<Computed>& all) {
  report::Table t;
  t.caption = "Every figure and table";
  t.columns = {{.name = "figure"}, {.name = "shows"}, {.name = "verdict"}, {.name = "why"}};
  for (const Computed& one : all)
    t.rows.push_back({one.figure->id, one.figure->title, in_words(one), why(one)});
  return t;
}

std::string tolerance_words(const Printed& p) {
  return p.factor ? fmt::format("factor {:.3g}", p.tolerance) : fmt::format("{:.3g}", p.tolerance);
}

/// A number for people: enough digits, no tail of rounding errors.
std::string number(double x) { return std::isfinite(x) ? fmt::format("{:.4g}", x) : "none"; }

report::Table numbers(const Finding& f) {
  report::Table t;
  t.columns = {{.name = "quantity"},
               {.name = "unit"},
               {.name = "printed", .align = report::Align::right},
               {.name = "ours", .align = report::Align::right},
               {.name = "by the words", .align = report::Align::right},
               {.name = "tolerance"},
               {.name = "verdict"},
               {.name = "ours is"}};
  for (const Row& row : f.rows) {
    const Printed* p = find_printed(row.key);
    const Reading* r = row.decisive();
    t.rows.push_back({row.what, row.unit, p ? number(p->value) : "-", r ? number(r->value) : "none",
                      p && !row.readings.empty() ? number(row.readings.front().value) : "-",
                      p ? tolerance_words(*p) : "-", word(row.verdict()),
                      r && !r->assumption.empty() ? r->assumption : "-"});
  }
  return t;
}

report::Table all_readings(const Finding& f) {
  report::Table t;
  t.caption = "Every reading; the first of each quantity takes the thesis by its words";
  t.columns = {{.name = "quantity"}, {.name = "reading"}, {.name = "ours", .align = report::Align::right}};
  for (const Row& row : f.rows)
    if (find_printed(row.key))
      for (const Reading& r : row.readings) t.rows.push_back({row.what, r.assumption, number(r.value)});
  return t;
}

report::Table sources(const Finding& f) {
  report::Table t;
  t.caption = "Where the printed numbers stand, and why that tolerance";
  t.columns = {{.name = "quantity"}, {.name = "place"}, {.name = "tolerance because"}};
  for (const Row& row : f.rows)
    if (const Printed* p = find_printed(row.key)) t.rows.push_back({row.what, p->source, p->because});
  return t;
}

void show(report::Page& page, const Computed& one) {
  page.section(heading(*one.figure));
  if (!one.finding) {
    page.paragraph("Not computed: " + one.why_not + ".");
    return;
  }
  const Finding& f = *one.finding;
  page.paragraph(fmt::format("Verdict: {}.{}", in_words(one),
                             one.figure->assigned
                                 ? " The number of this figure is known, its caption is not: the subject "
                                   "was put to it by the text around it."
                                 : ""));
  for (const std::string& note : f.notes) page.paragraph(note);
  if (!f.rows.empty()) page.table(numbers(f));
  for (const auto& o : f.outlines) page.outlines(o);
  for (const auto& t : f.tables) page.table(t);
  for (const auto& p : f.plots) page.plot(p);
  const bool has_printed =
      std::any_of(f.rows.begin(), f.rows.end(), [](const Row& r) { return find_printed(r.key) != nullptr; });
  if (has_printed)
    page.details("Readings and sources", [&](report::Page& inside) {
      inside.table(all_readings(f));
      inside.table(sources(f));
    });
}

}  // namespace

std::string conclusion(const std::vector<Computed>& all) {
  const Counts c = count(all);
  std::string out = fmt::format("{} figures and tables: {} reproduced, {} explained, {} contradicted",
                                all.size(), c.reproduced, c.explained, c.contradicted);
  if (c.unprinted > 0) out += fmt::format(", {} shown without a printed number", c.unprinted);
  if (c.left > 0) out += fmt::format(", {} not computed", c.left);
  return out;
}

nlohmann::json to_json(const std::vector<Computed>& all, const std::string& version) {
  const Counts c = count(all);
  nlohmann::json j{{"schema", "omniflight.reproduction/1"},
                   {"version", version},
                   {"conclusion", conclusion(all)},
                   {"reproduced", c.reproduced},
                   {"explained", c.explained},
                   {"contradicted", c.contradicted},
                   {"without_printed_number", c.unprinted},
                   {"not_computed", c.left},
                   {"figures", nlohmann::json::array()}};
  for (const Computed& one : all) {
    nlohmann::json figure{
        {"id", one.figure->id},     {"title", one.figure->title}, {"subject_assigned", one.figure->assigned},
        {"verdict", in_words(one)}, {"seconds", one.seconds},     {"kept", one.kept},
        {"why_not", one.why_not}};
    if (one.finding) {
      const nlohmann::json finding = to_json(*one.finding);
      figure["rows"] = finding["rows"];
      figure["reasons"] = finding["reasons"];
    }
    j["figures"].push_back(std::move(figure));
  }
  return j;
}

Status write_page(const std::vector<Computed>& all, const std::string& version,
                  const std::vector<std::string>& remarks, const std::string& path) {
  const Counts c = count(all);
  report::Page page("The OmniMorph thesis, figure by figure", version);
  page.verdict(c.contradicted + c.left == 0 ? report::Tone::ok : report::Tone::warn, conclusion(all),
               "Reproduced: by the words of the thesis, within the tolerance. Explained: under another "
               "reading, which is "
               "named; that is consistency, not proof. Contradicted: under no reading that was tried. Every "
               "number of ours "
               "was computed by this program; every printed one has its place below its figure.");
  for (const std::string& remark : remarks) page.paragraph(remark);
  page.section("Overview").table(overview(all));
  if (all.size() > 3) page.filter("Show only figures that mention");
  for (const Computed& one : all) show(page, one);
  return page.write(path);
}

}  // namespace omniflight::reproduction
