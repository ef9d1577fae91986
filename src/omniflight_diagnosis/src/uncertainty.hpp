// How uncertain the values of a fit are, and how far its effects are from nothing.
#pragma once

#include "fit.hpp"

namespace omniflight::diagnosis {

struct Uncertainty {
  /// Standard errors of all effect parameters, in order: the larger of GLS and a block-robust estimate; 1e9
  /// where the flight says nothing.
  Eigen::VectorXd se;
  /// For every effect, how far all its numbers together are from nothing, as a normal score (Wald test; on
  /// instruments with the bends of all laws held). Where only a product is known, as of wind and drag, no
  /// number alone is away from nothing.
  std::vector<double> distance;
};

Uncertainty uncertainty_of(const Problem& problem, const Fit& fit);

}  // namespace omniflight::diagnosis
