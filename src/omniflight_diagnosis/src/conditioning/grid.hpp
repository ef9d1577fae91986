// The fine time grid on which raw signals are laid before their blocks are averaged, and which of its samples
// are used.
#pragma once

#include <string>
#include <vector>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

struct Grid {
  double rate_hz = 0;
  int step = 1;           ///< samples per sample of the flight
  std::vector<double> t;  ///< s

  Eigen::Index size() const { return static_cast<Eigen::Index>(t.size()); }
};

/// A signal on a grid, and where it is trustworthy.
struct Channel {
  Eigen::MatrixXd x;  ///< NaN replaced by the last value
  std::vector<char> valid;
};

/// Variance [s^2] of the kernel under which a signal reaches the regression besides its block mean: the
/// triangle of interpolation between its samples, and the box of every central difference.
double kernel_variance(const recording::Signal& signal, const Grid& grid, int derivatives);

/// Interpolated, without outliers, averaged over blocks of a sample of the flight. `more` [s^2]: variance to
/// add to the signal's kernel.
Channel on_grid(const recording::Signal& signal, const Grid& grid, const Options& options, double more = 0);

/// Where the grid lies in any of these windows.
std::vector<char> in_windows(const std::vector<Window>& windows, const Grid& grid);

std::vector<char> negated(const std::vector<char>& flags);

/// Which samples of a grid are used; those that are not lie in windows that say why.
class UsedSamples {
 public:
  explicit UsedSamples(const Grid& grid) : grid_(grid), use_(grid.t.size(), 1) {}

  /// Takes out where `bad` holds, with a margin on both sides.
  void exclude(const std::vector<char>& bad, double margin_s, const std::string& why);
  /// Adds the windows where `bad` holds, and takes nothing out.
  void list(const std::vector<char>& bad, const std::string& why);
  /// Takes out both ends of the grid, without a window.
  void exclude_ends(double margin_s);

  const std::vector<char>& flags() const { return use_; }
  const std::vector<Window>& windows() const { return windows_; }

 private:
  const Grid& grid_;
  std::vector<char> use_;
  std::vector<Window> windows_;
};

}  // namespace omniflight::diagnosis
