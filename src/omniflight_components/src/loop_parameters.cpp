#include "omniflight_components/loop_parameters.hpp"

#include "control_parameters.hpp"
#include "estimator_choice.hpp"
#include "flight_guard.hpp"
#include "plant_parameters.hpp"
#include "transform_publisher.hpp"

namespace omniflight::components {

Result<LoopParameters> read_loop_parameters(const std::vector<std::string>& files) {
  const auto parameters = [&](const std::string& component) -> Result<bus::Parameters> {
    auto node = bus::load_parameters(files, {}, component);
    if (!node) return Failure(node.error());
    return bus::Parameters(*node, component);
  };
  auto simulator = parameters("simulator"), controller = parameters("controller"),
       allocator = parameters("allocator");
  for (const auto* p : {&simulator, &controller, &allocator})
    if (!*p) return Failure(p->error());
  LoopParameters out;
  // of the simulator component, and without meaning where nothing is sent or waited for
  for (const char* key : {"rate", "faults_file"}) (void)simulator->text(key, "");
  for (const char* key : {"recorder_window_ticks"}) (void)simulator->integer(key, 0);
  for (const char* key : {"command_timeout_s", "stale_after_s"}) (void)simulator->number(key, 0.0);
  auto plant = read_plant_parameters(*simulator);
  if (!plant) return Failure(plant.error());
  out.vehicle = std::move(plant->vehicle);
  out.model = std::move(plant->model);
  out.plant = std::move(plant->plant);
  out.control_period = plant->control_period;
  out.hold = plant->hold;
  out.duration = plant->duration;
  out.law = read_law_parameters(*controller);
  out.settle = controller->number("settle_s", 1.0, 0, 600);
  // estimator and failsafe have no part in this loop; what is wrong with their parameters is told all the
  // same
  const auto estimator = read_estimator(*controller);
  const auto guard = read_guard(*controller);
  const auto below = read_map_below(*controller);
  (void)read_transform_rate(*controller);
  if (auto ok = controller->finish(); !ok) return Failure(ok.error());
  if (!estimator) return Failure(estimator.error());
  if (!guard) return Failure(guard.error());
  if (!below) return Failure(below.error());
  if (const auto law = make_law(out.law); !law) return Failure(law.error());
  auto read = read_allocator_parameters(*allocator);
  if (!read) return Failure(read.error());
  out.allocator = std::move(*read);
  return out;
}

}  // namespace omniflight::components
