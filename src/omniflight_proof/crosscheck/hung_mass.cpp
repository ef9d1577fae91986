#include "hung_mass.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace omniflight::proof {

double HungMass::hysteresis() const {
  if (height.empty()) return 0;
  const auto lowest = std::min_element(height.begin(), height.end()) - height.begin();
  std::map<long, std::array<std::vector<double>, 2>> bins;
  for (std::size_t i = 0; i < height.size(); ++i)
    bins[std::lround(height[i] / 0.05)][static_cast<std::ptrdiff_t>(i) > lowest].push_back(mass[i]);
  const auto median = [](std::vector<double>& x) {
    std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
    return x[x.size() / 2];
  };
  double largest = 0, scale = 0;
  for (auto& [key, way] : bins)
    if (way[0].size() > 2 && way[1].size() > 2)
      largest = std::max(largest, std::abs(median(way[0]) - median(way[1])));
  for (const Rest& r : rests) scale = std::max(scale, r.expected);
  return scale > 0 ? largest / scale : 0;
}

Result<HungMass> measure_hung_mass(const vehicle::Vehicle& vehicle, const World& world,
                                   const HungMassOptions& options) {
  if (!world.cable) return bad_input("has no cable to weigh", "world");
  if (options.heights.size() < 2 || !(options.speed > 0) || !(options.pause > 0))
    return bad_input("need two heights, a speed and a pause", "hung mass");
  PlantOptions start;
  start.initial.p_WB.z() = options.heights.front();
  auto plant = MujocoPlant::create(vehicle, world, start);
  if (!plant) return Failure(plant.error());
  std::vector<std::pair<double, bool>> stops;
  for (const double h : options.heights) stops.emplace_back(h, false);
  for (std::size_t i = options.heights.size() - 1; i-- > 0;) stops.emplace_back(options.heights[i], true);

  HungMass out;
  RigidState hold = start.initial;
  long steps = 0;
  double sum = 0;
  long counted = 0;
  const auto step = [&](bool count) -> Status {
    plant->hold_at(hold);
    if (auto ok = plant->step(true); !ok) return ok;
    const double mass = -plant->cable_force_W().z() / kGravity;
    if (steps++ % 10 == 0) {
      out.t.push_back(plant->time());
      out.height.push_back(hold.p_WB.z());
      out.mass.push_back(mass);
    }
    if (count) {
      sum += mass;
      ++counted;
    }
    return {};
  };
  for (const auto& [height, upward] : stops) {
    const double from = hold.p_WB.z(), way = height - from;
    // a half cosine, so that the rail does not jerk the cable
    const double time = std::abs(way) / options.speed * kPi / 2;
    const long n = std::lround(time / start.step);
    for (long k = 1; k <= n; ++k) {
      const double phase = kPi * static_cast<double>(k) / static_cast<double>(n);
      hold.p_WB.z() = from + 0.5 * way * (1 - std::cos(phase));
      hold.v_WB_W.z() = 0.5 * way * std::sin(phase) * kPi / time;
      if (auto ok = step(false); !ok) return Failure(ok.error());
    }
    hold.p_WB.z() = height;
    hold.v_WB_W.setZero();
    const long pause = std::lround(options.pause / start.step);
    sum = 0;
    counted = 0;
    for (long k = 0; k < pause; ++k)
      if (auto ok = step(2 * k >= pause); !ok) return Failure(ok.error());
    const double above =
        std::min(world.cable->length, height + world.cable->attachment_B.z() - world.floor_z);
    out.rests.push_back(
        {height, sum / static_cast<double>(counted), world.cable->linear_density * above, upward});
  }
  out.simulated = plant->time();
  return out;
}

}  // namespace omniflight::proof
