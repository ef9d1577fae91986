#include "peers.hpp"

namespace omniflight::benchmarks {

std::vector<Push> hover_pushes(const vehicle::Vehicle& vehicle, double carried_mass) {
  std::vector<Push> out;
  const double each = (vehicle.mass + carried_mass) * kGravity / static_cast<double>(vehicle.rotors.size());
  for (const auto& rotor : vehicle.rotors) out.push_back({rotor.p_BR, Vec3(0, 0, each)});
  return out;
}

}  // namespace omniflight::benchmarks
