// Costs of the planner's parts on the shipped test bed, and the question "is this pose free?" beside FCL
// (libfcl-dev; left out where it is not installed). Run from the workspace's top folder.
#include <benchmark/benchmark.h>
#include <octomap/OcTree.h>

#include "omniflight_core/random.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/plan.hpp"

#ifdef OMNIFLIGHT_HAVE_FCL
#include <fcl/geometry/octree/octree.h>
#include <fcl/narrowphase/collision.h>
#endif

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

void PoseIsFree(benchmark::State& state) {
  std::size_t i = 0, free = 0;
  for (auto _ : state) free += scene().check.room(scene().poses[i++ % 4096]) > 0.0;
  state.counters["free"] = static_cast<double>(free) / static_cast<double>(state.iterations());
}
BENCHMARK(PoseIsFree);

#ifdef OMNIFLIGHT_HAVE_FCL
/// The same spheres, grown by the margin, against the octree itself.
class FclVehicle {
 public:
  FclVehicle(const VehicleSpheres& spheres, double margin) {
    for (const SphereGroup& group : spheres.groups) {
      groups_.push_back({object(group.bound, margin), {}});
      for (const BodySphere& s : group.spheres) groups_.back().spheres.push_back(object(s, margin));
    }
  }
  bool hits(const fcl::CollisionObjectd& world, const Pose& pose) {
    const auto hit = [&](Part& part) {
      part.object->setTranslation(pose.p_WB + pose.q_WB * part.p_BS);
      part.object->computeAABB();
      fcl::CollisionResultd result;
      return fcl::collide(part.object.get(), &world, fcl::CollisionRequestd(), result) > 0;
    };
    return std::any_of(groups_.begin(), groups_.end(), [&](Group& group) {
      return hit(group.bound) && std::any_of(group.spheres.begin(), group.spheres.end(), hit);
    });
  }

 private:
  struct Part {
    Vec3 p_BS;
    std::unique_ptr<fcl::CollisionObjectd> object;
  };
  struct Group {
    Part bound;
    std::vector<Part> spheres;
  };
  static Part object(const BodySphere& s, double margin) {
    auto sphere = std::make_shared<fcl::Sphered>(s.radius + margin);
    return {s.p_BS, std::make_unique<fcl::CollisionObjectd>(std::move(sphere))};
  }
  std::vector<Group> groups_;
};

void PeerPoseIsFreeFcl(benchmark::State& state) {
  const auto file = read_octree(kMap).value();
  const fcl::CollisionObjectd world(std::make_shared<fcl::OcTreed>(file.tree));
  FclVehicle vehicle(scene().check.spheres(), scene().check.margin());
  std::size_t i = 0, free = 0;
  for (auto _ : state) free += !vehicle.hits(world, scene().poses[i++ % 4096]);
  state.counters["free"] = static_cast<double>(free) / static_cast<double>(state.iterations());
  // whatever the field calls free is free for FCL, too: the field's distances are lower bounds
  double wrong = 0;
  for (const Pose& pose : scene().poses) wrong += scene().check.room(pose) > 0.0 && vehicle.hits(world, pose);
  state.counters["free_here_hit_there"] = wrong;
}
BENCHMARK(PeerPoseIsFreeFcl);
#endif

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
