// What effects between command and speed of a rotor do to the wrench of a flight whose speeds are not
// recorded: thrust of drives that they alter, less thrust of the drives that the vehicle file tells.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "../conditioning/commanded_drives.hpp"
#include "linear_prediction.hpp"

namespace omniflight::diagnosis {

class CommandedWrench {
 public:
  explicit CommandedWrench(const vehicle::Vehicle& vehicle);

  /// Adds a stretch of a flight, predicted over `lag` samples. Stretches are added in the order of their
  /// rows.
  void add(const Flight& flight, Segment segment, double period, int lag);

  /// Wrench [N, Nm] about the body origin, channel-major as in RegressionProblem, of an effect at theta
  /// beside rotors that are placed as in `measured`, all samples: of the speeds that the commands give, or,
  /// `predicted`, what is expected of it from the samples before.
  Eigen::VectorXd operator()(const physics::Effect& effect, const std::vector<double>& theta, bool predicted,
                             const std::vector<physics::Situation>& measured) const;

 private:
  struct Known;
  Eigen::VectorXd compute(const physics::Effect& effect, const std::vector<double>& theta, bool predicted,
                          const std::vector<physics::Situation>& measured) const;
  /// Commands of a stretch, and what the nominal drives make of them.
  struct Commanded {
    CommandTrack track = {};       ///< times after its begin
    double from = 0;               ///< s, from the begin of the track to the first sample
    double width = 0;              ///< s, over which speeds are averaged
    Eigen::MatrixXd squares = {};  ///< signed squares of speed [rad^2/s^2], samples x rotors
  };
  struct Part {
    int size = 0;                            ///< samples
    Commanded recorded = {}, expected = {};  ///< without commands where speeds are recorded
    std::optional<LinearPrediction> ahead = {};
  };
  /// Signed squares of speed of drives, samples x rotors; empty for drives that cannot be.
  Eigen::MatrixXd squares(const Commanded& commands, int size, const physics::Actuation& actuation) const;
  /// Wrench of altered drives less that of nominal ones, samples x 6; zero for drives that cannot be.
  Eigen::MatrixXd difference(const Commanded& commands, const physics::Actuation& actuation,
                             std::span<const physics::Situation> measured) const;

  vehicle::Vehicle vehicle_;
  double step_;        ///< s, of the simulation of drives
  double period_ = 0;  ///< s, of the samples
  std::vector<Part> parts_;
  std::shared_ptr<Known>
      known_;  ///< the last wrenches: a fit asks for the same again, line search and columns
};

}  // namespace omniflight::diagnosis
