#include "module.hpp"

PYBIND11_MODULE(_native, m) {
  using namespace omniflight::python;
  m.doc() = "The omniflight libraries; see the package omniflight.";
  add_vehicles(m);
  add_effects(m);
  add_recordings(m);
  add_wrench_sets(m);
  add_plans(m);
  add_simulation(m);
  add_diagnosis(m);
}
