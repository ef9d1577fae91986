// A law that contains another one is no rival of it.
#pragma once

#include "fit.hpp"

namespace omniflight::diagnosis {

/// Whether `rich` can be exactly `named` on a flight: `contribution` of the named one lies in the span of the
/// `columns` of the other. Linear laws only.
bool contains_law(const physics::Effect& rich, const physics::Effect& named, const Eigen::MatrixXd& columns,
                  const Eigen::VectorXd& contribution);

/// True when the last effect of `swapped`, which stands in the place of member `index` of `fit`, can be
/// exactly that member, and the numbers it has beyond that would show on these flights if they did as much: a
/// thrust that changes with the tilt contains a thrust that is too weak, and once the tilt has moved it adds
/// nothing. On one tilt it stays a rival.
bool only_adds_freedom(const Problem& problem, const Fit& fit, std::size_t index, const Fit& swapped);

}  // namespace omniflight::diagnosis
