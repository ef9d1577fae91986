// `bench_planner rigid_body`: a rigid body among triangles, planned by us and by stock OMPL with FCL in turn.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <optional>
#include <sstream>
#include <string>

#include "../test/rigid_body_problems.hpp"
#include "rigid_body_peer.hpp"

namespace omniflight::planning::rigid_body {

inline constexpr const char* kUsage =
    "usage: bench_planner rigid_body [--env FILE --robot FILE --start P --goal P --bounds B] [options]\n"
    "Plans for a rigid body between two poses among the triangles of a mesh (.stl, .obj, .ply, .dae), by "
    "omniflight\n"
    "and by stock OMPL RRTConnect with FCL in turn. Without --env: problems that are made here.\n"
    "  --start, --goal P  \"x y z qw qx qy qz\", lengths in the meshes' unit\n"
    "  --bounds B         \"x y z x y z\", lower and upper corner of the box of the body's origin\n"
    "  --centred          the body turns about the mean of its vertices (as OMPL.app has it), not its "
    "origin\n"
    "  --seeds N          runs of each side, 1 to 1000; default 10\n"
    "  --seconds S        processor time of a run, 0.01 to 600 s; default 20\n"
    "example: bench_planner rigid_body --env maze.dae --robot lamp.dae --start \"0 0 1 1 0 0 0\" --goal \"9 "
    "9 1 1 0 0 "
    "0\" --bounds \"-1 -1 0 10 10 3\"\n"
    "Prints processor time [s], poses looked at, and length of the path [unit of the meshes] of each side, "
    "as\n"
    "medians of the runs that found one, and the ratio of the other's to ours.\n";

inline constexpr double kWallLimit = 1800.0;  // s, of a run whatever its processor time

struct Request {
  std::string env, robot;
  std::optional<std::vector<double>> start, goal, bounds;
  bool centred = false;
  int seeds = 10;
  double seconds = 20.0;
};

/// So many finite numbers between spaces; nothing where there are others.
inline std::optional<std::vector<double>> numbers(const char* text, std::size_t count) {
  std::istringstream words(text);
  std::vector<double> out;
  for (std::string word; words >> word;) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value)) return {};
    out.push_back(value);
  }
  return out.size() == count ? std::optional(out) : std::nullopt;
}

/// Fills a request; the word that cannot be used, or nothing.
inline std::optional<std::string> read_request(int argc, char** argv, Request& out) {
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--centred") {
      out.centred = true;
      continue;
    }
    if (i + 1 >= argc) return word;
    const char* value = argv[++i];
    const auto count = [&](int low, int high, int& into) {
      const auto found = numbers(value, 1);
      if (!found || !(found->front() >= low && found->front() <= high)) return false;
      into = static_cast<int>(found->front());
      return true;
    };
    bool ok = true;
    if (word == "--env")
      out.env = value;
    else if (word == "--robot")
      out.robot = value;
    else if (word == "--start")
      ok = (out.start = numbers(value, 7)).has_value();
    else if (word == "--goal")
      ok = (out.goal = numbers(value, 7)).has_value();
    else if (word == "--bounds")
      ok = (out.bounds = numbers(value, 6)).has_value();
    else if (word == "--seeds")
      ok = count(1, 1000, out.seeds);
    else if (word == "--seconds") {
      const auto found = numbers(value, 1);
      ok = found && found->front() >= 0.01 && found->front() <= 600.0;
      if (ok) out.seconds = found->front();
    } else
      return word;
    if (!ok) return word + " " + value;
  }
  const bool all = !out.env.empty() && !out.robot.empty() && out.start && out.goal && out.bounds;
  const bool none = out.env.empty() && out.robot.empty() && !out.start && !out.goal && !out.bounds;
  if (!all && !none) return "--env, --robot, --start, --goal and --bounds belong together";
  return {};
}

inline Result<Pose> pose_of(const std::vector<double>& n, const char* field) {
  const Quat q(n[3], n[4], n[5], n[6]);
  if (std::abs(q.norm() - 1.0) > 1e-2)
    return bad_input("the quaternion (w, x, y, z) has norm " + std::to_string(q.norm()), field,
                     "Give a unit one");
  return Pose{Vec3(n[0], n[1], n[2]), q.normalized()};
}

inline Result<RigidBodyProblem> problem_of(const Request& request) {
  RigidBodyProblem out;
  auto env = read_mesh(request.env, {.scale = 1.0, .any_span = true});
  if (!env) return Failure(env.error());
  auto robot = read_mesh(request.robot, {.scale = 1.0, .any_span = true});
  if (!robot) return Failure(robot.error());
  out.environment = std::move(*env), out.body = std::move(*robot);
  if (request.centred) out.body.move(-out.body.mean_vertex());
  const auto start = pose_of(*request.start, "--start"), goal = pose_of(*request.goal, "--goal");
  if (!start) return Failure(start.error());
  if (!goal) return Failure(goal.error());
  out.start = *start, out.goal = *goal;
  const auto& b = *request.bounds;
  out.lower = Vec3(b[0], b[1], b[2]), out.upper = Vec3(b[3], b[4], b[5]);
  return out;
}

/// A run ends by its processor time: a busy machine takes none of it.
inline double& processor_limit() {
  static double limit = 0.0;
  return limit;
}
inline bool processor_time_over() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC > processor_limit();
}

struct Runs {
  std::vector<double> seconds, looks, length;  // of those that found a path
  int asked = 0;
  double all_seconds = 0.0;
  void add(double took, std::uint64_t looked, const std::vector<Pose>& path) {
    ++asked;
    all_seconds += took;
    if (path.empty()) return;
    seconds.push_back(took);
    looks.push_back(static_cast<double>(looked));
    double metres = 0.0;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) metres += (path[i + 1].p_WB - path[i].p_WB).norm();
    length.push_back(metres);
  }
};

