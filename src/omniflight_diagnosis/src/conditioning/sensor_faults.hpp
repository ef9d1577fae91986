// Sensors that lie: stuck rotor speeds and a battery voltage that never moves.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Rotor speeds that hold one value (or zero) for long while other rotors vary, and a frozen battery voltage.
/// In more than 3 s, not by a microvolt.
bool voltage_never_changes(const recording::Recording& recording);
std::vector<SensorFault> find_sensor_faults(const recording::Recording& recording);

/// Samples of the time grid in which the rotor of a fault ("rotor3_speed") is stuck.
std::vector<char> frozen_samples(const recording::Signal& rotor_speed, const std::string& channel,
                                 const std::vector<double>& t_s);

}  // namespace omniflight::diagnosis
