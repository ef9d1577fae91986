// A hypothesis at values of its parameters.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace omniflight::diagnosis {

struct SetMember {
  int hypothesis = 0;         ///< index
  std::vector<double> theta;  ///< of an effect
  Eigen::VectorXd start;      ///< offsets of its memory, all windows
  Eigen::VectorXd weights;    ///< coefficients of a pattern
  /// Of the wrench of a law that is not linear: taken once, where a fit of it begins.
  std::optional<double> first_stage = {};
};

}  // namespace omniflight::diagnosis
