// Whether the motion resonates in what the rotors do: arms that bend, a battery that is loose, an inertial
// sensor on a soft mount.
#pragma once

#include <optional>

#include "rotor_regression.hpp"

namespace omniflight::diagnosis {

/// The motion follows T + share (T - G T), with the rotor wrench T and G = wn^2 / (s^2 + 2 zeta wn s + wn^2).
/// A mass that is `share` of the rest and hangs on a spring makes the rest move like that; a sensor on a soft
/// mount has a negative share (EffectInfo of structural_mode).
struct StructuralResonance {
  double frequency_hz = 0, frequency_se = 0, damping = 0;
  double share = 0;       ///< 1, of the axis where it is clearest
  double log_factor = 0;  ///< nat, against a motion that follows at once
};

/// Frequencies of 5 to 35 Hz; every axis of which the wrench explains 85 % has a share of its own, or none.
/// Empty below 3 s of samples, where rotors answer to the motion by more than their clock (`clock_s` [s], one
/// standard deviation) can be off, or where no resonance is likelier.
/// `temperature` divides the log-likelihood, for what else the regression has wrong (Options::temperature).
std::optional<StructuralResonance> structural_resonance(const RotorRegression& regression, double clock_s,
                                                        double temperature);

/// As a finding of structural_mode.
SensorFault as_fault(const StructuralResonance& resonance);

}  // namespace omniflight::diagnosis
