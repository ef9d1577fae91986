// Figures of the 6D planner, one line of JSON each: checks of poses and motions, windows, plans round a
// frame, missions without a plan, and durations. FCL (libfcl-dev) and stock OMPL answer the same in the same
// run, turn by turn; they are left out where FCL is not installed. Run from the workspace's top folder.
// `bench_planner WORD` runs what has WORD in its name; `bench_planner rigid_body --help` plans for meshes.
#include <octomap/OcTree.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <functional>

#include "../test/bench.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/plan.hpp"
#include "omniflight_planning/planner.hpp"
#include "omniflight_planning/time_optimal.hpp"

#ifdef OMNIFLIGHT_HAVE_FCL
#include "fcl_vehicle.hpp"
#include "rigid_body_bench.hpp"
#endif

namespace omniflight::planning {
namespace {

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// What launch_scripts/benchmark_table.py reads; a figure against its goal has the goal as peer.
void line(const std::string& what, double ours, const std::string& peer, double theirs, const char* unit,
          double must, double stretch) {
  std::printf(
      "{\"id\": \"P-2\", \"what\": \"%s\", \"ours\": \"omniflight\", \"ours_value\": %.6g, \"peer\": \"%s\", "
      "\"peer_value\": %.6g, \"unit\": \"%s\", \"ratio\": %.4g, \"must\": %g, \"stretch\": %g}\n",
      what.c_str(), ours, peer.c_str(), theirs, unit, ours != 0.0 ? theirs / ours : 0.0, must, stretch);
  std::fflush(stdout);
}

/// The part of the shipped test bed about its frame, in voxels of this edge [m].
std::shared_ptr<const octomap::OcTree> frame_of(double resolution) {
  TestBed bed = load_test_bed("configs/test_beds/pyramid.yaml").value();
  bed.resolution = resolution;
  bed.lower = Vec3(-2.2, -2.2, -0.1), bed.upper = Vec3(2.2, 2.2, 3.3);
  return make_octree(bed).value();
}

struct Bed {
  Bed() = default;
  explicit Bed(double resolution) : tree(frame_of(resolution)) {}
  std::shared_ptr<const octomap::OcTree> tree = read_octree("configs/test_beds/pyramid.bt").value().tree;
  DistanceMap map = DistanceMap::create(*tree, "").value();
  StateCheck check = make_check(map, 45, 1e-3);
};

#ifdef OMNIFLIGHT_HAVE_FCL
Quat any_attitude(Random& random) {
  return Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
}

/// Poses uniform in the map, or those of them whose centre is 0.12 to 0.36 m from an obstacle.
std::vector<Pose> poses(const Bed& bed, bool near, std::size_t count) {
  Random random(7);
  std::vector<Pose> out;
  while (out.size() < count) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = random.uniform(bed.map.lower()[k], bed.map.upper()[k]);
    const double d = bed.map.distance(p);
    if (!near || (d > 0.12 && d < 0.36)) out.push_back({p, any_attitude(random)});
  }
  return out;
}

/// Rounds by turns; the median round's CPU time a question [ns] of each side.
std::pair<double, double> by_turns(const std::function<void()>& ours, const std::function<void()>& theirs,
                                   std::size_t n) {
  std::vector<double> a, b;
  for (int round = 0; round < 9; ++round) {
    double begin = cpu_seconds();
    ours();
    a.push_back(cpu_seconds() - begin);
    begin = cpu_seconds();
    theirs();
    b.push_back(cpu_seconds() - begin);
  }
  return {1e9 * median(a) / static_cast<double>(n), 1e9 * median(b) / static_cast<double>(n)};
}

void state_checks(const Bed& bed) {
  // what StateCheck::valid() asks, without the rotors, of which the peer knows nothing
  const auto is_free = [&](const Pose& pose) {
    return bed.check.room(pose, 2.0 * StateCheck::kLeastRoom) > StateCheck::kLeastRoom;
  };
  const FclVehicle fcl(bed.check.spheres(), bed.tree);
  for (const bool near : {true, false}) {
    const auto set = poses(bed, near, 4000);
    std::size_t missed = 0, free_here = 0, free_there = 0;
    for (const Pose& pose : set) {
      const bool here = is_free(pose), there = !fcl.hits(pose);
      free_here += here;
      free_there += there;
      missed += here && !there;
    }
    const auto [ours, theirs] = by_turns(
        [&] {
          for (const Pose& p : set) free_here += is_free(p);
        },
        [&] {
          for (const Pose& p : set) free_there += !fcl.hits(p);
        },
        set.size());
    char what[120];
    std::snprintf(what, sizeof what, "pose free, %s, voxels of %.0f mm (%zu hit for FCL and free here)",
                  near ? "near" : "uniform", 1e3 * bed.map.resolution(), missed);
    line(what, ours, "FCL mesh", theirs, "ns", near ? 80 : 100, near ? 100 : 140);
  }
}

void state_checks() {
  state_checks(Bed());
  state_checks(Bed(0.02));
}

void edge_checks() {
  const Bed bed;
  const FclVehicle fcl(bed.check.spheres(), bed.tree);
  const auto set = poses(bed, true, 1000);
  Random random(3);
  std::vector<std::pair<Pose, Pose>> edges;
  for (const Pose& a : set)
    if (bed.check.valid(a))
      edges.push_back({a,
                       {a.p_WB + 0.4 * Vec3(random.normal(), random.normal(), random.normal()).normalized(),
                        (a.q_WB * exp_rotation(0.4 * Vec3(random.normal(), random.normal(), random.normal())))
                            .normalized()}});
  std::size_t free = 0;
  const auto [ours, theirs] = by_turns(
      [&] {
        for (const auto& [a, b] : edges) free += bed.check.motion_valid(a, b);
      },
      [&] {
        for (const auto& [a, b] : edges) free += fcl.motion_free(a, b);
      },
      edges.size());
  line("motion of 0.4 m, certified", ours, "FCL mesh, every 1 %", theirs, "ns", 15, 40);
}

/// Both sides look for a first path, seed by seed in turn; runs are cut off at `seconds` of processor time.
void first_path(const std::string& name, const StateCheck& check, const FclVehicle& fcl, const Pose& start,
                const Pose& goal, int seeds, double seconds, double must, double stretch) {
  std::vector<double> ours, theirs;
  for (int seed = 1; seed <= seeds; ++seed) {
    PathOptions options;
    options.seed = static_cast<std::uint64_t>(seed);
    options.budget_s = rigid_body::kWallLimit;
    options.deadline = Deadline(rigid_body::kWallLimit, rigid_body::processor_time_over);
    options.shortcuts = 0;  // the other side does not shorten either
    double begin = cpu_seconds();
    rigid_body::processor_limit() = begin + seconds;
    const bool found = find_path(check, start, goal, options).has_value();
    if (found) ours.push_back(1e3 * (cpu_seconds() - begin));
    std::uint64_t looks = 0;
    begin = cpu_seconds();
    rigid_body::processor_limit() = begin + seconds;
    const auto other = stock::solve(
        check.map().lower(), check.map().upper(), start, goal, [&](const Pose& p) { return fcl.hits(p); },
        rigid_body::processor_time_over, looks);
    if (!other.empty()) theirs.push_back(1e3 * (cpu_seconds() - begin));
  }
  char what[160];
  std::snprintf(what, sizeof what, "first path, %s: %zu of %d solved (peer %zu), median of solved",
                name.c_str(), ours.size(), seeds, theirs.size());
  line(what, median(ours), "stock OMPL RRTConnect + FCL", median(theirs), "ms", must, stretch);
}

/// Three open queries about the frame.
void first_paths() {
  const Bed bed;
  const FclVehicle fcl(bed.check.spheres(), bed.tree);
  const auto rolled = [](double degrees) { return from_roll_pitch_yaw(Vec3(to_radians(degrees), 0, 0)); };
  const Quat level = Quat::Identity();
  const struct {
    const char* name;
    Pose start, goal;
  } queries[] = {
      {"aside and rolled by 90 degrees in the frame",
       {Vec3(-0.3, 0, 1.3), level},
       {Vec3(0.3, 0, 1.3), rolled(90)}},
      {"out of the frame through a side", {Vec3(0, 0, 1.3), level}, {Vec3(2.2, 0, 1.0), level}},
      {"round the frame", {Vec3(1.9, 1.9, 1.0), rolled(60)}, {Vec3(-1.9, -1.9, 1.0), rolled(60)}},
  };
  for (const auto& q : queries) first_path(q.name, bed.check, fcl, q.start, q.goal, 30, 6.0, 10, 30);
}

/// The slots and windows of windows() beside stock OMPL and FCL, with as little margin as these have.
void slots() {
  for (const bool slot : {true, false})
    for (const double width : {0.60, 0.50}) {
      const auto tree = make_octree(window_bed(width, slot ? 2.4 : width, 0.02)).value();
      const auto map = DistanceMap::create(*tree, "").value();
      const auto check = make_check(map, 30, 1e-3);
      const FclVehicle fcl(check.spheres(), tree);
      char name[40];
      std::snprintf(name, sizeof name, "%s of %.2f m", slot ? "slot" : "window", width);
      first_path(name, check, fcl, {Vec3(-1.2, 0.5, 1.4), from_roll_pitch_yaw(Vec3(0, 0.1, 0.7))},
                 {Vec3(1.2, -0.6, 1.0), from_roll_pitch_yaw(Vec3(0.1, 0, -0.5))}, 10, 6.0, 0, 0);
    }
}
#endif

/// Through a wall's window of `width` m from a twisted start to a twisted goal.
void windows() {
  for (const bool slot : {true, false})
    for (const double width : {0.60, 0.50}) {
      const auto tree = make_octree(window_bed(width, slot ? 2.4 : width, 0.02)).value();
      const auto map = DistanceMap::create(*tree, "").value();
      const auto check = make_check(map, 30, 0.02);
      const Pose start{Vec3(-1.2, 0.5, 1.4), from_roll_pitch_yaw(Vec3(0, 0.1, 0.7))};
      const Pose goal{Vec3(1.2, -0.6, 1.0), from_roll_pitch_yaw(Vec3(0.1, 0, -0.5))};
      std::vector<double> times;
      for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        const double begin = cpu_seconds();
        const auto path = find_path(check, start, goal, {.seed = seed, .budget_s = 6.0, .name_of = {}});
        const double took = cpu_seconds() - begin;
        if (path && took <= 6.0) times.push_back(1e3 * took);
      }
      char what[120];
      std::snprintf(what, sizeof what, "%s of %.2f m: %zu of 30 in 6 CPU-s, median", slot ? "slot" : "window",
                    width, times.size());
      line(what, median(times), "goal", width < 0.55 ? 600 : 0, "ms", width < 0.55 ? 1 : 0,
           width < 0.55 ? 4 : 0);
    }
}

