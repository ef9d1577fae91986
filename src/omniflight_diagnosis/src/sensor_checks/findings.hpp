// Findings of the stages other than the wrench, and the summary.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// A sensor fault as a finding; its probability is not set.
Finding finding_of(const SensorFault& fault);

/// Whether the effect is among the findings.
bool is_named(const Diagnosis& d, const std::string& effect);

/// Adds sensor faults as findings with mismatches; `excluded` windows whose reason names the channel are
/// attached.
void add_faults(const std::vector<SensorFault>& faults, const std::vector<Window>& excluded, Diagnosis& d);

/// Adds an effect of sensing or actuation with its mismatch: deviation `off` with standard error `noise`,
/// both in `unit`.
void add_sensor(Diagnosis& d, const char* id, const std::string& channel, const char* unit,
                const std::string& sentence, std::vector<ParameterValue> parameters, double off,
                double noise);

/// Removes the first rotor_thrust_scale, or rival of it, that a speed sensor fault of the same rotor
/// explains: a speed that reads 1 + e times the true one appears as a thrust scale of 1 / (1 + e)^2.
void drop_what_a_sensor_explains(Diagnosis& d);

/// Summary in sentences; notes are those of the first flight that has any.
std::string summarise(const Diagnosis& d, const std::vector<Flight>& flights);

}  // namespace omniflight::diagnosis
