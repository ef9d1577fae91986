#include "omniflight_allocation/wrench_set.hpp"

#include <nlohmann/json.hpp>

#include "arrays.hpp"
#include "errors.hpp"
#include "module.hpp"
#include "omniflight_allocation/feasible_set.hpp"

namespace py = pybind11;

namespace omniflight::python {

using allocation::Polytope;
using allocation::WrenchSet;

void add_wrench_sets(py::module_& m) {
  py::class_<Polytope>(m, "Polytope", "A bounded convex body in three dimensions, possibly flat.")
      .def_readonly("dimension", &Polytope::dimension, "-1 when it is empty, 0 to 3 otherwise")
      .def_property_readonly(
          "vertices", [](const Polytope& p) { return rows_of(p.vertices); }, "(n, 3) corners")
      .def_property_readonly(
          "facets",
          [](const Polytope& p) {
            Eigen::MatrixXd out(static_cast<Eigen::Index>(p.facets.size()), 4);
            for (std::size_t i = 0; i < p.facets.size(); ++i)
              out.row(static_cast<Eigen::Index>(i)) << p.facets[i].normal.transpose(), p.facets[i].offset;
            return out;
          },
          "(n, 4) unit normal and offset: the points x with normal . x <= offset")
      .def_property_readonly(
          "inradius", [](const Polytope& p) { return allocation::measure(p).d_min_surface; },
          "radius of the largest ball about zero inside; 0 unless dimension is 3");
  py::class_<WrenchSet>(
      m, "WrenchSet", "Every wrench that a vehicle can exert at one tilt, torques about its centre of mass.")
      .def(py::init([](const vehicle::Vehicle& v, double alpha, double f_max) {
             return take(WrenchSet::create(v, alpha, f_max));
           }),
           py::arg("vehicle"), py::arg("alpha_rad") = 0.0, py::arg("f_max_N") = 0.0,
           "f_max_N [N] replaces the largest thrust of every rotor; 0 keeps the vehicle's. Raises Error.")
      .def_property_readonly("rank", &WrenchSet::rank, "6: force and torque can be chosen independently")
      .def("load", &WrenchSet::load, py::arg("wrench"),
           "Share of the rotors' ranges that a wrench (6,) [N, Nm; body axes] needs; 1 is the limit, inf: "
           "impossible.")
      .def("force_at_torque", &WrenchSet::force_at_torque, py::arg("torque_Nm") = Vec3(Vec3::Zero()),
           "Polytope of the forces [N] that leave exactly this torque (3,) [Nm].")
      .def("torque_at_force", &WrenchSet::torque_at_force, py::arg("force_N") = Vec3(Vec3::Zero()),
           "Polytope of the torques [Nm] that leave exactly this force (3,) [N].")
      .def("omnidirectional_force", &WrenchSet::omnidirectional_force,
           "Largest force [N] that can be exerted in every direction at zero torque.");
  m.def(
      "_design",
      [](const vehicle::Vehicle& v, const std::vector<double>& alphas, double f_max, double mass) {
        const auto result = take(unlocked([&] { return allocation::design(v, alphas, f_max, mass); }));
        nlohmann::json j;
        allocation::to_json(j, result);
        return j.dump();
      },
      py::arg("vehicle"), py::arg("alphas_rad"), py::arg("f_max_N"), py::arg("mass_kg"));
}

}  // namespace omniflight::python