/// The same windows with one search and with two side by side: processor time of all threads (what a loaded
/// machine does not stretch), and wall time.
void threads() {
  const auto wall = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  for (const double width : {0.60, 0.50}) {
    const auto tree = make_octree(window_bed(width, width, 0.02)).value();
    const auto map = DistanceMap::create(*tree, "").value();
    const auto check = make_check(map, 30, 0.02);
    const Pose start{Vec3(-1.2, 0.5, 1.4), from_roll_pitch_yaw(Vec3(0, 0.1, 0.7))};
    const Pose goal{Vec3(1.2, -0.6, 1.0), from_roll_pitch_yaw(Vec3(0.1, 0, -0.5))};
    std::vector<double> processor[2], walls[2];
    for (std::uint64_t seed = 1; seed <= 15; ++seed)
      for (const int n : {1, 2}) {
        const double begin = cpu_seconds(), wall_begin = wall();
        PathOptions options;
        options.seed = seed;
        options.budget_s = 60.0;
        options.threads = n;
        const bool found = find_path(check, start, goal, options).has_value();
        if (found) processor[n - 1].push_back(1e3 * (cpu_seconds() - begin));
        if (found) walls[n - 1].push_back(1e3 * (wall() - wall_begin));
      }
    char what[160];
    std::snprintf(what, sizeof what, "window of %.2f m, two threads (%zu and %zu of 15), processor time",
                  width, processor[1].size(), processor[0].size());
    line(what, median(processor[1]), "one thread", median(processor[0]), "ms", 0, 0);
    std::snprintf(what, sizeof what, "window of %.2f m, two threads, wall time", width);
    line(what, median(walls[1]), "one thread", median(walls[0]), "ms", 0, 0);
  }
}

