// Prediction errors without and with the effects, per channel.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// The flight restricted to samples inside (or outside) of [from_s, to_s) [s]; segments of 0.5 s or less are
/// dropped.
Flight part_of(const Flight& flight, double from_s, double to_s, bool inside);

inline constexpr int kThirds = 3;

/// A third of a flight, and the flight without it.
struct Third {
  std::string name;
  Flight block, rest;
};
/// Third k = 0, 1, 2; empty where it or the rest has fewer usable seconds than required.
std::optional<Third> third_of(const Flight& flight, int k, double least_block_s, double least_rest_s);

/// Measured wrench [N, Nm, body]: mass times specific force, J dw + w x J w.
Vec6 measured_wrench(const physics::Situation& situation);

/// RMS and coefficient of determination of the first `channels` channels of the wrench, then of the specific
/// force [m/s^2], from the measured wrench and the residuals before and after (channel-major); mass [kg].
std::vector<ChannelFit> channel_fits(const std::string& name, const Eigen::VectorXd& measured,
                                     const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                                     int channels, double mass);

/// RMS tracking error [m] by axis ("px", ...); empty without a reference.
std::map<std::string, double> tracking_rms_of(const Flight& flight);

}  // namespace omniflight::diagnosis
