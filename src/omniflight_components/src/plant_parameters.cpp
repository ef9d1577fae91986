#include "plant_parameters.hpp"

#include "conversions.hpp"

#include "omniflight_diagnosis/neighbour_file.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::components {
namespace {

/// A neighbour blows, whether the model says how strongly or not.
void add_downwash(physics::Model& model) {
  const physics::Effect* const downwash = physics::find_effect(physics::effect_id::neighbour_downwash);
  for (const auto& e : model.effects)
    if (e.effect == downwash) return;
  physics::ActiveEffect blows{downwash, {}};
  for (const auto& p : downwash->info().parameters) blows.theta.push_back(p.typical);
  model.effects.push_back(std::move(blows));
}

}  // namespace

Result<PlantParameters> read_plant_parameters(bus::Parameters& p) {
  PlantParameters out;
  const std::string vehicle_name = p.text("vehicle", {});
  const std::string overrides = p.text("vehicle_set", "");
  const std::string model = p.text("model", "");
  const std::string sensors = p.text("sensors", "");
  const std::string neighbours = p.text("neighbours", "");
  out.seed = static_cast<std::uint64_t>(p.integer("seed", 1, 0));
  out.plant.seed = out.seed;
  out.plant.step = p.number("step_s", 0.001, 1e-5, 0.02);
  out.control_period = p.number("control_period_s", 0.002, 1e-4, 0.1);
  out.hold = p.number("hold_s", 1.0, 0.0, 60.0);
  out.duration = p.number("duration_s", 10.0, 0.01, 36000.0);
  out.peers_timeout = p.number("peers_timeout_s", 20.0, 0.1, 600.0);
  const auto position = p.numbers("initial_position_m", std::vector<double>{0, 0, 1}, 3);
  const auto rpy = p.numbers("initial_rpy_deg", std::vector<double>{0, 0, 0}, 3);
  const double alpha_deg = p.number("initial_alpha_deg", 30.0, -180, 180);
  out.plant.environment.floor_z = p.number("floor_z_m", 0.0, -100, 100);
  if (auto ok = p.finish(); !ok) return Failure(ok.error());
  if (position.size() == 3) out.plant.initial.p_WB = Vec3(position[0], position[1], position[2]);
  if (rpy.size() == 3)
    out.plant.initial.q_WB =
        from_roll_pitch_yaw(Vec3(to_radians(rpy[0]), to_radians(rpy[1]), to_radians(rpy[2])));
  auto vehicle = vehicle::load_vehicle(vehicle_name, split(overrides));
  if (!vehicle) return Failure(vehicle.error());
  out.vehicle = std::move(*vehicle);
  out.plant.initial_alpha =
      out.vehicle.tilt.kind == vehicle::TiltKind::none
          ? 0.0
          : std::clamp(to_radians(alpha_deg), out.vehicle.tilt.min, out.vehicle.tilt.max);
  if (!model.empty()) {
    auto loaded = physics::load_model(model);
    if (!loaded) return Failure(loaded.error());
    out.model = std::move(*loaded);
  }
  for (const std::string& file : split(neighbours)) {
    auto track = diagnosis::load_neighbour(file, {}, 0.0);  // over simulated time
    if (!track) return Failure(track.error());
    out.plant.neighbours.push_back(std::move(*track));
  }
  if (!out.plant.neighbours.empty()) add_downwash(out.model);
  if (!sensors.empty()) {
    auto yaml = files::YamlReader::load(sensors);
    if (!yaml) return Failure(yaml.error());
    if (yaml->string("schema") != "omniflight.sensors/1")
      yaml->error_at("schema", "is not omniflight.sensors/1");
    out.sensors = simulation::read_sensor_config(*yaml);
    if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  }
  const double ratio = out.control_period / out.plant.step;
  if (std::abs(ratio - std::round(ratio)) > 1e-6 || ratio < 0.999)
    return bad_input("control_period_s is no whole multiple of step_s", "simulator.control_period_s");
  return out;
}

Status make_plant(const PlantParameters& p, std::optional<simulation::Plant>& plant,
                  std::optional<simulation::SensorSuite>& sensors) {
  auto made = simulation::Plant::create(p.vehicle, p.model, p.plant);
  if (!made) return Failure(made.error());
  plant.emplace(std::move(*made));
  sensors.emplace(p.sensors, p.model, p.plant.step, p.seed);
  return {};
}

}  // namespace omniflight::components
