// Regressors that disturbances cannot have shaped: the flight as its reference alone makes it.
//
// In closed loop the rotors answer to what pushes the body, so that the measured state and the disturbance
// depend on each other and a regression finds effects in mere turbulence. The same flight without the
// disturbance depends on the reference only. Evaluated on it, columns are instruments: least squares of the
// measured residual on them is unbiased by feedback and its likelihood gains follow the usual distribution.
// Source: T. Soederstroem, P. Stoica, Instrumental Variable Methods for System Identification, 1983, ch. 4.
#pragma once

#include <optional>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// The flight with Flight::instrument, flown again by `refly` under a body wrench [N, Nm] (one row a grid
/// sample) that stands for the effects already known, and with motors as they were found. Segments shrink to
/// what was flown again and is not around the reversal of a rotor in either; those are listed as excluded. Of
/// a flight whose rotors reverse for more than a fifth of the time they stay in, and leave_out_reversals() is
/// possible. Empty when that flight is lost or covers less than two seconds.
std::optional<Flight> with_instruments(const Flight& flight, const Eigen::MatrixXd& wrench,
                                       const std::vector<physics::ActiveEffect>& motors,
                                       const vehicle::Vehicle& vehicle, const Options& options,
                                       const Reflight& refly);

/// Keeps what is between reversals only, where that is enough; false where nothing changes.
bool leave_out_reversals(Flight& flight);

}  // namespace omniflight::diagnosis
