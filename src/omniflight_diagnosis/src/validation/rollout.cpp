#include "rollout.hpp"

#include <array>
#include <cmath>

#include "open_loop.hpp"

namespace omniflight::diagnosis {
namespace {

struct Sum {
  double position = 0, attitude = 0;
  int count = 0;
};

/// One rollout from grid index `from`; adds the squared error after each number of `steps` to `sums`, up to
/// index `last`.
void fly(const Flight& f, int from, const std::array<int, 3>& steps, const OpenLoopModel& model,
         std::array<Sum, 3>& sums, int last) {
  constexpr int kParts = 4;
  RigidState x = f.situation[static_cast<std::size_t>(from)].body;
  std::size_t horizon = 0;
  for (int k = 0; horizon < 3; ++k) {
    if (k == steps[horizon]) {
      const RigidState& truth = f.situation[static_cast<std::size_t>(from + k)].body;
      sums[horizon].position += (x.p_WB - truth.p_WB).squaredNorm();
      sums[horizon].attitude += std::pow(to_degrees(x.q_WB.angularDistance(truth.q_WB)), 2);
      ++sums[horizon].count;
      if (++horizon == 3) break;
    }
    if (from + k + 1 >= last || !advance(f, from + k, model, kParts, x)) return;
  }
}

}  // namespace

std::vector<RolloutFit> rollouts(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                                 const std::vector<physics::ActiveEffect>& effects, const Options&) {
  constexpr std::array<double, 3> kHorizon{0.1, 0.5, 2.0};
  const OpenLoopModel nominal{.center_of_mass = vehicle.center_of_mass},
      improved{.center_of_mass = vehicle.center_of_mass, .effects = effects};
  std::array<Sum, 3> before, after;
  for (const Flight* f : flights) {
    if (!f->has_position) return {};
    std::array<int, 3> steps{};
    for (std::size_t h = 0; h < 3; ++h) steps[h] = static_cast<int>(std::lround(kHorizon[h] * f->rate_hz));
    const int stride = std::max(static_cast<int>(0.5 * f->rate_hz), f->usable() / 200);
    for (const Segment& s : f->segments)
      for (int i = s.begin; i < s.end; i += stride) {
        fly(*f, i, steps, nominal, before, s.end);
        fly(*f, i, steps, improved, after, s.end);
      }
  }
  std::vector<RolloutFit> out;
  for (std::size_t h = 0; h < 3; ++h) {
    if (before[h].count == 0 || after[h].count == 0) continue;
    const double b = before[h].count, a = after[h].count;
    out.push_back(
        {kHorizon[h], "position", "m", std::sqrt(before[h].position / b), std::sqrt(after[h].position / a)});
    out.push_back({kHorizon[h], "attitude", "deg", std::sqrt(before[h].attitude / b),
                   std::sqrt(after[h].attitude / a)});
  }
  return out;
}

}  // namespace omniflight::diagnosis
