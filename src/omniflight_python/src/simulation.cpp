#include "arrays.hpp"
#include "closed_loop.hpp"
#include "errors.hpp"
#include "module.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"
#include "omniflight_report/flight_metrics.hpp"
#include "omniflight_simulation/plant.hpp"

namespace py = pybind11;

namespace omniflight::python {
namespace {

using simulation::Plant;

Plant make_plant(const vehicle::Vehicle& vehicle, const physics::Model& model, double step,
                 const Vec3& position, const Eigen::Vector4d& attitude, double alpha, std::uint64_t seed) {
  simulation::PlantConfig config;
  config.step = step;
  config.initial.p_WB = position;
  config.initial.q_WB = quaternion(attitude);
  config.initial_alpha = alpha;
  config.seed = seed;
  return take(Plant::create(vehicle, model, config));
}

void add_plant(py::module_& m) {
  py::class_<Plant>(m, "Plant", "Rigid body, rotors and the effects of a model, stepped by the caller.")
      .def(py::init(&make_plant), py::arg("vehicle"), py::arg("model") = physics::Model{}, py::kw_only(),
           py::arg("step_s") = 0.001, py::arg("position_m") = Vec3(Vec3::Zero()),
           py::arg("attitude") = Eigen::Vector4d(1, 0, 0, 0), py::arg("alpha_rad") = 0.0, py::arg("seed") = 1,
           "At rest at a pose (world; w, x, y, z) and a tilt [rad]. Raises Error for what is not physical.")
      .def(
          "set_command",
          [](Plant& p, const std::vector<double>& speed, double alpha) {
            if (!p.set_command(speed, alpha))
              raise(
                  {ErrorCode::bad_input, "a command is not finite, or not one a rotor", "plant: set_command",
                   "Give " + std::to_string(p.vehicle().rotor_count()) + " speeds [rad/s] and a tilt [rad]"});
          },
          py::arg("rotor_speed_radps"), py::arg("alpha_rad") = 0.0,
          "Speeds (n,) [rad/s, signed] and tilt [rad] from now on, kept within the limits.")
      .def(
          "step",
          [](Plant& p, int steps, bool held) {
            for (int i = 0; i < steps; ++i) take(p.step(held));
          },
          py::arg("steps") = 1, py::arg("held") = false,
          "So many steps of step_s; while held only the rotors turn. Raises Error when it leaves every "
          "range.")
      .def_property_readonly("time_s", &Plant::time, "s")
      .def_property_readonly(
          "position_m", [](const Plant& p) { return p.body().p_WB; }, "(3,) [m, world]")
      .def_property_readonly(
          "attitude", [](const Plant& p) { return wxyz(p.body().q_WB); }, "(4,) w x y z")
      .def_property_readonly(
          "velocity_mps", [](const Plant& p) { return p.body().v_WB_W; }, "(3,) [m/s, world]")
      .def_property_readonly(
          "angular_velocity_radps", [](const Plant& p) { return p.body().w_WB_B; }, "(3,) [rad/s, body]")
      .def_property_readonly(
          "rotor_speed_radps",
          [](const Plant& p) -> Eigen::VectorXd {
            const auto s = p.rotor_speed();
            return Eigen::Map<const Eigen::VectorXd>(s.data(), static_cast<Eigen::Index>(s.size()));
          },
          "(n,) [rad/s, signed]")
      .def_property_readonly("alpha_rad", &Plant::alpha, "rad")
      .def_property_readonly("specific_force_mps2", &Plant::specific_force, "(3,) [m/s^2, body]")
      .def_property_readonly(
          "effect_wrench", [](const Plant& p) { return p.effect_wrench(); },
          "(6,) wrench of all effects [N, Nm, body]")
      .def_property_readonly("mechanical_power_W", &Plant::mechanical_power, "W");
}

simulation::SensorConfig sensors_of(const std::string& name) {
  if (name.empty()) return {};
  std::filesystem::path path = name;
  if (name.find('/') == std::string::npos && path.extension() != ".yaml")
    path = take(files::config_dir()) / "sensors" / (name + ".yaml");
  auto yaml = take(files::YamlReader::load(path));
  if (yaml.has("schema")) (void)yaml.string("schema");
  const auto config = simulation::read_sensor_config(yaml);
  take(yaml.finish());
  return config;
}

void take_gains(const std::map<std::string, Vec3>& given, control::ControllerConfig& gains) {
  const std::pair<const char*, Vec3*> known[] = {{"kp", &gains.kp}, {"kv", &gains.kv}, {"ki", &gains.ki},
                                                 {"kR", &gains.kR}, {"kw", &gains.kw}, {"kI", &gains.kI}};
  for (const auto& [name, value] : given) {
    const auto* found =
        std::find_if(std::begin(known), std::end(known), [&](const auto& k) { return name == k.first; });
    if (found == std::end(known))
      raise({ErrorCode::bad_input, "there is no such gain", "simulate: gains." + name,
             "Name kp [1/s2], kv [1/s], ki [1/s3], kR [1/s2], kw [1/s] or kI [1/s3]"});
    if (!value.allFinite() || value.minCoeff() < 0)
      raise({ErrorCode::bad_input, "has a number that is negative or not finite", "simulate: gains." + name,
             "Give three numbers of 0 or more"});
    *found->second = value;
  }
}

}  // namespace

void add_simulation(py::module_& m) {
  add_plant(m);
  m.def(
      "_simulate",
      [](const vehicle::Vehicle& vehicle, const Trajectory& trajectory, const physics::Model& model,
         const std::string& sensors, const std::map<std::string, Vec3>& gains, double hold_s,
         std::uint64_t seed) {
        LoopOptions options;
        options.sensors = sensors_of(sensors);
        options.hold_s = hold_s;
        options.seed = seed;
        control::ControllerConfig tried;
        take_gains(gains, tried);  // a wrong name is told before anything flies
        options.gains = [&gains](control::ControllerConfig& c) { take_gains(gains, c); };
        options.stop = interrupt_wanted;
        begin_interruptible();
        auto flown = unlocked([&] { return fly(vehicle, model, trajectory, options); });
        raise_interrupt();
        return std::make_shared<recording::Recording>(take(std::move(flown)));
      },
      py::arg("vehicle"), py::arg("trajectory"), py::arg("model"), py::arg("sensors"), py::arg("gains"),
      py::arg("hold_s"), py::arg("seed"));
  m.def(
      "_assess",
      [](const recording::Recording& r, const vehicle::Vehicle& vehicle) {
        const auto f = take(report::assess(r, vehicle));
        py::dict out;
        out["window_s"] = std::make_pair(f.from, f.to);
        out["position_rmse_m"] = f.measured.position_rmse;
        out["attitude_rmse_deg"] = f.measured.attitude_rmse;
        out["worst_position_m"] = f.measured.worst_position;
        out["mean_power_W"] = f.mean_power;
        out["t_s"] = py::array_t<double>(static_cast<py::ssize_t>(f.measured.t.size()), f.measured.t.data());
        out["error"] = f.measured.error;
        return out;
      },
      py::arg("recording"), py::arg("vehicle"));
  m.def(
      "_compare",
      [](const recording::Recording& a, const recording::Recording& b, const vehicle::Vehicle& vehicle) {
        const auto simulated = take(report::assess(a, vehicle)), real = take(report::assess(b, vehicle));
        py::list out;
        for (const auto& row : report::compare(simulated, real))
          out.append(py::make_tuple(row.channel, row.unit, row.simulated, row.real, row.ratio()));
        return out;
      },
      py::arg("simulated"), py::arg("real"), py::arg("vehicle"));
}

}  // namespace omniflight::python
