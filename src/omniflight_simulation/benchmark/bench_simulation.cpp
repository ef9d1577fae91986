// The simulator beside the rigid-body engines of Debian. Prints one JSON line a comparison; the table is made
// by launch_scripts/benchmark.sh. Needs OMNIFLIGHT_CONFIGS or the workspace's top folder as working
// directory.
#include <memory>

#include "omniflight_simulation/batch.hpp"
#include "peers/peers.hpp"

namespace omniflight::benchmarks {
namespace {

using physics::Model;

Contender plant(const vehicle::Vehicle& vehicle, const std::string& name, const Model& model) {
  simulation::PlantConfig config;
  config.initial_alpha = 0.5;
  config.initial.p_WB.z() = 10;
  config.initial.w_WB_B = Vec3(0.1, 0.2, 0.3);
  auto made = simulation::Plant::create(vehicle, model, config);
  if (!made) return {name, {}, 1, made.error().text()};
  auto shared = std::make_shared<simulation::Plant>(*made);
  auto start = std::make_shared<const simulation::Plant>(std::move(*made));
  const double each = vehicle.mass * kGravity / (8 * std::cos(config.initial_alpha));
  const std::vector<double> speed(vehicle.rotors.size(), vehicle.rotors[0].speed(each));
  shared->set_command(speed, config.initial_alpha);
  return {name,
          [shared, start, config, speed](int n) {
            for (int k = 0; k < n; ++k) {
              if (shared->time() > 2) *shared = *start;  // before it tumbles out of the world
              shared->set_command(speed, config.initial_alpha);
              if (!shared->step()) std::abort();
            }
          },
          1,
          {}};
}

Contender batch(const vehicle::Vehicle& vehicle, const std::string& name, const Model& model, int count) {
  simulation::BatchConfig config;
  config.plant.initial_alpha = 0.5;
  config.plant.initial.p_WB.z() = 10;
  config.plant.initial.w_WB_B = Vec3(0.1, 0.2, 0.3);
  config.unsupported = simulation::BatchConfig::Unsupported::refuse;
  auto made =
      simulation::Batch::create(vehicle, std::vector<Model>(static_cast<std::size_t>(count), model), config);
  if (!made) return {name, {}, 1, made.error().text()};
  auto shared = std::make_shared<simulation::Batch>(std::move(*made));
  const double each = vehicle.mass * kGravity / (8 * std::cos(config.plant.initial_alpha));
  const std::vector<double> speed(vehicle.rotors.size(), vehicle.rotors[0].speed(each));
  return {name,
          [shared, speed, count](int n) {
            for (int k = 0; k < n; ++k) {
              if (shared->time() > 2) shared->reset();
              if (k % 2 == 0)  // commands come at 500 Hz
                for (int i = 0; i < count; ++i) shared->set_command(static_cast<std::size_t>(i), speed, 0.5);
              if (shared->step() < static_cast<std::size_t>(count)) std::abort();
            }
          },
          static_cast<double>(count),
          {}};
}

Model model(const std::vector<std::pair<std::string, std::vector<double>>>& effects) {
  Model m;
  for (const auto& [id, theta] : effects) m.effects.push_back({physics::find_effect(id), theta});
  return m;
}

/// Every effect of the library (or of the lanes) on body and rotors, at a hundredth of its typical values, so
/// that the vehicle stays in the world.
Model every(bool in_lanes) {
  Model m;
  for (const physics::Effect* e : physics::builtin_effects()) {
    if (in_lanes ? !simulation::flies_in_lanes(*e) : !e->acts_on_wrench()) continue;
    m.effects.push_back({e, {}});
    for (const auto& p : e->info().parameters)
      m.effects.back().theta.push_back(p.neutral == p.typical ? p.typical
                                                              : p.neutral + 0.01 * (p.typical - p.neutral));
  }
  return m;
}

int run() {
  const auto vehicle = vehicle::load_vehicle("omnimorph");
  if (!vehicle) {
    std::fprintf(stderr, "%s\n", vehicle.error().text().c_str());
    return 4;
  }
  pin_to_one_processor();
  const std::vector<Contender> engines{
      ode_free_body(*vehicle, false), ode_free_body(*vehicle, true), bullet_free_body(*vehicle),
      mujoco_free_body(*vehicle, MujocoIntegrator::euler), mujoco_free_body(*vehicle, MujocoIntegrator::rk4)};
  const Model some = model({{"tilt_efficiency", {0.34, 0.334}},
                            {"rotor_drag", {1e-5}},
                            {"parasitic_drag", {0.01}},
                            {"hung_cable", {0.1, 0, 5}}});
  compare("B-1", "single body, nominal", plant(*vehicle, "Plant", {}), engines, 1.0, 1.5);
  compare("B-1", "single body, 4 effects", plant(*vehicle, "Plant", some), {engines[0]}, 1.0, 1.5);
  compare("B-1", "single body, every effect", plant(*vehicle, "Plant", every(false)), {engines[0]}, 1.0, 1.5);
  compare("B-1", "one vehicle in a lane, nominal", batch(*vehicle, "Batch of 1", {}, 1), {engines[0]}, 1.0,
          1.5);
  compare("B-1", "one vehicle in a lane, 4 effects", batch(*vehicle, "Batch of 1", some, 1), {engines[0]},
          1.0, 1.5);
  compare("B-1", "one vehicle in a lane, every effect", batch(*vehicle, "Batch of 1", every(true), 1),
          {engines[0]}, 1.0, 1.5);
  compare("B-2", "64 vehicles in lanes, nominal", batch(*vehicle, "Batch of 64", {}, 64),
          {engines[0], engines[1]}, 8, 12);
  compare("B-2", "64 vehicles in lanes, nominal", batch(*vehicle, "Batch of 64", {}, 64), {engines[4]}, 200,
          0);
  compare("B-2", "64 vehicles in lanes, 4 effects", batch(*vehicle, "Batch of 64", some, 64), {engines[0]}, 8,
          12);
  compare("B-2", "64 vehicles in lanes, 4 effects", batch(*vehicle, "Batch of 64", some, 64), {engines[4]},
          200, 0);
  compare("B-2", "64 vehicles in lanes, every effect", batch(*vehicle, "Batch of 64", every(true), 64),
          {engines[0]}, 0, 0);
  const std::vector<Contender> chains{ode_chain(*vehicle, false), ode_chain(*vehicle, true),
                                      bullet_chain(*vehicle), mujoco_chain(*vehicle, MujocoIntegrator::euler),
                                      mujoco_chain(*vehicle, MujocoIntegrator::rk4)};
  compare("B-3", "20-link chain", chains[0], {chains[1], chains[2], chains[3], chains[4]}, 5, 10);
  return 0;
}

}  // namespace
}  // namespace omniflight::benchmarks

int main() { return omniflight::benchmarks::run(); }
