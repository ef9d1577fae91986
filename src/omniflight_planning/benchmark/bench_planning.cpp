// Costs of the planner's parts on the shipped test bed. Run from the workspace's top folder.
#include <benchmark/benchmark.h>
#include <octomap/OcTree.h>

#include "omniflight_core/random.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

const char* const kMap = "configs/test_beds/pyramid.bt";

struct Scene {
  vehicle::Vehicle vehicle = vehicle::load_vehicle("omnimorph").value();
  DistanceMap map = DistanceMap::load(kMap).value();
  std::shared_ptr<const allocation::RotorLoad> rotors =
      std::make_shared<allocation::RotorLoad>(allocation::RotorLoad::create(vehicle, 0.8).value());
  StateCheck check{map, cover_with_spheres(vehicle, 0.8), rotors, 0.1, 0.08};
  std::vector<Pose> poses;
  Scene() {
    Random random(1);
    for (int i = 0; i < 4096; ++i)
      poses.push_back(
          {Vec3(random.uniform(-2.5, 2.5), random.uniform(-2.5, 2.5), random.uniform(0.5, 3)),
           exp_rotation(Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)))});
  }
};
const Scene& scene() {
  static const Scene s;
  return s;
}

void Clearance(benchmark::State& state) {
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(scene().check.clearance(scene().poses[i++ % 4096]));
}
BENCHMARK(Clearance);

void HoverLoad(benchmark::State& state) {
  const allocation::RotorLoad& limits = *scene().rotors;
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(limits.hover_load(scene().poses[i++ % 4096].q_WB));
}
BENCHMARK(HoverLoad);

void MotionOfHalfAMetre(benchmark::State& state) {
  std::size_t i = 0;
  for (auto _ : state) {
    const Pose& a = scene().poses[i++ % 4096];
    benchmark::DoNotOptimize(scene().check.motion_valid(a, {a.p_WB + Vec3(0.5, 0, 0), a.q_WB}));
  }
}
BENCHMARK(MotionOfHalfAMetre);

void DistanceField(benchmark::State& state) {
  const auto file = read_octree(kMap).value();
  for (auto _ : state) benchmark::DoNotOptimize(DistanceMap::create(*file.tree, file.sha256));
}
BENCHMARK(DistanceField)->Unit(benchmark::kMillisecond);

void PlanAroundFrame(benchmark::State& state) {
  const auto mission = load_mission("around_frame").value();
  for (auto _ : state) benchmark::DoNotOptimize(plan(mission, scene().vehicle, scene().map));
}
BENCHMARK(PlanAroundFrame)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace omniflight::planning

BENCHMARK_MAIN();
