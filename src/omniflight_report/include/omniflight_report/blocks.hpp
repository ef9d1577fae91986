// What a page is made of, as plain data. Every text is taken as it is and escaped when it is rendered; every
// label of a number names its unit. Values that are not finite are allowed everywhere and shown as missing.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace omniflight::report {

/// What a verdict or a marked window means. Never shown by colour alone.
enum class Tone { ok, warn, bad, unknown };

enum class Align { automatic, left, right };  ///< automatic: numbers right, text left

struct Column {
  std::string name = {};
  std::string unit = {};  ///< shown in brackets behind the name; empty: none
  Align align = Align::automatic;
  int significant_digits = 4;  ///< of numbers, 1..15; a column of whole numbers is printed as such
  bool symbols = false;        ///< texts are symbols in plain letters ("lambda", "h_0"), to be typeset
};

struct Cell {
  std::variant<std::string, double> value;
  /// Colours the cell: 1 neutral, below 1 better (blue, full at 0.5), above 1 worse (orange, full at 2).
  std::optional<double> ratio;

  Cell(double number) : value(number) {}                    // NOLINT
  Cell(int number) : value(static_cast<double>(number)) {}  // NOLINT
  Cell(std::string text) : value(std::move(text)) {}        // NOLINT
  Cell(const char* text) : value(std::string(text)) {}      // NOLINT
  Cell(double number, double colour_ratio) : value(number), ratio(colour_ratio) {}
};

struct Table {
  std::vector<Column> columns = {};
  std::vector<std::vector<Cell>> rows = {};  ///< every row as long as columns
  std::string caption = {};
};

struct Fact {
  std::string key = {};
  std::string value = {};
  std::string unit = {};
};

/// One line (or cloud of points) of a plot. x and y have one length; a y that is not finite is drawn as a
/// gap.
struct Series {
  std::string name = {};
  std::vector<double> x = {};  ///< in the unit of TimePlot::x_label; sorted by the page when it is not
  std::vector<double> y = {};  ///< in the unit of TimePlot::y_label
  std::vector<double> low = {},
                      high = {};  ///< both empty, or the lower and upper end of a band, as long as y
  bool dashed = false;
  bool points = false;  ///< a point a sample instead of a line
};

/// A span of x that is shaded, for instance a window of mismatch.
struct Window {
  double from = 0.0;
  double to = 0.0;
  std::string label = {};
  Tone tone = Tone::unknown;
};

struct TimePlot {
  std::string title = {};
  std::string x_label = "time [s]";
  std::string y_label = {};  ///< with unit: "vertical force [N]"
  std::vector<Series> series = {};
  std::vector<Window> windows = {};
  int height_px = 260;     ///< 80..2000
  std::string group = {};  ///< plots of one group zoom and point together in x; empty: alone
};

/// A flight path, shown from above (x-y) and from the side (x-z), coloured by a scalar.
struct PathPlot {
  std::string title = {};
  std::vector<double> x = {}, y = {}, z = {};  ///< [m], world frame, z up; one length
  std::vector<double> value = {};              ///< the scalar, as long as x
  std::string value_label = {};                ///< with unit: "position error [m]"
  std::vector<double> t = {};                  ///< [s], empty or as long as x; shown when pointing
  std::vector<double> reference_x = {}, reference_y = {},
                      reference_z = {};  ///< [m], drawn dashed in grey; empty: none
  int height_px = 340;                   ///< 80..2000
};

struct Bar {
  std::string name = {};
  double value = 0.0;
  std::optional<double> low = {}, high = {};  ///< ends of an interval, drawn as a whisker
  std::string note = {};                      ///< behind the value, for instance "alias of hung_cable"
};

struct Bars {
  std::string title = {};
  std::string unit = {};              ///< of the values; empty for probabilities and ratios
  std::vector<Bar> bars = {};         ///< values >= 0
  double full = 0.0;                  ///< value of a full bar (1 for probabilities); 0: the largest one
  std::optional<double> marker = {};  ///< a line across all bars, for instance a threshold
  std::string marker_label = {};
};

struct Matrix {
  std::string title = {};
  std::vector<std::string> rows = {}, columns = {};  ///< labels
  std::vector<std::vector<double>> values = {};      ///< [row][column]
  std::string value_label = {};                      ///< what the numbers are, with unit if any
  std::string row_title = {}, column_title = {};     ///< what the axes are, for instance "true effect"
};

/// A closed shape in a plane, for instance the hull of what forces a vehicle can exert.
struct Outline {
  std::string name = {};
  std::vector<std::pair<double, double>> points = {};  ///< in order, 3 at least; in the unit of the labels
};

struct OutlineView {
  std::string x_label = {}, y_label = {};  ///< with unit: "Fx [N]"
  std::vector<Outline> outlines = {};      ///< the same colours and order in every view
};

/// Shapes about the origin, in one scale in all views.
struct Outlines {
  std::string title = {};
  std::vector<OutlineView> views = {};
  double circle = 0.0;  ///< radius of a dashed circle about the origin; 0: none
  std::string circle_label = {};
};

/// A closed surface in space about the origin, for instance the hull of what forces a vehicle can exert.
struct Surface {
  std::string name = {};
  std::vector<std::array<double, 3>> points = {};  ///< in the unit of Surfaces; two make a line
  std::vector<std::array<int, 3>> triangles = {};  ///< indices into points
};

/// Surfaces beside each other, in one scale, turned together by dragging.
struct Surfaces {
  std::string title = {};
  std::string quantity = {}, unit = {};  ///< of the axes: "F", "N" for Fx [N]
  std::vector<Surface> surfaces = {};    ///< a view each
  double sphere = 0.0;                   ///< radius of a grid of meridians about the origin; 0: none
  std::string sphere_label = {};
};

/// A box or a rod in space [m].
struct SpaceSolid {
  std::string name = {};
  bool is_rod = false;
  std::array<double, 3> a = {}, b = {};  ///< box: middle and full edges; rod: its ends
  double radius = 0.0;                   ///< of a rod
  bool is_zone = false;                  ///< nothing that can be touched: drawn in another colour
};

struct SpaceDisc {
  std::array<double, 3> center = {}, axis = {};  ///< m; unit
  double radius = 0.0;                           ///< m
};

/// A path among solids in space, coloured by a scalar, with what moves along it at some places; turned by
/// dragging.
struct Space {
  std::string title = {};
  std::string value_label = {};                  ///< with unit: "clearance [m]"
  std::vector<std::array<double, 3>> path = {};  ///< m, world frame, z up
  std::vector<double> value = {};                ///< the scalar, as long as the path
  std::vector<SpaceSolid> solids = {};
  std::vector<SpaceDisc> discs = {};                             ///< of rotors
  std::vector<std::array<std::array<double, 3>, 2>> lines = {};  ///< of a tether
};

}  // namespace omniflight::report
