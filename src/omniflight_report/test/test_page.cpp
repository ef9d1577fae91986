#include <gtest/gtest.h>

#include <fstream>
#include <regex>

#include <nlohmann/json.hpp>

#include "example_page.hpp"

namespace omniflight::report {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

TEST(Page, ShowsEveryKindOfBlockInLessThanFourMegabytes) {
  const auto html = example_page().html();
  ASSERT_TRUE(html) << html.error().text();
  for (const char* part : {"class=\"verdict warn\"", "class=\"facts\"", "figure class=\"path\"",
                           "figure class=\"plot\"", "figure class=\"bars\"", "figure class=\"table wide\"",
                           "figure class=\"matrix\"", "class=\"equation\"", "<details>", "class=\"toc\"",
                           "figure class=\"outlines\"", "class=\"filter\""}) {
    EXPECT_NE(html->find(part), std::string::npos) << part;
  }
  EXPECT_LT(html->size(), 4'000'000u);
  if (const char* keep = std::getenv("OMNIFLIGHT_KEEP_EXAMPLE")) {
    EXPECT_TRUE(example_page().write(keep));
  }
}

TEST(Page, LoadsNothing) {
  const std::string html = *example_page().html();
  const std::regex load(
      R"(<(link|img|iframe|object|embed|base|source|video|audio)\b|<script[^>]+src|@import|url\()",
      std::regex::icase);
  const std::string page_part = html.substr(0, html.find("/*! @license"));  // markup, style and data
  EXPECT_FALSE(std::regex_search(page_part, load));
  const std::regex reference(R"re((?:src|href)="(?!#section-\d+"|#content"))re");
  EXPECT_FALSE(std::regex_search(page_part, reference));
  EXPECT_EQ(html.find("sourceMappingURL"), std::string::npos);
  EXPECT_NE(html.find("default-src 'none'"),
            std::string::npos);  // and the browser refuses what we overlooked
  EXPECT_EQ(count(html, "http://") + count(html, "https://"),
            count(html, "http://www.w3.org/") +
                count(html, "https://github.com/danvk/dygraphs/blob/v2.2.1/LICENSE.txt"));
}

TEST(Page, HasOnlyTheScriptsItNeeds) {
  Page page("Short", "");
  page.paragraph("Nothing to plot.");
  EXPECT_LT(page.html()->size(), 30'000u);
}

TEST(Page, HostileTextStaysText) {
  const std::string evil = "</script><script>alert(1)</script><!-- \"'&\\ \x01\xff";
  Page page(evil, evil);
  page.verdict(Tone::ok, evil, evil)
      .section(evil)
      .section(evil)
      .paragraph(evil)
      .facts({{evil, evil, evil}})
      .equation(evil)
      .details(evil, evil);
  page.table({{{evil, evil}}, {{Cell(evil)}}, evil});
  page.bars({evil, evil, {{evil, 1.0, {}, {}, evil}}, 1.0, 0.5, evil})
      .matrix({evil, {evil}, {evil}, {{1.0}}, evil, evil, evil});
  page.plot({evil, evil, evil, {{evil, {0, 1}, {0, 1}}}, {{0, 1, evil, Tone::bad}}, 200, evil});
  page.path_plot({evil, {0}, {0}, {0}, {0}, evil, {}, {}, {}, {}, 200});
  const std::string html = *page.html();
  EXPECT_EQ(html.find("alert(1)<"), std::string::npos);
  EXPECT_EQ(html.find("<!--"), std::string::npos);
  EXPECT_EQ(html.find('\xff'), std::string::npos);
  EXPECT_EQ(html.find('\x01'), std::string::npos);
  EXPECT_EQ(count(html, "<script"), count(html, "</script>"));
  EXPECT_EQ(count(html, "<script"), 7u);  // two blocks of data; dygraphs, KaTeX and three of ours
}

TEST(Page, DataIsJsonThatReadsBackAsGiven) {
  const std::string name = "a \"quoted\" </script> \\u03bb \u03BB";
  Page page("Data", "");
  page.plot({"p",
             "time [s]",
             "y [m]",
             {{name, {0, 1, 2}, {0.1, -1e-9, 12345.678}, {0, 0, 0}, {1, 1, 1}}},
             {{-1, 0.5, name, Tone::ok}},
             200,
             name});
  page.path_plot({"path", {0, 1}, {0, NAN}, {0, 1}, {3, 4}, "e [m]", {0.0, 0.1}});
  const std::string html = *page.html(), open = "<script type=\"application/json\">";
  std::vector<nlohmann::json> data;
  for (auto at = html.find(open); at != std::string::npos; at = html.find(open, at + 1)) {
    const auto from = at + open.size();
    data.push_back(nlohmann::json::parse(html.substr(from, html.find("</script>", from) - from)));
  }
  ASSERT_EQ(data.size(), 2u);
  EXPECT_EQ(data[0]["series"][0]["name"], name);
  EXPECT_EQ(data[0]["windows"][0]["label"], name);
  EXPECT_EQ(data[0]["group"], name);
  EXPECT_NEAR(data[0]["series"][0]["y"][2].get<double>(), 12345.678, 0.0124);
  EXPECT_EQ(data[0]["series"][0]["high"].size(), 3u);
  EXPECT_EQ(data[1]["x"], (nlohmann::json{0, nullptr}));  // a position is whole or missing
}

TEST(Page, UnsortedSamplesAreSortedByX) {
  Page page("Sorted", "");
  page.plot({"p", "height [m]", "F [N]", {{"a", {2, 0, 1}, {20, 0, 10}}}});
  EXPECT_NE(page.html()->find("\"x\":[0,1,2],\"y\":[0,10,20]"), std::string::npos);
}

TEST(Page, TenThousandSamplesOfFiftySeriesStaySmall) {
  Page page("Large", "");
  std::vector<double> x, y;
  for (int i = 0; i < 10000; ++i) {
    x.push_back(1.7e9 + 0.001 * i);
    y.push_back(std::sin(0.37 * i) * 1.2345678);
  }
  for (int k = 0; k < 50; ++k)
    page.plot({"p", "time [s]", "y [m]", {{"a", x, y}, {"b", x, y}, {"c", x, y}}, {}, 200, "all"});
  EXPECT_LT(page.html()->size(), 4'000'000u);
}

TEST(Page, NamesTheBlockThatCannotBeShown) {
  Page page("Broken", "");
  page.section("Forces").plot({"Fz", "time [s]", "F [N]", {{"measured", {0, 1, 2}, {0, 1}}}, {}, 200, ""});
  const auto html = page.html();
  ASSERT_FALSE(html);
  EXPECT_EQ(html.error().text(),
            "report 'Broken', plot 'Fz': series 'measured' has vectors of different lengths");
  EXPECT_FALSE(Page("T", "").table({{{"a", ""}, {"b", ""}}, {{1.0}}, "short"}).html());
  EXPECT_FALSE(Page("T", "").matrix({"m", {"a"}, {"a", "b"}, {{1.0}}, "", "", ""}).html());
  EXPECT_FALSE(Page("T", "").details("d", [](Page& inside) { inside.section("no"); }).html());
  EXPECT_FALSE(Page("T", "").bars({"b", "", {{"negative", -1.0, {}, {}, ""}}, 1.0, {}, ""}).html());
}

TEST(Page, OutlinesAreDrawnInOneScale) {
  const Outline square{"square", {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
  const Outline large{"large", {{4, 0}, {0, 4}, {-4, 0}}};
  Page page("Sets", "");
  page.outlines({.title = "two",
                 .views = {{"Fx [N]", "Fy [N]", {square}}, {"Fx [N]", "Fz [N]", {large}}},
                 .circle = 2,
                 .circle_label = "weight"});
  const auto html = page.html();
  ASSERT_TRUE(html) << html.error().text();
  // 380 wide with a margin of 26: 164 to a side for the largest coordinate, 4
  EXPECT_NE(html->find("points=\"231.00,149.00 149.00,149.00 149.00,231.00 231.00,231.00\""),
            std::string::npos);
  EXPECT_NE(html->find("points=\"354.00,190.00 190.00,26.00 26.00,190.00\""), std::string::npos);
  EXPECT_NE(html->find("r=\"82.00\""), std::string::npos);
  EXPECT_NE(html->find("weight"), std::string::npos);

  for (const auto& [outline, complaint] :
       {std::pair(Outline{"line", {{0, 0}, {1, 1}}}, "outline 'line' has less than 3 points"),
        {Outline{"far", {{0, 0}, {1, 1}, {std::nan(""), 0}}},
         "outline 'far' has a point that is not finite"}}) {
    Page wrong("Sets", "");
    const auto refused = wrong.outlines({.title = "one", .views = {{"x", "y", {outline}}}}).html();
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().text().find(complaint), std::string::npos) << refused.error().text();
  }
}

TEST(Page, SpacesHoldPathSolidsAndWhatMovesAndRefuseWhatIsNotFinite) {
  Space space{.title = "the way", .value_label = "clearance [m]"};
  space.path = {{0, 0, 1}, {1, 0, 1}};
  space.value = {0.2, std::nan("")};
  space.solids = {{.name = "beam", .is_rod = true, .a = {0, 0, 0}, .b = {0, 0, 2}, .radius = 0.03}};
  space.discs = {{.center = {0, 0, 1}, .axis = {0, 0, 1}, .radius = 0.1}};
  space.lines = {{{{0, 0, 0}, {0, 0, 1}}}};
  Page page("a", "b");
  const auto html = page.space(space).html();
  ASSERT_TRUE(html) << html.error().text();
  for (const char* word : {"figure class=\"space\"", "clearance [m]", "\"rod\":true", "\"value\":[0.2,null]"})
    EXPECT_NE(html->find(word), std::string::npos) << word;
  space.solids[0].a[1] = INFINITY;
  const auto refused = Page("a", "b").space(space).html();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("not finite"), std::string::npos) << refused.error().text();
}

TEST(Page, SurfacesBringTheirScriptAndTheirCorners) {
  const Surface corner{
      "corner", {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}, {0, 0, 5}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  const Surface line{"line", {{0, 0, -1}, {0, 0, 2}}, {}};
  Page page("Sets", ""), plain("Sets", "");
  page.surfaces({.title = "two",
                 .quantity = "F",
                 .unit = "N",
                 .surfaces = {corner, line},
                 .sphere = 2,
                 .sphere_label = "weight"});
  const auto html = page.html();
  ASSERT_TRUE(html) << html.error().text();
  for (const char* part :
       {"figure class=\"surfaces\"", "aria-label=\"two: line\"", "weight",
        "\"triangles\":[[0,2,1],[0,1,3],[0,3,2],[1,2,3]]", "{\"points\":[[0,0,-1],[0,0,2]],\"triangles\":[]}",
        "\"sphere\":2", "\"largest\":5", "WebGLRenderer"})
    EXPECT_NE(html->find(part), std::string::npos) << part;
  EXPECT_EQ(count(*html, "<canvas"), 2u);
  EXPECT_EQ(plain.html()->find("WebGLRenderer"), std::string::npos)
      << "a page holds only the scripts it uses";

  Surface open = corner, far = corner;
  open.triangles.push_back({0, 1, 4});
  far.points[0][2] = std::nan("");
  for (const auto& [surface, complaint] : {std::pair(open, "surface 'corner' has no point 4"),
                                           {far, "surface 'corner' has a point that is not finite"}}) {
    Page wrong("Sets", "");
    const auto refused = wrong.surfaces({.title = "one", .surfaces = {surface}}).html();
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().text().find(complaint), std::string::npos) << refused.error().text();
  }
}

TEST(Page, RowsOfWideTablesNameTheirColumns) {
  Page page("Tables", "");
  page.table({{{"a"}, {"b", "N"}, {"c"}, {"d"}}, {{1, 2, "x", "y"}}, ""})
      .table({{{"a"}, {"b", "N"}}, {{1, 2}}, ""});
  const std::string html = *page.html();
  EXPECT_EQ(count(html, "figure class=\"table wide\""), 1u);
  EXPECT_NE(html.find("data-label=\"b [N]\""), std::string::npos);
  EXPECT_EQ(count(html, "data-label=\""), 4u) << "narrow tables need none";
}

TEST(Page, SymbolsAreTypesetAndStayText) {
  Page page("Symbols", "");
  page.table({{{"name"}, {.name = "symbol", .symbols = true}},
              {{"a", "h_0"}, {"b", "eps_kappa"}, {"c", "1 - eta_0"}, {"d", "dJ_xx"}, {"e", "<b>_<i>"}},
              ""});
  const std::string html = *page.html();
  for (const char* part :
       {"<i>h</i><sub>0</sub>", "<i>\u03b5</i><sub>\u03ba</sub>", "1 - <i>\u03b7</i><sub>0</sub>",
        "<i>\u0394J</i><sub>xx</sub>", "<i>&lt;b&gt;</i><sub>&lt;i&gt;</sub>"})
    EXPECT_EQ(count(html, part), 1u) << part;
}

TEST(Page, OneFilterOutsideDetails) {
  Page page("Filter", "");
  const auto twice = page.filter("a").filter("b").html();
  ASSERT_FALSE(twice);
  EXPECT_NE(twice.error().text().find("a page has one filter"), std::string::npos);
}

TEST(Page, MissingSamplesAreGapsAndCounted) {
  Page page("Gaps", "");
  page.plot({"p",
             "time [s]",
             "y [m]",
             {{"a", {0, 1, 2, std::nan("")}, {1, std::nan(""), INFINITY, 4}}},
             {},
             200,
             ""});
  const std::string html = *page.html();
  EXPECT_NE(html.find("\"x\":[0,1,2],\"y\":[1,null,null]"), std::string::npos);
  EXPECT_NE(html.find("a: 2 of 3 samples are missing or not finite"), std::string::npos);
}

}  // namespace
}  // namespace omniflight::report
