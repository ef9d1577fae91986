// How much better a model predicts with the effects than without: always before beside after, a channel each.
#pragma once

#include "fit.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// The flight with only the samples inside (or only those outside) [from_s, to_s).
Flight part_of(const Flight& flight, double from_s, double to_s, bool inside);

/// RMS of the wrench that is left [N, Nm], on what was fitted.
std::vector<ChannelFit> on_fitted(const Problem& problem, const Eigen::VectorXd& rest);

/// On flights that were not fitted: RMS and share explained of body wrench and specific force [m/s^2].
std::vector<ChannelFit> on_unseen(const std::vector<Flight>& unseen, const vehicle::Vehicle& vehicle,
                                  const std::vector<physics::ActiveEffect>& effects, const Options& options);

/// The same on thirds of a single flight, each predicted by a fit to the other two.
std::vector<ChannelFit> on_unseen_thirds(const Flight& flight, const vehicle::Vehicle& vehicle,
                                         const std::vector<physics::ActiveEffect>& effects,
                                         const Options& options);

/// What is left over a flight, before and after, for plots.
Series series_of(const Flight& flight, const vehicle::Vehicle& vehicle, const Options& options,
                 const std::vector<physics::ActiveEffect>& effects, const Eigen::VectorXd& offsets);

/// RMS of the tracking error [m] by axis; empty where none was recorded.
std::map<std::string, double> tracking_rms_of(const Flight& flight);

}  // namespace omniflight::diagnosis
