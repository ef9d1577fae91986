// The bends of one more law beside a fit: where a search for all its parameters should begin.
#pragma once

#include "fit.hpp"
#include "unknowns.hpp"

namespace omniflight::diagnosis {

/// For any bends the amplitudes are solved for within their bounds, everything else linearised once.
class ShapeSearch {
 public:
  ShapeSearch(const Problem& problem, const Fit& base, const physics::Effect& effect);

  /// Whether nearby() does anything for a law: it has two bends, and no replay, which is slow.
  static bool bends_together(const physics::Effect& effect);
  /// With these bends, and no search.
  void take(const std::vector<double>& theta);
  /// One bend after another over its bounds, the others as they are by then.
  void over_bounds();
  /// The same near bends that were found on much the same flight: a few steps of that grid to each side.
  void around(const std::vector<double>& theta);
  /// From there in ever smaller steps: two bends together, such as the end of a rope and its length, lead a
  /// search along derivatives astray where the law has a kink.
  void nearby();

  /// The best parameters met, amplitudes and bends.
  std::vector<double> best() const;

 private:
  bool is_amplitude(std::size_t k) const { return !is_shape(effect_.info().parameters[k]); }
  /// Bends that explain more than what was met before are kept.
  void consider(const std::vector<double>& theta, bool remember);
  Eigen::MatrixXd columns_at(const std::vector<double>& theta);
  double value_at(std::size_t shape, double share) const;
  double share_at(std::size_t shape, double value) const;

  const Problem& problem_;
  const physics::Effect& effect_;
  const bool heavy_;
  std::vector<std::size_t> shapes_;
  std::vector<Eigen::Index> free_;     ///< parameters that are amplitudes
  Eigen::Index rest_size_ = 0;         ///< unknowns beside this effect
  Eigen::VectorXd x_, lower_, upper_;  ///< this effect's amplitudes first, then everything else
  Eigen::MatrixXd jacobian_, Z_, H_;
  Eigen::VectorXd target_, g_;
  std::vector<double> theta_, amplitudes_;
  double gain_ = -1;
};

}  // namespace omniflight::diagnosis
