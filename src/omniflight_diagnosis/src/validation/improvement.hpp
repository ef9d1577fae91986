// How much better a model predicts with the effects than without: always before beside after, a channel each.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// The flight with only the samples inside (or only those outside) [from_s, to_s).
Flight part_of(const Flight& flight, double from_s, double to_s, bool inside);

inline constexpr int kThirds = 3;

/// A third of a flight, and what is left without it.
struct Third {
  std::string name;
  Flight block, rest;
};
/// The third k of 0, 1 and 2; nothing where it or the rest has less than so many usable seconds.
std::optional<Third> third_of(const Flight& flight, int k, double least_block_s, double least_rest_s);

/// Mass and inertia times measured acceleration: what all forces and torques on the body come to. N and Nm.
Vec6 measured_wrench(const physics::Situation& situation);

/// RMS and share explained of the first so many channels of a measured wrench, then of the specific force
/// [m/s^2], by what is left of it before and after. Rows are channel-major.
std::vector<ChannelFit> channel_fits(const std::string& name, const Eigen::VectorXd& measured,
                                     const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                                     int channels, double mass);

/// RMS of the tracking error [m] by axis; empty where none was recorded.
std::map<std::string, double> tracking_rms_of(const Flight& flight);

}  // namespace omniflight::diagnosis
