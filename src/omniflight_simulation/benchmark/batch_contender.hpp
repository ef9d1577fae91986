// A batch of vehicles as a contender. A template in a header, because the kernel that is tuned for this
// processor is compiled under another name (see native.cpp).
#pragma once

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "omniflight_simulation/batch.hpp"
#include "ratio.hpp"

namespace omniflight::benchmarks {

inline simulation::PlantConfig tumbling_start() {
  simulation::PlantConfig config;
  config.initial_alpha = 0.5;
  config.initial.p_WB.z() = 10;
  config.initial.w_WB_B = Vec3(0.1, 0.2, 0.3);
  return config;
}

inline std::vector<double> hover_speeds(const vehicle::Vehicle& v, double alpha) {
  const double each = v.mass * kGravity / (static_cast<double>(v.rotors.size()) * std::cos(alpha));
  return std::vector<double>(v.rotors.size(), v.rotors[0].speed(each));
}

/// `count` vehicles with the same model; steps are of 1 ms, commands come every 2 ms.
template <class Batch, class Config>
Contender batch_contender(const vehicle::Vehicle& vehicle, const std::string& name,
                          const physics::Model& model, int count) {
  Config config;
  config.plant = tumbling_start();
  config.unsupported = Config::Unsupported::refuse;
  auto made =
      Batch::create(vehicle, std::vector<physics::Model>(static_cast<std::size_t>(count), model), config);
  if (!made) return {name, {}, 1, made.error().text()};
  auto shared = std::make_shared<Batch>(std::move(*made));
  const std::vector<double> speed = hover_speeds(vehicle, config.plant.initial_alpha);
  const auto run = [shared, speed, count](int n) {
    for (int k = 0; k < n; k += 2) {
      if (shared->time() > 2) shared->reset();  // before they tumble out of the world
      for (int i = 0; i < count; ++i) shared->set_command(static_cast<std::size_t>(i), speed, 0.5);
      if (shared->step(std::min(2, n - k)) < static_cast<std::size_t>(count)) std::abort();
    }
  };
  return {name, run, static_cast<double>(count), {}};
}

/// The same batch with the kernel compiled by -O3 -march=native; without, the reason.
Contender native_batch(const vehicle::Vehicle& vehicle, const std::string& name, const physics::Model& model,
                       int count);

}  // namespace omniflight::benchmarks
