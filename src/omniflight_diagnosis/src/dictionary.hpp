// Physics that is in no library: the few simplest terms in the vehicle's own state that still predict the
// rest.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fit.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_physics/correction.hpp"

namespace omniflight::diagnosis {

/// One term of a minimal correction: force or torque = coefficient * feature.
struct Term {
  int channel = 0;     ///< 0 to 5: Fx ... Mz
  bool world = false;  ///< force in world axes
  std::string words;   ///< "sideward speed squared"
  std::vector<std::string> variables;
  bool even = false;                         ///< the force stays when the first variable changes its sign
  double gain = 0;                           ///< log-likelihood when it entered
  double coefficient = 0;                    ///< N or Nm per unit of the feature
  std::string unit;                          ///< of the feature, "1" where it has none
  double frequency = 0;                      ///< Hz, of what pulsates
  Eigen::VectorXd value;                     ///< N or Nm, a sample
  std::optional<physics::Correction> model;  ///< as a simulator flies it; none of what follows accelerations
};

/// Forward selection over monomials of speed, rates, place, attitude, acceleration and rotors, bumps in space
/// and sines in time, in body and world axes, on the whitened residual. A term enters when its log-likelihood
/// exceeds ln(number of candidates / p). Meant for a problem on instruments: where feedback ties the state to
/// the disturbance, everything is predictable from it.
std::vector<Term> select_terms(const Problem& problem, const Eigen::VectorXd& residual,
                               const Options& options);

/// The same for the answer: one entry a channel and frame, the strongest first.
std::vector<Unexplained> as_unexplained(const Problem& problem, const std::vector<Term>& terms,
                                        const Eigen::VectorXd& residual);

}  // namespace omniflight::diagnosis