/// Walls, and windows and slots that are too narrow: how many answers prove it or name the gap within 200 ms.
void infeasible() {
  int asked = 0, answered = 0;
  std::vector<double> times;
  for (const bool slot : {true, false})
    for (const double width : {0.0, 0.1, 0.2, 0.3}) {
      const auto tree = make_octree(window_bed(width, slot ? 2.4 : width, 0.05)).value();
      const auto map = DistanceMap::create(*tree, "").value();
      const auto check = make_check(map, 30, 0.05);
      Random random(4);
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const auto pose = [&](double side) {
          return Pose{
              Vec3(side * random.uniform(0.6, 1.4), random.uniform(-0.9, 0.9), random.uniform(0.7, 1.7)),
              from_roll_pitch_yaw(Vec3(0, 0, random.uniform(-3, 3)))};
        };
        const double begin = cpu_seconds();
        const auto path = find_path(check, pose(-1), pose(1), {.seed = seed, .budget_s = 2.0, .name_of = {}});
        times.push_back(1e3 * (cpu_seconds() - begin));
        ++asked;
        answered += !path && times.back() <= 200.0 &&
                    (path.error().failure == PathFailure::proven_impossible ||
                     path.error().message.find("narrows to") != std::string::npos);
      }
    }
  char what[120];
  std::snprintf(what, sizeof what, "no way: proven or gap named within 200 ms: %d of %d, median", answered,
                asked);
  line(what, median(times), "goal", 200, "ms", 1, 4);
}

