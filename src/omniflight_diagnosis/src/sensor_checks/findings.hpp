// What the stages beside the wrench found, in the terms of the answer, and a summary in words.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

Finding finding_of(const SensorFault& fault);

/// Whether the effect is among the findings so far.
bool is_named(const Diagnosis& d, const std::string& effect);

/// Sensors that were found to lie, as findings; what was cut out for it gives the windows.
void add_faults(const std::vector<SensorFault>& faults, const std::vector<Window>& excluded, Diagnosis& d);

/// An effect of sensing or of the motors with its mismatch: off by so much, where `noise` is one standard
/// error.
void add_sensor(Diagnosis& d, const char* id, const std::string& channel, const char* unit,
                const std::string& sentence, std::vector<ParameterValue> parameters, double off,
                double noise);

/// A rotor whose telemetry reads low by a share e seems to lift 2 e more than its speed says: once its sensor
/// is named, that is no effect of its own, nor is what cannot be told apart from it on the same rotor.
void drop_what_a_sensor_explains(Diagnosis& d);

std::string summarise(const Diagnosis& d, const std::vector<Flight>& flights);

}  // namespace omniflight::diagnosis
