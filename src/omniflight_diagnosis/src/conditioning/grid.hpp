// The fine time grid onto which signals are resampled before block averaging, and the mask of its used
// samples.
#pragma once

#include <string>
#include <vector>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

struct Grid {
  double rate_hz = 0;
  int step = 1;           ///< fine samples per sample of the regression grid (Options::grid_hz)
  std::vector<double> t;  ///< s

  Eigen::Index size() const { return static_cast<Eigen::Index>(t.size()); }
};

/// A signal on a grid, and where it is valid.
struct Channel {
  Eigen::MatrixXd x;  ///< samples x components; gaps hold the last value
  std::vector<char> valid;
};

/// Variance [s^2] of the smoothing kernel of a signal before the block mean: a triangle of half width T
/// (linear interpolation, T its sample period; T^2 / 6) and a box of width 2 dt per central difference (dt
/// the grid step; dt^2 / 3 each).
double kernel_variance(const recording::Signal& signal, const Grid& grid, int derivatives);

/// Signal without outliers, interpolated, and averaged over grid.step samples. `more` [s^2]: variance of an
/// additional smoothing kernel.
Channel on_grid(const recording::Signal& signal, const Grid& grid, const Options& options, double more = 0);

/// Flags of grid samples inside any of the windows.
std::vector<char> in_windows(const std::vector<Window>& windows, const Grid& grid);

std::vector<char> negated(const std::vector<char>& flags);

/// Mask of used grid samples, with excluded windows and their reasons.
class UsedSamples {
 public:
  explicit UsedSamples(const Grid& grid) : grid_(grid), use_(grid.t.size(), 1) {}

  /// Excludes samples where `bad` is set, and margin_s [s] on both sides.
  void exclude(const std::vector<char>& bad, double margin_s, const std::string& why);
  /// Adds the windows where `bad` is set to the list without excluding them.
  void list(const std::vector<char>& bad, const std::string& why);
  /// Excludes margin_s [s] at both ends of the grid, without listing windows.
  void exclude_ends(double margin_s);

  const std::vector<char>& flags() const { return use_; }
  const std::vector<Window>& windows() const { return windows_; }

 private:
  const Grid& grid_;
  std::vector<char> use_;
  std::vector<Window> windows_;
};

}  // namespace omniflight::diagnosis
