// Wrench of drive effects in flights without recorded rotor speeds: rotor wrench of the altered drives minus
// that of the nominal drives, both simulated from the commands.
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

  /// Adds the segments of a flight, with samples spaced by `period` [s] and a prediction horizon of `lag`
  /// samples, see Horizon. Flights must be added in the order of their rows in RegressionProblem.
  void add(const Flight& flight, double period, int lag, bool reference_alone);

  /// Wrench [N, Nm, body axes, about the body origin] of an effect at theta over all samples, channel-major
  /// as in RegressionProblem. Rotor geometry is that of `measured`. With `predicted`, its conditional
  /// expectation given the samples up to the horizon (the instrument). Zero where theta gives invalid drives.
  Eigen::VectorXd operator()(const physics::Effect& effect, const std::vector<double>& theta, bool predicted,
                             const std::vector<physics::Situation>& measured) const;
  /// The same of commands that take effect `late_s` [s] later.
  Eigen::VectorXd of_delay(double late_s, bool predicted,
                           const std::vector<physics::Situation>& measured) const;

 private:
  struct Known;
  Eigen::VectorXd compute(const physics::Actuation& altered, bool predicted,
                          const std::vector<physics::Situation>& measured) const;
  /// Commands of a segment and the response of the nominal drives.
  struct Commanded {
    CommandTrack track = {};       ///< times count from its begin
    double from = 0;               ///< s, from the begin of the track to the first sample
    double width = 0;              ///< s, of the moving average of the speeds
    Eigen::MatrixXd squares = {};  ///< signed squares of speed [rad^2/s^2], samples x rotors
  };
  struct Part {
    int size = 0;  ///< samples
    Commanded recorded = {}, expected = {};
  };
  struct OfFlight {
    int size = 0;                                ///< samples
    std::vector<Part> parts = {};                ///< a segment; empty where speeds are recorded
    std::optional<LinearPrediction> ahead = {};  ///< of the rows of all parts
  };
  /// Simulated signed squares of speed [rad^2/s^2], samples x rotors; empty for invalid drives.
  Eigen::MatrixXd squares(const Commanded& commands, int size, const physics::Actuation& actuation) const;
  /// Wrench of altered minus nominal drives, samples x 6; zero for invalid drives.
  Eigen::MatrixXd difference(const Commanded& commands, const physics::Actuation& actuation,
                             std::span<const physics::Situation> measured) const;

  vehicle::Vehicle vehicle_;
  double step_;        ///< s, of the simulation of drives
  double period_ = 0;  ///< s, of the samples
  std::vector<OfFlight> flights_;
  std::shared_ptr<Known> known_;  ///< cache: a line search repeats the evaluations of the Jacobian
};

}  // namespace omniflight::diagnosis
