#include "commanded_drives.hpp"

#include <algorithm>
#include <utility>

#include "omniflight_physics/actuators.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kFinest = 0.001, kCoarsest = 0.002;  ///< s, bounds of the step; chosen for run time

/// Commands delayed by late[rotor] seconds, averaged over each simulation step; rotors x steps.
void arriving(const CommandTrack& track, Between between, double step, Eigen::Index steps,
              const std::vector<double>& late, Eigen::MatrixXd& means) {
  means.resize(track.value.rows(), steps);
  for (Eigen::Index rotor = 0; rotor < means.rows(); ++rotor) {
    const auto command = track.value.row(rotor);
    std::size_t k = 0;
    double until_k = 0, before = 0;  // integrals of the command from its first sample on
    for (Eigen::Index i = -1; i < steps; ++i) {
      const double t = static_cast<double>(i + 1) * step - late[static_cast<std::size_t>(rotor)];
      const auto since_k = [&](double time) {
        const auto at = static_cast<Eigen::Index>(k);
        if (between == Between::held || k + 1 == track.t.size() || time < 0) return command[at] * time;
        const double slope = (command[at + 1] - command[at]) / (track.t[k + 1] - track.t[k]);
        return (command[at] + 0.5 * slope * time) * time;
      };
      while (k + 1 < track.t.size() && track.t[k + 1] <= t) {
        until_k += since_k(track.t[k + 1] - track.t[k]);
        ++k;
      }
      const double now = until_k + since_k(t - track.t[k]);
      if (i >= 0) means(rotor, i) = (now - before) / step;
      before = now;
    }
  }
}

}  // namespace

bool is_of_drives(const physics::EffectInfo& info) {
  return info.stage == physics::Stage::actuation &&
         info.channels == std::vector<std::string>{"rotor_speed"} && info.also.empty();
}

double drive_step(const vehicle::Vehicle& vehicle) {
  double quickest = kCoarsest;
  for (const vehicle::Rotor& rotor : vehicle.rotors)
    if (rotor.time_constant > 0) quickest = std::min(quickest, rotor.time_constant / 8);
  return std::max(kFinest, quickest);
}

bool simulate_drives(const vehicle::Vehicle& vehicle, physics::Actuation a, const CommandTrack& track,
                     Between between, double step, Eigen::Index steps, double late_s,
                     const Eigen::VectorXd& start, Eigen::MatrixXd& ends) {
  std::vector<double> late(a.delay.size(), late_s);
  for (std::size_t k = 0; k < late.size(); ++k) late[k] += std::exchange(a.delay[k], 0.0);
  for (double& tau : a.time_constant) tau = std::max(tau, step / 1.5);  // shortest lag that the step resolves
  auto drives = physics::Actuators::create(vehicle, std::move(a), step, 0.0);
  if (!drives) return false;
  thread_local Eigen::MatrixXd asked;  // an inference simulates the same record a thousand times
  arriving(track, between, step, steps, late, asked);
  ends.resize(asked.rows(), asked.cols() + 1);
  ends.col(0) = start;
  Eigen::VectorXd middle(asked.rows());
  for (Eigen::Index i = 0; i < asked.cols(); ++i) {
    drives->begin_step({asked.col(i).data(), vehicle.rotors.size()}, 0.0, 0.0);
    drives->reach(ends.col(i).data(), middle.data(), ends.col(i + 1).data());
  }
  return true;
}

}  // namespace omniflight::diagnosis
