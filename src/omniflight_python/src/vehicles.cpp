#include "arrays.hpp"
#include "errors.hpp"
#include "module.hpp"
#include "omniflight_allocation/actuation.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace py = pybind11;

namespace omniflight::python {
namespace {

using vehicle::Rotor;
using vehicle::Vehicle;

const char* tilt_kind(const Vehicle& v) {
  switch (v.tilt.kind) {
    case vehicle::TiltKind::common:
      return "common";
    case vehicle::TiltKind::individual:
      return "individual";
    case vehicle::TiltKind::none:
      break;
  }
  return "none";
}

void add_rotor(py::module_& m) {
  py::class_<Rotor>(m, "Rotor", "One rotor, in body axes (x forward, y left, z up).")
      .def_property_readonly(
          "position_m", [](const Rotor& r) { return r.p_BR; }, "(3,) hub [m]")
      .def_property_readonly(
          "axis", [](const Rotor& r) { return r.axis_B; }, "(3,) unit thrust axis at tilt 0")
      .def_readonly("tilts", &Rotor::tilts)
      .def_property_readonly(
          "tilt_axis", [](const Rotor& r) { return r.tilt_axis_B; }, "(3,) unit")
      .def_readonly("spin", &Rotor::spin, "+1: positive thrust exerts its reaction torque along the axis")
      .def_readonly("thrust_coefficient", &Rotor::thrust_coefficient, "N/(rad/s)^2")
      .def_readonly("drag_ratio_m", &Rotor::drag_ratio, "m, reaction torque per thrust")
      .def_readonly("bidirectional", &Rotor::bidirectional)
      .def_readonly("min_thrust_N", &Rotor::min_thrust, "N, smallest magnitude that is held")
      .def_readonly("max_thrust_N", &Rotor::max_thrust, "N, largest magnitude")
      .def_readonly("radius_m", &Rotor::radius, "m")
      .def_readonly("time_constant_s", &Rotor::time_constant, "s, first-order lag of the speed")
      .def("thrust", &Rotor::thrust, py::arg("speed_radps"), "Thrust [N] at a signed speed [rad/s].")
      .def("speed", &Rotor::speed, py::arg("thrust_N"), "Signed speed [rad/s] that gives a thrust [N].");
}

}  // namespace

void add_vehicles(py::module_& m) {
  add_rotor(m);
  py::class_<Vehicle>(m, "Vehicle", "A multirotor with fixed or tilting rotors; constant.")
      .def_readonly("name", &Vehicle::name)
      .def_readonly("file", &Vehicle::file, "the YAML it was loaded from")
      .def_readonly("sha256", &Vehicle::sha256)
      .def_readonly("mass_kg", &Vehicle::mass, "kg")
      .def_property_readonly(
          "inertia_kgm2", [](const Vehicle& v) { return v.inertia; },
          "(3, 3) about the centre of mass, body axes [kg m^2]")
      .def_property_readonly(
          "center_of_mass_m", [](const Vehicle& v) { return v.center_of_mass; }, "(3,) [m]")
      .def_readonly("rotors", &Vehicle::rotors, "list of Rotor")
      .def_readonly("provenance", &Vehicle::provenance, "dict of str: which figure is from where")
      .def_property_readonly("tilt_kind", &tilt_kind, "none | common | individual")
      .def_property_readonly(
          "tilt_range_rad", [](const Vehicle& v) { return std::make_pair(v.tilt.min, v.tilt.max); },
          "(lowest, highest) tilt [rad]")
      .def_property_readonly(
          "tilt_time_constant_s", [](const Vehicle& v) { return v.tilt.time_constant; },
          "s, first-order lag of the tilt servo; 0 = ideal")
      .def_property_readonly(
          "tilt_backlash_rad", [](const Vehicle& v) { return v.tilt.backlash; },
          "rad, full width of the play between servo and rotors")
      .def_property_readonly("bounding_radius_m", &Vehicle::bounding_radius, "m, about the body origin")
      .def("rotor_axis", &Vehicle::rotor_axis, py::arg("rotor"), py::arg("alpha_rad"),
           "(3,) unit thrust axis of a rotor at a tilt [rad], body frame.")
      .def(
          "allocation_matrix",
          [](const Vehicle& v, double alpha) -> Eigen::MatrixXd { return v.allocation_matrix(alpha); },
          py::arg("alpha_rad") = 0.0,
          "(6, n) force [N] and torque [Nm] about the body origin for each newton of every rotor, body axes.")
      .def(
          "actuation",
          [](const Vehicle& v) {
            return take(unlocked([&] { return allocation::classify_actuation(v); })).words();
          },
          "How it is actuated over its tilt, in words. Raises Error.")
      .def("__repr__", [](const Vehicle& v) {
        return "<Vehicle " + v.name + ": " + std::to_string(v.mass) + " kg, " +
               std::to_string(v.rotor_count()) + " rotors>";
      });
  m.def(
      "_load_vehicle",
      [](const std::string& spec, const std::vector<std::string>& set) {
        return take(vehicle::load_vehicle(spec, set));
      },
      py::arg("spec"), py::arg("set"));
  m.def("vehicle_names", &vehicle::vehicle_names, "Names under configs/vehicles.");
}

}  // namespace omniflight::python
