// What each source of the module adds to it.
#pragma once

#include <pybind11/pybind11.h>

namespace omniflight::python {

void add_recordings(pybind11::module_& m);
void add_vehicles(pybind11::module_& m);
void add_effects(pybind11::module_& m);
void add_wrench_sets(pybind11::module_& m);
void add_plans(pybind11::module_& m);
void add_simulation(pybind11::module_& m);
void add_diagnosis(pybind11::module_& m);

}  // namespace omniflight::python