void around_frame() {
  const auto mission = load_mission("around_frame").value();
  const auto vehicle = vehicle::load_vehicle("omnimorph").value();
  const auto map = DistanceMap::load(mission.test_bed).value();
  std::vector<double> times;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    PlanOptions options;
    options.seed = seed;
    const double begin = cpu_seconds();
    if (plan(mission, vehicle, map, options)) times.push_back(1e3 * (cpu_seconds() - begin));
  }
  char what[120];
  std::snprintf(what, sizeof what, "certified plan round the frame, map loaded: %zu of 30, median",
                times.size());
  line(what, median(times), "goal", 20, "ms", 1, 4);
}

/// Loading the test bed's map: its field computed, and read where an earlier run has kept it.
void map_loading() {
  const auto folder = std::filesystem::temp_directory_path() / "omniflight_bench_fields";
  std::vector<double> cold, kept;
  for (int round = 0; round < 9; ++round) {
    std::filesystem::remove_all(folder);
    for (std::vector<double>* times : {&cold, &kept}) {
      const double begin = cpu_seconds();
      DistanceMap::load("configs/test_beds/pyramid.bt", {.cache = folder}).value();
      times->push_back(1e3 * (cpu_seconds() - begin));
    }
  }
  std::filesystem::remove_all(folder);
  line("loading the map with its field kept by an earlier run", median(kept), "computing and writing it",
       median(cold), "ms", 1, 4);
}

/// Length of a path round the frame (30 seeds), beside RRT* with 2 s (5 seeds).
void lengths() {
  const Bed bed;
  const auto check = make_check(bed.map, 48, 0.08);
  const Quat rolled = from_roll_pitch_yaw(Vec3(to_radians(60), 0, 0));
  const Pose start{Vec3(1.9, 1.9, 1.0), rolled}, goal{Vec3(-1.9, -1.9, 1.0), rolled};
  std::vector<double> ours, theirs;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    if (const auto path = find_path(check, start, goal, {.seed = seed, .budget_s = 2.0, .name_of = {}}))
      ours.push_back(path_length(*path));
    if (seed > 5) continue;
    if (const auto path = find_path(check, start, goal,
                                    {.seed = seed, .budget_s = 2.0, .planner = "rrtstar", .name_of = {}}))
      theirs.push_back(path_length(*path));
  }
  line("length of a path round the frame, first found and shortened", median(ours), "RRT* in 2 s, shortened",
       median(theirs), "m", 0.95, 0.99);
  std::vector<double> in_time;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const double begin = cpu_seconds();
    const auto path = find_path(check, start, goal, {.seed = seed, .budget_s = 2.0, .name_of = {}});
    if (path && cpu_seconds() - begin <= 0.01) in_time.push_back(path_length(*path));
  }
  char what[120];
  std::snprintf(what, sizeof what, "length of a path round the frame: %zu of 30 within 10 ms, median",
                in_time.size());
  line(what, median(in_time), "goal", 6.5, "m", 1, 1.04);
}

