// Disturbances that come and go: localised in time and place, whatever the vehicle's own state.
#pragma once

#include "fit.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

struct Burst {
  int flight = 0;
  double from_s = 0, to_s = 0;
  Vec3 place = Vec3::Zero();  ///< m, world, mean over the burst
  Vec3 force = Vec3::Zero();  ///< N, world, largest half-second mean
};

/// Stretches in which the half-second mean of the world force stands out of its own calm level (median
/// absolute deviation) by more than six times and by more than 3 % of the weight. Empty when they make up
/// more than 40 % of the flight: then it is no burst but a state of affairs.
std::vector<Burst> find_bursts(const Problem& problem, const Eigen::VectorXd& residual);

/// World force of every sample [N], n x 3, mean over half a second inside its run.
Eigen::MatrixXd slow_world_force(const Problem& problem, const Eigen::VectorXd& residual);

/// So close to the floor that it may lift: six radii of a rotor.
bool is_low(const physics::Situation& situation, double height);

/// Share of the slow force's energy inside the bursts that `after` no longer holds.
double explained_in_bursts(const Problem& problem, const Eigen::VectorXd& before,
                           const Eigen::VectorXd& after, const std::vector<Burst>& bursts);

/// An external force in words, for the report; empty without bursts.
void add_bursts(const Problem& problem, const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                Diagnosis& diagnosis);

}  // namespace omniflight::diagnosis