/// Both sides in turn, `line` printing each figure.
template <class Line, class Median, class Clock>
Status compare(const std::string& name, const RigidBodyProblem& problem, const Request& request,
               const Line& line, const Median& median, const Clock& cpu_seconds) {
  double begin = cpu_seconds();
  const auto scene = RigidBodyScene::create(problem);
  if (!scene) return Failure(scene.error());
  const double prepare = cpu_seconds() - begin;
  begin = cpu_seconds();
  const StockPlanner stock(problem);
  const double stock_prepare = cpu_seconds() - begin;
  Runs ours, shortened, theirs;
  std::size_t hit = 0, poses = 0;  // of our paths, for FCL
  for (int seed = 1; seed <= request.seeds; ++seed) {
    PathOptions options;
    options.seed = static_cast<std::uint64_t>(seed);
    options.budget_s = kWallLimit;
    options.deadline = Deadline(kWallLimit, processor_time_over);
    options.shortcuts = 0;  // the other side does not shorten either
    const std::uint64_t looks = scene->looks();
    begin = cpu_seconds();
    processor_limit() = begin + request.seconds;
    const auto path = scene->plan(options);
    ours.add(cpu_seconds() - begin, scene->looks() - looks, path ? *path : std::vector<Pose>());
    if (!path && path.error().failure != PathFailure::no_path_in_time)
      return bad_input(path.error().message, name, "Give other poses");
    if (path) {
      options.shortcuts = 300;
      begin = cpu_seconds();
      processor_limit() = begin + request.seconds;
      if (const auto again = scene->plan(options)) {
        shortened.add(cpu_seconds() - begin, 0, *again);
      }
    }
    for (std::size_t i = 0; path && i + 1 < path->size(); ++i)
      for (int k = 0; k < 50; ++k, ++poses)
        hit += stock.hits(interpolate((*path)[i], (*path)[i + 1], k / 50.0));
    std::uint64_t looked = 0;
    begin = cpu_seconds();
    processor_limit() = begin + request.seconds;
    const auto other = stock.solve(processor_time_over, looked);
    theirs.add(cpu_seconds() - begin, looked, other);
  }
  char what[240];
  std::snprintf(what, sizeof what, "%s: %zu of %d solved (peer %zu), processor time, median of solved",
                name.c_str(), ours.seconds.size(), ours.asked, theirs.seconds.size());
  const std::string peer = "stock OMPL RRTConnect + FCL";
  line(what, median(ours.seconds), peer, median(theirs.seconds), "s", 1, 10);
  line(name + ": processor time a run, unsolved ones included, mean", ours.all_seconds / ours.asked, peer,
       theirs.all_seconds / theirs.asked, "s", 1, 10);
  line(name + ": poses looked at", median(ours.looks), peer, median(theirs.looks), "1", 0, 0);
  line(name + ": length of the first path", median(ours.length), peer, median(theirs.length), "unit", 1, 1);
  line(name + ": processor time with shortening", median(shortened.seconds), peer + ", not shortened",
       median(theirs.seconds), "s", 0, 0);
  line(name + ": length of the shortened path", median(shortened.length), peer + ", not shortened",
       median(theirs.length), "unit", 1, 1);
  line(name + ": getting ready, once", prepare, peer, stock_prepare, "s", 0, 0);
  std::snprintf(what, sizeof what, "%s: of %zu poses along our paths, hit for FCL", name.c_str(), poses);
  line(what, static_cast<double>(hit), "goal", 0, "1", 0, 0);
  return {};
}

/// The command. `line`, `median` and `cpu_seconds` are those of bench_planner.
template <class Line, class Median, class Clock>
int run(int argc, char** argv, const Line& line, const Median& median, const Clock& cpu_seconds) {
  Request request;
  if (argc > 2 && std::strcmp(argv[2], "--help") == 0) return std::fputs(kUsage, stdout) < 0;
  if (const auto wrong = read_request(argc, argv, request)) {
    std::fprintf(stderr, "bench_planner rigid_body: cannot use '%s'\n%s", wrong->c_str(), kUsage);
    return 4;
  }
  const auto judged = [&](const Status& status) {
    if (status) return 0;
    std::fprintf(stderr, "bench_planner rigid_body: %s\n", status.error().text().c_str());
    return static_cast<int>(status.error().code);
  };
  if (!request.env.empty()) {
    const auto problem = problem_of(request);
    if (!problem) return judged(Failure(problem.error()));
    return judged(compare(request.env, *problem, request, line, median, cpu_seconds));
  }
  const std::pair<const char*, RigidBodyProblem> made[] = {
      {"L through a window of 0.8 m", l_through_window(0.8, 0.8)},
      {"L through a window of 0.5 m", l_through_window(0.5, 0.5)},
      {"L through a slot of 0.2 m", l_through_window(0.2, 1.0)},
      {"rod of 1.6 m in a bent corridor", rod_in_bent_corridor(1.6)},
      {"rod of 2.2 m in a bent corridor", rod_in_bent_corridor(2.2)},
      {"rough L through a window of 0.8 m", rough_l_through_window(0.8, 0.8)},
      {"rough L through a window of 0.5 m", rough_l_through_window(0.5, 0.5)},
      {"ring of 0.7 m through a window of 0.3 m", ring_through_window(0.3, 0.9)},
  };
  for (const auto& [name, problem] : made)
    if (const int code = judged(compare(name, problem, request, line, median, cpu_seconds)); code != 0)
      return code;
  return 0;
}

}  // namespace omniflight::planning::rigid_body
