// Faults of rotor speed telemetry and of the battery voltage sensor.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Whether the battery voltage is constant within 1 uV over more than 3 s.
bool voltage_never_changes(const recording::Recording& recording);

/// Rotor speeds that are constant while the command and most other rotors vary, or whose scale deviates from
/// the other rotors at equal duty cycle (rotor_speed_sensor_fault); a constant battery voltage under varying
/// load (battery_sensor_fault).
std::vector<SensorFault> find_sensor_faults(const recording::Recording& recording);

/// Flags of the times t_s [s] at which the rotor that `channel` names ("rotor3_speed") is stuck.
std::vector<char> frozen_samples(const recording::Signal& rotor_speed, const std::string& channel,
                                 const std::vector<double>& t_s);

}  // namespace omniflight::diagnosis
