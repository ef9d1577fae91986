// Final values of named effects by the method of instrumental variables.
#pragma once

#include <optional>

#include "fit.hpp"

namespace omniflight::diagnosis {

/// The search regresses the measured residual on what the effects do along the flight that was flown again.
/// Where that flight is quicker or slower than the measured one, every value comes out small or large by as
/// much. Here the effects are evaluated on the measured flight, and the instruments only weigh: Z'W(y - X
/// theta) = 0 with Z from `instruments`, X from `measured` (same rows). Bends of laws stay. Values and
/// standard errors (Fit::se: the larger of model and blocks) in the units of the parameters; nothing where
/// the instruments are weak or the values would leave what makes sense. `near_zero`: prior standard
/// deviations of the offsets for the values, as in settle(); `se`: errors of the search, kept for what the
/// instruments do not move. Soderstrom, Stoica: Instrumental Variable Methods for System Identification
/// (1983).
std::optional<Fit> by_instruments(const Problem& instruments, const Problem& measured, const Fit& fit,
                                  const Eigen::VectorXd& near_zero, const Eigen::VectorXd& se);

}  // namespace omniflight::diagnosis