/// What the budget's rest is worth: a path and a plan round the frame, the first that is found and the
/// shortest.
void anytime() {
  const Bed bed;
  const auto check = make_check(bed.map, 48, 0.08);
  const Quat rolled = from_roll_pitch_yaw(Vec3(to_radians(60), 0, 0));
  const Pose start{Vec3(1.9, 1.9, 1.0), rolled}, goal{Vec3(-1.9, -1.9, 1.0), rolled};
  auto mission = load_mission("around_frame").value();
  const auto vehicle = vehicle::load_vehicle("omnimorph").value();
  for (const double seconds : {0.1, 0.5, 2.0}) {
    std::vector<double> firsts, paths, plans, quick;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const PathOptions options{.seed = seed, .budget_s = seconds, .name_of = {}};
      const auto first = find_path(check, start, goal, options);
      if (!first) continue;
      firsts.push_back(path_length(*first));
      paths.push_back(path_length(find_shorter_path(check, *first, options)));
      PlanOptions of_plan;
      of_plan.seed = seed;
      of_plan.budget_s = seconds;
      for (const bool all : {false, true}) {
        mission.anytime = all;
        if (const auto made = plan(mission, vehicle, bed.map, of_plan))
          (all ? plans : quick).push_back(made->certificate.duration);
      }
    }
    char what[120];
    std::snprintf(what, sizeof what, "length of a path round the frame, %.1f s of restarts (%zu of 10)",
                  seconds, paths.size());
    line(what, median(paths), "first found", median(firsts), "m", 1, 1.05);
    std::snprintf(what, sizeof what, "duration of the plan round the frame, anytime in %.1f s (%zu of 10)",
                  seconds, plans.size());
    line(what, median(plans), "search: first", median(quick), "s", 1, 1.05);
  }
}

/// Rides of 30 curves through 6 poses 0.5 m and 0.5 rad apart, the motion limited by the rotors alone: their
/// durations over that of the fastest ride within the rotors' range, which no motor with a lag can do.
void durations() {
  const MotionLimits rotors_alone{
      .speed = 1e6, .acceleration = 1e6, .rate = 1e6, .angular_acceleration = 1e6};
  const auto vehicle = vehicle::load_vehicle("omnimorph").value();
  auto ideal = vehicle;
  for (auto& rotor : ideal.rotors) rotor.time_constant = 0.0;
  const Rotors rotors = rotors_of(vehicle, to_radians(50)), no_lag = rotors_of(ideal, to_radians(50));
  Random random(5);
  const auto draw = [&](double size) -> Vec3 {
    return size * Vec3(random.normal(), random.normal(), random.normal()).normalized();
  };
  std::vector<double> shortest, without_lag, smooth, took;
  for (int trial = 0; trial < 30; ++trial) {
    std::vector<Pose> poses{{Vec3(0, 0, 1), Quat::Identity()}};
    for (int k = 0; k < 5; ++k)
      poses.push_back(
          {poses.back().p_WB + draw(0.5), (poses.back().q_WB * exp_rotation(draw(0.5))).normalized()});
    const PoseCurve curve(poses);
    const double bound = time_optimal(curve, rotors.load(), rotors_alone, 800).value().duration();
    const double begin = cpu_seconds();
    shortest.push_back(ride_shortest(curve, rotors, rotors_alone).value().back().t / bound);
    took.push_back(1e3 * (cpu_seconds() - begin));
    without_lag.push_back(ride_shortest(curve, no_lag, rotors_alone).value().back().t / bound);
    smooth.push_back(ride(curve, rotors, rotors_alone).value().back().t / bound);
  }
  char what[160];
  std::snprintf(what, sizeof what,
                "duration over the bound of the rotors' range, lag of 15 ms kept: at most %.3f, median",
                *std::max_element(shortest.begin(), shortest.end()));
  line(what, median(shortest), "goal", 1.15, "1", 1, 1.08);
  line("the same of motors without lag", median(without_lag), "goal", 1.15, "1", 1, 1.08);
  line("the same with the lag", median(shortest), "minimum jerk", median(smooth), "1", 1.3, 1.7);
  line("processor time of such a ride", median(took), "goal", 100, "ms", 1, 4);
}

}  // namespace
}  // namespace omniflight::planning

int main(int argc, char** argv) {
  using namespace omniflight::planning;
#ifdef OMNIFLIGHT_HAVE_FCL
  if (argc > 1 && std::strcmp(argv[1], "rigid_body") == 0)
    return rigid_body::run(argc, argv, line, median, cpu_seconds);
#endif
  const char* word = argc > 1 && argv[1][0] != '-' ? argv[1] : "";
  const auto run = [&](const char* name, void (*figure)()) {
    if (std::strstr(name, word)) figure();
  };
#ifdef OMNIFLIGHT_HAVE_FCL
  run("state", state_checks);
  run("edge", edge_checks);
  run("first", first_paths);
  run("slots", slots);
#endif
  run("windows", windows);
  run("threads", threads);
  run("infeasible", infeasible);
  run("around", around_frame);
  run("map", map_loading);
  run("length", lengths);
  run("duration", durations);
  run("anytime", anytime);
  return 0;
}
