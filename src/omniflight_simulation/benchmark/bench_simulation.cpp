// The simulator beside the rigid-body engines of Debian. Prints one JSON line a comparison; the table is made
// by launch_scripts/benchmark.sh. Needs OMNIFLIGHT_CONFIGS or the workspace's top folder as working
// directory.
#include <memory>
#include <set>

#include "batch_contender.hpp"
#include "peers/peers.hpp"

namespace omniflight::benchmarks {
namespace {

using physics::Model;

Contender plant(const vehicle::Vehicle& vehicle, const std::string& name, const Model& model) {
  const simulation::PlantConfig config = tumbling_start();
  auto made = simulation::Plant::create(vehicle, model, config);
  if (!made) return {name, {}, 1, made.error().text()};
  auto shared = std::make_shared<simulation::Plant>(*made);
  auto start = std::make_shared<const simulation::Plant>(std::move(*made));
  const std::vector<double> speed = hover_speeds(vehicle, config.initial_alpha);
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
  return batch_contender<simulation::Batch, simulation::BatchConfig>(vehicle, name, model, count);
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
    if (in_lanes ? !simulation::flies_in_lanes(*e) : !e->acts_on_wrench() || e->memory_size().total() > 0)
      continue;
    if (e->info().id == "neighbour_downwash") continue;  // refused, since nobody else flies here
    m.effects.push_back({e, {}});
    for (const auto& p : e->info().parameters)
      m.effects.back().theta.push_back(p.neutral == p.typical ? p.typical
                                                              : p.neutral + 0.01 * (p.typical - p.neutral));
  }
  return m;
}

/// One law of each kind, as a flight may have them at once: `every` also has alternatives of one another
/// (five fidelities of a cable, two laws of the same downwash), which nobody would add up.
Model one_of_each_kind() {
  static const std::set<std::string> kinds{
      "payload_mass",  "com_offset",     "thrust_scale",   "drag_torque_scale",
      "rotor_drag",    "axial_inflow",   "blade_flapping", "downwash_interference",
      "ground_effect", "parasitic_drag", "rotor_inertia",  "wind",
      "hung_cable"};
  Model m = every(false);
  std::erase_if(m.effects, [](const auto& e) { return !kinds.contains(e.effect->info().id); });
  return m;
}

/// A vehicle on a chain of 20 nodes, as the physics library models it.
Contender chain(const vehicle::Vehicle& vehicle) {
  const physics::Effect* effect = physics::find_effect("cable_chain");
  if (!effect) return {"Plant", {}, 1, "the library has no chain yet"};
  Model m;
  m.effects.push_back({effect, {kCableMass / kCableLength, kCableLength, 0.0, 0.5, 0.2}});
  return plant(vehicle, "Plant with chain", m);
}

int run() {
  const auto loaded = vehicle::load_vehicle("omnimorph");
  if (!loaded) {
    std::fprintf(stderr, "%s\n", loaded.error().text().c_str());
    return 4;
  }
  const vehicle::Vehicle& v = *loaded;
  pin_to_one_processor();
  std::fprintf(stderr, "lanes run on %s\n", simulation::lane_instruction_set().c_str());
  // interference between the rotors, drag, tether: what a tethered flight has
  const Model tethered =
      model({{"tilt_efficiency", {0.34, 0.334}}, {"parasitic_drag", {0.01}}, {"hung_cable", {0.1, 0, 5}}});
  const Model bladed = model({{"tilt_efficiency", {0.34, 0.334}},
                              {"parasitic_drag", {0.01}},
                              {"hung_cable", {0.1, 0, 5}},
                              {"rotor_drag", {1e-5}}});
  const auto ode = [&] { return ode_free_body(v, false); };
  const auto mujoco = [&](MujocoOptions o) { return mujoco_free_body(v, MujocoIntegrator::rk4, o); };

  compare("B-1", "one plant, nominal", plant(v, "Plant", {}),
          {ode(), ode_free_body(v, true), bullet_free_body(v),
           mujoco_free_body(v, MujocoIntegrator::euler, MujocoOptions::rotors),
           mujoco_free_body(v, MujocoIntegrator::euler, MujocoOptions::ordinary)},
          1.0, 1.5);
  compare("B-1", "one plant, interference, drag, tether", plant(v, "Plant", tethered), {ode()}, 1.0, 1.5);
  compare("B-1", "one plant, every effect without memory", plant(v, "Plant", every(false)), {ode()}, 1.0,
          1.5);
  compare("B-1", "one plant, thirteen laws, one of each kind", plant(v, "Plant", one_of_each_kind()), {ode()},
          1.0, 1.5);
  compare("B-1", "one vehicle in a lane, nominal", batch(v, "Batch of 1", {}, 1), {ode()}, 1.0, 1.5);
  compare("B-1", "one vehicle in a lane, interference, drag, tether", batch(v, "Batch of 1", tethered, 1),
          {ode()}, 1.0, 1.5);
  compare("B-1", "one vehicle in a lane, every effect of lanes", batch(v, "Batch of 1", every(true), 1),
          {ode()}, 1.0, 1.5);
  for (const auto& [what, m] :
       {std::pair("nominal", Model{}), std::pair("interference, drag, tether", tethered)}) {
    const std::string of = std::string("64 vehicles in lanes, ") + what;
    compare("B-2", of, batch(v, "Batch of 64", m, 64), {ode()}, 8, 12);
    compare("B-2", of, batch(v, "Batch of 64", m, 64), {mujoco(MujocoOptions::rotors)}, 200, 0);
    compare("B-2", of, batch(v, "Batch of 64", m, 64), {mujoco(MujocoOptions::ordinary)}, 200, 0);
    compare("B-2", of, batch(v, "Batch of 64", m, 64), {mujoco(MujocoOptions::bare)}, 0, 0);
    compare("A-6", of + ", portable over native", batch(v, "portable", m, 64),
            {native_batch(v, "-march=native", m, 64)}, 0.8, 1.0);
  }
  compare("B-2", "64 vehicles in lanes, the same and rotor drag", batch(v, "Batch of 64", bladed, 64),
          {ode()}, 8, 12);
  compare("B-2", "64 vehicles in lanes, every effect of lanes", batch(v, "Batch of 64", every(true), 64),
          {ode()}, 0, 0);
  compare(
      "B-3", "chain of 20", chain(v),
      {ode_chain(v, false), ode_chain(v, true), bullet_chain(v), mujoco_chain(v, MujocoIntegrator::euler)}, 5,
      10);
  return 0;
}

}  // namespace
}  // namespace omniflight::benchmarks

int main() { return omniflight::benchmarks::run(); }
