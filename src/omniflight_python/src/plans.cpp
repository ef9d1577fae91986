#include "omniflight_planning/plan.hpp"

#include "arrays.hpp"
#include "errors.hpp"
#include "module.hpp"

namespace py = pybind11;

namespace omniflight::python {
namespace {

using planning::Certificate;
using planning::Plan;

/// References at times, as arrays with one row a time.
py::dict sampled(const Trajectory& trajectory, const std::vector<double>& t) {
  const auto n = static_cast<Eigen::Index>(t.size());
  Eigen::MatrixXd p(n, 3), q(n, 4), v(n, 3), w(n, 3), a(n, 3), dw(n, 3);
  Eigen::VectorXd alpha(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Reference r = trajectory.sample(t[static_cast<std::size_t>(i)]);
    p.row(i) = r.p_WB;
    q.row(i) = wxyz(r.q_WB);
    v.row(i) = r.v_WB_W;
    w.row(i) = r.w_WB_B;
    a.row(i) = r.a_WB_W;
    dw.row(i) = r.dw_WB_B;
    alpha[i] = r.alpha;
  }
  py::dict out;
  out["position"] = p;
  out["attitude"] = q;
  out["velocity"] = v;
  out["angular_velocity"] = w;
  out["acceleration"] = a;
  out["angular_acceleration"] = dw;
  out["alpha"] = alpha;
  return out;
}

Trajectory from_knots(const std::vector<double>& t, const Eigen::MatrixXd& p, const Eigen::MatrixXd& q,
                      const Eigen::MatrixXd& v, const Eigen::MatrixXd& w, const Eigen::MatrixXd& a,
                      const Eigen::MatrixXd& dw, const std::vector<double>& alpha) {
  const auto n = static_cast<Eigen::Index>(t.size());
  const auto fits = [&](const char* name, const Eigen::MatrixXd& m, Eigen::Index width, bool needed) {
    if (m.size() == 0 && !needed) return;
    if (m.rows() != n || m.cols() != width)
      raise({ErrorCode::bad_input,
             "has the shape (" + std::to_string(m.rows()) + ", " + std::to_string(m.cols()) + ")",
             std::string("trajectory: ") + name,
             "Give (" + std::to_string(n) + ", " + std::to_string(width) + "), one row for each time"});
  };
  fits("position", p, 3, true);
  fits("attitude", q, 4, true);
  fits("velocity", v, 3, false);
  fits("angular_velocity", w, 3, false);
  fits("acceleration", a, 3, false);
  fits("angular_acceleration", dw, 3, false);
  if (!alpha.empty() && alpha.size() != t.size())
    raise({ErrorCode::bad_input, "has " + std::to_string(alpha.size()) + " numbers", "trajectory: alpha",
           "Give one tilt [rad] for each time"});
  std::vector<TrajectoryKnot> knots(t.size());
  const auto row = [](const Eigen::MatrixXd& m, Eigen::Index i) -> Vec3 {
    return m.size() == 0 ? Vec3(Vec3::Zero()) : Vec3(m.row(i).transpose());
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    TrajectoryKnot& k = knots[static_cast<std::size_t>(i)];
    k.t = t[static_cast<std::size_t>(i)];
    k.reference.p_WB = row(p, i);
    k.reference.q_WB = quaternion(q.row(i).transpose());
    k.reference.v_WB_W = row(v, i);
    k.reference.w_WB_B = row(w, i);
    k.reference.a_WB_W = row(a, i);
    k.reference.dw_WB_B = row(dw, i);
    if (!alpha.empty()) k.reference.alpha = alpha[static_cast<std::size_t>(i)];
  }
  return take(Trajectory::create(std::move(knots)));
}

void add_trajectory(py::module_& m) {
  const Eigen::MatrixXd none;
  py::class_<Trajectory>(m, "Trajectory",
                         "A timed 6D trajectory, twice continuously differentiable; constant.")
      .def(py::init(&from_knots), py::arg("t_s"), py::arg("position"), py::arg("attitude"),
           py::arg("velocity") = none, py::arg("angular_velocity") = none, py::arg("acceleration") = none,
           py::arg("angular_acceleration") = none, py::arg("alpha") = std::vector<double>{},
           "Through knots at t_s (n,) [s], from 0 on: position (n, 3) [m, world], attitude (n, 4) [w, x, y, "
           "z; "
           "world <- body], velocity (n, 3) [m/s, world], angular velocity (n, 3) [rad/s, body], their "
           "derivatives, and tilt (n,) [rad]; what is not given is zero. Raises Error.")
      .def_property_readonly("duration_s", &Trajectory::duration, "s")
      .def_property_readonly(
          "knot_times_s",
          [](const Trajectory& trajectory) {
            std::vector<double> t;
            for (const auto& k : trajectory.knots()) t.push_back(k.t);
            return py::array_t<double>(static_cast<py::ssize_t>(t.size()), t.data());
          },
          "(n,) times of the knots [s]")
      .def("sample", &sampled, py::arg("t_s"),
           "{name: array} at times t_s (n,) [s]: position (n, 3) [m], attitude (n, 4), velocity [m/s] and "
           "acceleration [m/s^2] in world axes, angular_velocity [rad/s] and angular_acceleration [rad/s^2] "
           "in "
           "body axes, alpha (n,) [rad]. Before the start and after the end it holds the end pose.");
}

void add_plan(py::module_& m) {
  py::class_<Plan>(m, "Plan", "A trajectory with a certificate of what was checked.")
      .def_readonly("trajectory", &Plan::trajectory)
      .def_property_readonly(
          "verdict", [](const Plan& p) { return p.certificate.verdict; }, "certified | rejected")
      .def_property_readonly("mission", [](const Plan& p) { return p.certificate.mission; })
      .def_property_readonly("vehicle", [](const Plan& p) { return p.certificate.vehicle; })
      .def_property_readonly(
          "duration_s", [](const Plan& p) { return p.certificate.duration; }, "s")
      .def_property_readonly(
          "alpha_rad", [](const Plan& p) { return p.certificate.alpha; }, "rad, at the start")
      .def_property_readonly(
          "min_clearance_m", [](const Plan& p) { return p.certificate.min_clearance; },
          "m, least distance to an occupied voxel")
      .def_property_readonly(
          "rotor_load", [](const Plan& p) { return p.certificate.peak.rotor_load; },
          "largest share of the rotors' range; 1 is the limit")
      .def(
          "write",
          [](const Plan& p, const std::filesystem::path& dir) { take(planning::write_plan(p, dir)); },
          py::arg("folder"), "Writes trajectory.json, trajectory.csv and certificate.json. Raises Error.")
      .def(
          "explain", [](const Plan& p) { return planning::explain(Result<Plan>(p)); },
          "A few sentences: what was planned and how near the limits it comes.");
  m.def(
      "_plan",
      [](const std::string& mission, const std::string& vehicle, const std::vector<std::string>& set,
         std::optional<std::uint64_t> seed, std::optional<double> budget_s) {
        planning::PlanOptions options;
        options.vehicle = vehicle;
        options.set = set;
        options.seed = seed;
        options.budget_s = budget_s;
        options.stop = interrupt_wanted;
        begin_interruptible();
        auto plan = unlocked([&]() -> Result<Plan> {
          const auto loaded = planning::load_mission(mission);
          if (!loaded) return Failure(loaded.error());
          return planning::plan_mission(*loaded, options);
        });
        raise_interrupt();
        return take(std::move(plan));
      },
      py::arg("mission"), py::arg("vehicle"), py::arg("set"), py::arg("seed"), py::arg("budget_s"));
  m.def(
      "read_plan", [](const std::filesystem::path& dir) { return take(planning::read_plan(dir)); },
      py::arg("folder"), "Reads what Plan.write() or the command wrote. Raises Error.");
}

}  // namespace

void add_plans(py::module_& m) {
  add_trajectory(m);
  add_plan(m);
}

}  // namespace omniflight::python
